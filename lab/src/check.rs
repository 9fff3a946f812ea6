//! Measured values with their bounds.

use serde::Serialize;
use supple_pictures::number;

/// Where a value must lie; a value that is not finite lies nowhere.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Bound {
    /// At or below.
    AtMost(f64),
    /// At or above.
    AtLeast(f64),
    /// From the first to the second.
    Within(f64, f64),
}

impl Bound {
    /// Whether `value` lies there.
    pub fn holds(self, value: f64) -> bool {
        value.is_finite()
            && match self {
                Self::AtMost(most) => value <= most,
                Self::AtLeast(least) => value >= least,
                Self::Within(least, most) => (least..=most).contains(&value),
            }
    }
}

impl std::fmt::Display for Bound {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match *self {
            Self::AtMost(most) => write!(f, "≤ {}", number(most)),
            Self::AtLeast(least) => write!(f, "≥ {}", number(least)),
            Self::Within(least, most) => write!(f, "{} to {}", number(least), number(most)),
        }
    }
}

/// A measured value and what it must be.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Check {
    /// What was measured.
    pub what: String,
    /// What came out.
    pub value: f64,
    /// Its unit; empty of a ratio.
    pub unit: &'static str,
    /// Where it must lie.
    pub bound: Bound,
}

impl Check {
    /// Whether it does.
    pub fn holds(&self) -> bool {
        self.bound.holds(self.value)
    }
}

impl std::fmt::Display for Check {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (value, gap) = (
            number(self.value),
            if self.unit.is_empty() { "" } else { " " },
        );
        write!(
            f,
            "{}: {value}{gap}{}, must be {}",
            self.what, self.unit, self.bound
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounds_hold_at_their_ends_and_never_of_nan() {
        for bound in [
            Bound::AtMost(2.0),
            Bound::AtLeast(2.0),
            Bound::Within(2.0, 2.0),
        ] {
            assert!(bound.holds(2.0), "{bound}");
            assert!(
                !bound.holds(f64::NAN) && !bound.holds(f64::INFINITY),
                "{bound}"
            );
            assert!(!(bound.holds(1.9) && bound.holds(2.1)), "{bound}");
        }
        assert!(Bound::AtMost(2.0).holds(1.9) && Bound::AtLeast(2.0).holds(2.1));
    }
}
