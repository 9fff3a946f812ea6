//! What was measured in the last seconds, for plots.

use std::collections::VecDeque;

/// How much is kept, s.
const KEPT: f64 = 10.0;

/// What a step said.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sample {
    /// s.
    pub time: f64,
    /// Of contact on the character, N.
    pub force: f64,
    /// Of the spring that holds it, N.
    pub pull: f64,
    /// The largest of its tissue, m.
    pub displacement: f64,
    /// Vertices that touch.
    pub contacts: usize,
    /// Newton's iterations.
    pub iterations: usize,
}

/// The last seconds.
#[derive(Clone, Debug, Default)]
pub struct Measures {
    samples: VecDeque<Sample>,
}

impl Measures {
    /// Adds a step, and forgets what is long ago.
    pub fn add(&mut self, sample: Sample) {
        let kept = |first: &Sample| first.time < sample.time - KEPT;
        while self.samples.front().is_some_and(kept) {
            self.samples.pop_front();
        }
        self.samples.push_back(sample);
    }

    /// Of the last step, s.
    pub fn now(&self) -> f64 {
        self.last().time
    }

    /// The last step's.
    pub fn last(&self) -> Sample {
        self.samples.back().copied().unwrap_or_default()
    }

    /// All of them, oldest first.
    pub fn samples(&self) -> std::collections::vec_deque::Iter<'_, Sample> {
        self.samples.iter()
    }

    /// How long ago the oldest may be, s.
    pub fn span() -> f64 {
        KEPT
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_long_ago_is_forgotten() {
        let mut measures = Measures::default();
        for step in 0..3000 {
            let time = 0.01 * f64::from(step);
            measures.add(Sample {
                time,
                ..Sample::default()
            });
        }
        let first = measures.samples().next().unwrap().time;
        assert!((measures.now() - first - KEPT).abs() < 0.02, "{first}");
    }
}
