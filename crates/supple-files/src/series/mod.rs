//! What a run did, step by step, as arrays: NumPy archives, `.npz`.
//!
//! | array | shape | |
//! |---|---|---|
//! | `time` | steps | the end of each step, s |
//! | `vertices` | steps × vertices × 3 | the posed skin, m, in the world |
//! | `displacement` | steps × vertices × 3 | how far tissue is off the skinned shape, before the pose, m |
//! | `contact_force` | steps × vertices × 3 | contact and friction on each vertex, N, world axes |
//! | `loads` | steps × bones × 6 | force (N) and torque (N·m) that targets and pins exert on each bone |
//! | `energies` | steps × 13 | E(q) − E(qⁿ) of each step term by term, J |
//! | `energy_names` | 13 | what these terms are |
//! | `faces` | faces × 3 | triangles of the skin |
//! | `bone_names` | bones | |
//!
//! Bones are those of the avatar in its own order, and so are vertices.

mod read;
mod write;

pub use read::{parse_series, read_series};
pub use write::write_series;

use glam::DVec3;
use supple::sim::{Load, StepEnergies};

/// Number of the terms of [`StepEnergies`].
pub const ENERGY_TERMS: usize = 13;

/// Names of the terms of [`StepEnergies`], the tissue's before the skeleton's.
pub const ENERGY_NAMES: [&str; ENERGY_TERMS] = [
    "inertia",
    "gravity",
    "elastic",
    "damping",
    "contact",
    "friction",
    "bone_inertia",
    "joint",
    "bending",
    "limit",
    "tracking",
    "bone_gravity",
    "preload",
];

/// The terms of `energies`, J, in the order of [`ENERGY_NAMES`].
pub fn energy_terms(energies: &StepEnergies) -> [f64; ENERGY_TERMS] {
    let (tissue, skeleton) = (&energies.tissue, &energies.skeleton);
    [
        tissue.inertia,
        tissue.gravity,
        tissue.elastic,
        tissue.damping,
        tissue.contact,
        tissue.friction,
        skeleton.inertia,
        skeleton.joint,
        skeleton.bending,
        skeleton.limit,
        skeleton.tracking,
        skeleton.gravity,
        skeleton.preload,
    ]
}

/// What targets and pins exert on each of `bones`: force, N, and torque, N·m, about its joint; 0 where nothing does.
pub fn loads_by_bone(loads: &[Load], bones: usize) -> Vec<[f64; 6]> {
    let mut out = vec![[0.0; 6]; bones];
    for load in loads.iter().filter(|load| load.bone < bones) {
        let sums = load
            .force
            .to_array()
            .into_iter()
            .chain(load.torque.to_array());
        (out[load.bone].iter_mut().zip(sums)).for_each(|(sum, value)| *sum += value);
    }
    out
}

/// A run as arrays; see the table of [`write_series`]'s file in its module.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Series {
    /// The end of each step, s.
    pub time: Vec<f64>,
    /// Posed skin of each step, one vertex after the other, m.
    pub vertices: Vec<DVec3>,
    /// As many: displacement before the pose, m.
    pub displacement: Vec<DVec3>,
    /// As many: contact and friction, N.
    pub contact_force: Vec<DVec3>,
    /// Of each step, bone after bone: force, N, and torque, N·m.
    pub loads: Vec<[f64; 6]>,
    /// Of each step, in the order of [`ENERGY_NAMES`], J.
    pub energies: Vec<[f64; ENERGY_TERMS]>,
    /// Triangles of the skin.
    pub faces: Vec<[u32; 3]>,
    /// Bones.
    pub bone_names: Vec<String>,
}

#[cfg(test)]
mod tests;
