//! How many steps a frame takes.

/// Most steps of a frame: where they take longer than the time that they stand for, time goes slower.
const MOST: usize = 4;

/// Whether time goes on, and how fast.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pace {
    /// Whether it stands still.
    pub paused: bool,
    /// Seconds a second.
    pub speed: f64,
    /// Time that no step has been made for, s.
    owed: f64,
    /// Steps that were asked for one by one.
    single: usize,
}

impl Default for Pace {
    fn default() -> Self {
        Self {
            paused: false,
            speed: 1.0,
            owed: 0.0,
            single: 0,
        }
    }
}

impl Pace {
    /// Stands still, but for one step.
    pub fn step_once(&mut self) {
        self.paused = true;
        self.single += 1;
    }

    /// From fast to slow motion and back.
    pub fn toggle_slow(&mut self) {
        self.speed = if self.speed == 1.0 { 0.2 } else { 1.0 };
    }

    /// The steps of `time_step` (s) in a frame that comes `seconds` after the last.
    pub fn steps(&mut self, seconds: f64, time_step: f64) -> usize {
        if self.paused {
            self.owed = 0.0;
            return std::mem::take(&mut self.single);
        }
        self.owed += self.speed * seconds.max(0.0);
        // Rounding must not swallow a step.
        let whole = (self.owed / time_step + 1e-9).floor();
        let steps = (whole as usize).min(MOST);
        self.owed = (self.owed - whole * time_step).max(0.0);
        steps
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn time_is_paid_in_steps_and_not_hoarded() {
        let mut pace = Pace::default();
        let frames = (0..60).map(|_| pace.steps(1.0 / 60.0, 0.01));
        assert!((99..=100).contains(&frames.sum::<usize>()));
        assert_eq!(pace.steps(5.0, 0.01), MOST);
        assert!(pace.steps(0.0, 0.01) <= 1);
        pace.toggle_slow();
        let slow: usize = (0..60).map(|_| pace.steps(1.0 / 60.0, 0.01)).sum();
        assert!((19..=20).contains(&slow), "{slow}");
        pace.step_once();
        assert_eq!([pace.steps(1.0, 0.01), pace.steps(1.0, 0.01)], [1, 0]);
    }
}
