//! Which mesher makes the layer of a body that comes without one.

use super::{LatticeSize, MeshReport, ShellOptions, mesh_lattice, mesh_shell};
use crate::body::Body;
use crate::bones::BoneLoads;
use serde::{Deserialize, Serialize};
use supple::Result;
use supple::model::Skeleton;

/// How the layer is meshed. A body that already has a layer keeps it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Mesher {
    /// A lattice of 20,000 nodes where bone surfaces are given and in hands, a prism shell of default
    /// depth in other bodies. A hand is a skeleton in which chains from the children of one bone, four of
    /// them or more, each of three bones or more without a branch, hold three quarters of all bones; bones
    /// below which no skin hangs do not count.
    #[default]
    Auto,
    /// A lattice between the skin and the surfaces of the bones; capsules from joints and skin weights
    /// where none are given.
    Lattice(LatticeSize),
    /// Layers of prisms under the skin.
    PrismShell(ShellOptions),
}

/// Nodes of an automatic lattice: the paper's hand has 20,214.
const AUTOMATIC_NODES: usize = 20_000;

impl Mesher {
    /// Meshes the layer of `body`: sets its layer, turns its skin where that looks inward, and gives it
    /// the bone surfaces that were derived. The report says what was found and done.
    ///
    /// # Errors
    /// [`supple::Error::Invalid`] where numbers are not finite, indices name nothing, an option is out of
    /// range, a given bone surface is open, or a vertex has no bone. Holes, self-intersections and other
    /// faults of a skin are no errors.
    pub fn mesh(&self, body: &mut Body) -> Result<MeshReport> {
        match self {
            Self::Auto => {
                let size = LatticeSize::Nodes(AUTOMATIC_NODES);
                let given = body.bone_surfaces.iter().any(|b| !b.triangles.is_empty());
                if given {
                    mesh_lattice(body, size, "chosen for its bone surfaces")
                } else if is_hand(&body.skeleton, &BoneLoads::of(body).mass) {
                    mesh_lattice(body, size, "chosen for a hand")
                } else {
                    mesh_shell(body, &ShellOptions::default(), "chosen for a body")
                }
            }
            Self::Lattice(size) => mesh_lattice(body, *size, "as asked for"),
            Self::PrismShell(options) => mesh_shell(body, options, "as asked for"),
        }
    }
}

/// Least number of fingers, of bones in each, and of the bones that are in fingers.
const FINGERS: usize = 4;
const FINGER_BONES: usize = 3;
const IN_FINGERS: f64 = 0.75;

/// Whether chains from the children of one bone make up the skeleton, as far as its bones are `loaded`.
fn is_hand(skeleton: &Skeleton, loaded: &[bool]) -> bool {
    let mut children = vec![Vec::new(); skeleton.len()];
    for (j, parent) in skeleton.parents.iter().enumerate() {
        if let Some(p) = parent.filter(|_| loaded[j]) {
            children[p as usize].push(j);
        }
    }
    // Bones of the unbranched chain from `first` to its end.
    let chain = |first: usize| {
        let (mut last, mut count) = (first, 1);
        while let [next] = children[last][..] {
            (last, count) = (next, count + 1);
        }
        children[last].is_empty().then_some(count)
    };
    let count = loaded.iter().filter(|l| **l).count();
    children.iter().any(|fingers| {
        let chains: Vec<usize> = (fingers.iter())
            .filter_map(|&f| chain(f))
            .filter(|&count| count >= FINGER_BONES)
            .collect();
        let bones = chains.iter().sum::<usize>() as f64;
        chains.len() >= FINGERS && bones >= IN_FINGERS * count as f64
    })
}
