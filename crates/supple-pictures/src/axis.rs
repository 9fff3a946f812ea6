//! What the axes of curves span, and their marks.

use crate::curves::Scale;
use crate::number;

/// What an axis spans.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Extent {
    pub low: f64,
    pub high: f64,
    pub scale: Scale,
}

impl Extent {
    /// Of all `values`; none where there is none.
    pub fn of(values: impl Iterator<Item = f64>, scale: Scale) -> Option<Self> {
        let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| {
            (l.min(v), h.max(v))
        });
        (low <= high).then_some(Self { low, high, scale })
    }

    /// Down to 0 where that lies near: a length that falls by a third is then seen to fall by a third.
    pub fn reach_zero(&mut self) {
        if self.scale == Scale::Linear && self.low > 0.0 && self.low < 0.75 * self.high {
            self.low = 0.0;
        }
    }

    /// A little wider.
    pub fn widen(&mut self) {
        let (low, high) = (self.low, self.high);
        let room = match self.scale {
            Scale::Logarithmic => {
                (self.low, self.high) = (low / 1.3, high * 1.3);
                return;
            }
            Scale::Linear if high > low => 0.04 * (high - low),
            Scale::Linear => 0.5 * high.abs().max(1.0),
        };
        self.high = high + room;
        self.low = if low == 0.0 { low } else { low - room };
    }

    /// Powers of ten; with their doubles and fivefolds where there would be few.
    pub fn marks(&self) -> Vec<f64> {
        let (first, last) = (self.low.log10().floor(), self.high.log10().ceil());
        let steps: &[f64] = match last - first {
            decades if decades <= 3.0 => &[1.0, 2.0, 5.0],
            _ => &[1.0],
        };
        // Not more than a dozen.
        let stride = ((last - first) / 12.0).ceil().max(1.0) as usize;
        (first as i32..=last as i32)
            .step_by(stride)
            .flat_map(|power| steps.iter().map(move |s| s * 10f64.powi(power)))
            .filter(|mark| (self.low..=self.high).contains(mark))
            .collect()
    }

    /// `value` at a mark: what the sum of steps leaves at 0 is 0.
    pub fn label(&self, value: f64) -> String {
        let nothing = 1e-9 * (self.high - self.low);
        let seen = match self.scale {
            Scale::Linear if value.abs() < nothing => 0.0,
            _ => value,
        };
        number(seen)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_reach_zero_where_it_is_near_and_have_marks() {
        let extent = |low, high, scale| {
            let mut extent = Extent { low, high, scale };
            extent.reach_zero();
            extent
        };
        assert_eq!(extent(60.0, 90.0, Scale::Linear).low, 0.0);
        assert_eq!(extent(80.0, 90.0, Scale::Linear).low, 80.0);
        let decade = extent(1.5, 15.0, Scale::Logarithmic);
        assert_eq!(decade.marks(), [2.0, 5.0, 10.0]);
        assert!(extent(1e-15, 1e15, Scale::Logarithmic).marks().len() <= 13);
        assert_eq!(extent(-0.3, 0.3, Scale::Linear).label(-2.8e-17), "0");
    }
}
