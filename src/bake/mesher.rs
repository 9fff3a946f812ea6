//! Which mesher makes the layer of a body that comes without one.

use super::mesh::{ShellOptions, prism_shell};
use crate::Result;
use crate::model::{Body, LayerMesh};
use glam::DVec3;
use serde::{Deserialize, Serialize};

/// How the layer is meshed. A body that already has a layer keeps it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Mesher {
    /// A prism shell of two layers, 3 % of the body's largest extent deep.
    #[default]
    Auto,
    /// Layers of prisms under the skin.
    PrismShell(ShellOptions),
}

/// Depth of an automatic shell, relative to the body's largest extent.
const AUTOMATIC_DEPTH: f64 = 0.03;

impl Mesher {
    /// Meshes the layer of `body`.
    ///
    /// # Errors
    /// Those of the mesher: [`crate::Error::Invalid`] where skin or bones are open or an option is out
    /// of range.
    pub fn mesh(&self, body: &Body) -> Result<LayerMesh> {
        match *self {
            Self::Auto => {
                let positions = &body.skin.positions;
                let low = positions.iter().copied().fold(DVec3::INFINITY, DVec3::min);
                let high = (positions.iter().copied()).fold(DVec3::NEG_INFINITY, DVec3::max);
                let options = ShellOptions {
                    thickness: AUTOMATIC_DEPTH * (high - low).max_element(),
                    layers: 2,
                };
                prism_shell(&body.skin, &body.skinning, options)
            }
            Self::PrismShell(options) => prism_shell(&body.skin, &body.skinning, options),
        }
    }
}
