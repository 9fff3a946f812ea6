//! Units of length.

use serde::{Deserialize, Serialize};
use supple::{Error, Result};

/// A unit of length: its name (`m`, `cm`, `mm`, `in`, `ft`) or its metres.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Unit {
    /// So many metres.
    Metres(f64),
    /// By name.
    Name(String),
}

impl Unit {
    /// Its length, m.
    ///
    /// # Errors
    /// [`Error::Invalid`] of a name that is not known or a length that is not positive.
    pub fn metres(&self) -> Result<f64> {
        let metres = match self {
            Self::Metres(m) => *m,
            Self::Name(name) => match name.as_str() {
                "m" => 1.0,
                "cm" => 0.01,
                "mm" => 0.001,
                "in" | "inch" => 0.0254,
                "ft" => 0.3048,
                _ => {
                    let problem =
                        format!("{name:?} is not known: m, cm, mm, in, ft or a number of metres");
                    return Err(Error::invalid("unit", problem));
                }
            },
        };
        if metres > 0.0 && metres.is_finite() {
            Ok(metres)
        } else {
            Err(Error::invalid(
                "unit",
                "must be a positive number of metres",
            ))
        }
    }
}
