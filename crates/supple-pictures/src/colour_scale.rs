//! Numbers as colours.

use super::{Colour, colour_map, diverging_map};

/// Which colours stand for which numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ColourScale {
    /// Value of the first colour.
    pub low: f64,
    /// Value of the last colour.
    pub high: f64,
    /// Whether the middle is neutral, and both sides have hues of their own.
    pub diverging: bool,
}

impl ColourScale {
    /// From 0 (cream) to `high` (dark violet).
    pub fn up_to(high: f64) -> Self {
        Self {
            low: 0.0,
            high,
            diverging: false,
        }
    }

    /// From 0 to the largest of `values`.
    pub fn of(values: impl IntoIterator<Item = f64>) -> Self {
        Self::up_to(values.into_iter().fold(0.0, f64::max))
    }

    /// From `spread` below `middle` (blue) to as much above it (red).
    pub fn about(middle: f64, spread: f64) -> Self {
        Self {
            low: middle - spread,
            high: middle + spread,
            diverging: true,
        }
    }

    /// The colour of `value`; beyond the ends it is that of the end, and NaN has the first one.
    pub fn colour(&self, value: f64) -> Colour {
        let t = (value - self.low) / (self.high - self.low).max(f64::MIN_POSITIVE);
        match self.diverging {
            true => diverging_map(2.0 * t - 1.0),
            false => colour_map(t),
        }
    }

    /// A colour for each value.
    pub fn colours(&self, values: impl IntoIterator<Item = f64>) -> Vec<Colour> {
        values.into_iter().map(|v| self.colour(v)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ends_have_the_ends_colours() {
        let scale = ColourScale::up_to(4.0);
        assert_eq!(scale.colour(4.0), colour_map(1.0));
        assert_eq!(scale.colour(f64::NAN), colour_map(0.0));
        assert_eq!(ColourScale::of([]).colour(0.0), colour_map(0.0));
        let scale = ColourScale::about(3.0, 2.0);
        assert_eq!(scale.colour(1.0), diverging_map(-1.0));
        assert_eq!(scale.colour(3.0), diverging_map(0.0));
        assert_eq!(scale.colour(99.0), diverging_map(1.0));
    }
}
