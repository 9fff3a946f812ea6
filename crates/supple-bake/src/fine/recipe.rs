//! What a bake of fine handles is asked for.

use crate::basis::Truncation;
use serde::{Deserialize, Serialize};
use supple::{Error, Result};

/// How fine handles are made. Without it there are none.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct FineRecipe {
    /// No soft skin is farther from a handle than this, m. A quarter of the coarse handles' median spacing where it is not
    /// given. The skin's own vertices and, where skin lies inside tets, the tets' edges set the limit.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub spacing: Option<f64>,
    /// How the columns go on below the skin.
    pub extension: FineExtension,
    /// Blocks below the skin that are smaller than this are dropped, up to three times as large ones made smaller; 1 is
    /// the identity.
    pub drop_below: f64,
    /// Cubature points for each fine handle, where the layer has so many tets.
    pub points_per_handle: f64,
}

/// How the columns of fine handles go on below the skin.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FineExtension {
    /// As an elastic body would follow its skin: 3×3 blocks.
    #[default]
    Elastic,
    /// As the coarse handles' columns do: numbers.
    Biharmonic,
}

impl Default for FineRecipe {
    fn default() -> Self {
        Self {
            spacing: None,
            extension: FineExtension::default(),
            drop_below: 0.01,
            points_per_handle: 10.0,
        }
    }
}

impl FineRecipe {
    /// Checks the numbers.
    ///
    /// # Errors
    /// [`Error::Invalid`] naming the key.
    pub fn validate(&self) -> Result<()> {
        let key = |ok: bool, key: &str, problem: String| match ok {
            true => Ok(()),
            false => Err(Error::invalid(format!("fine_handles.{key}"), problem)),
        };
        if let Some(spacing) = self.spacing {
            let positive = spacing > 0.0 && spacing.is_finite();
            key(
                positive,
                "spacing",
                format!("must be positive (m), is {spacing}"),
            )?;
        }
        let below = self.drop_below;
        let small = (0.0..0.3).contains(&below);
        key(small, "drop_below", format!("must be 0 to 0.3, is {below}"))?;
        let points = self.points_per_handle;
        let some = points > 0.0 && points.is_finite();
        key(
            some,
            "points_per_handle",
            format!("must be positive, is {points}"),
        )
    }

    /// How blocks below the skin are truncated.
    pub(crate) fn blocks(&self) -> Truncation {
        Truncation {
            enabled: self.drop_below > 0.0,
            below: self.drop_below,
            above: 3.0 * self.drop_below,
            keep_sway: None,
        }
    }
}
