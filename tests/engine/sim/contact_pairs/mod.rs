//! Contact and friction as a whole: rigid bodies with what carries them, and skin with a plate.

mod bodies;
mod incline;
mod skin;

use crate::support;

use std::sync::Arc;
use supple::Result;
use supple::glam::DVec3;
use supple::internal::math::Rows;
use supple::model::{
    Avatar, BoneMass, Integrator, JointList, PointSet, PoseBlend, Skeleton, SkinWeight, SoftLayer,
    UpAxis,
};
use supple::potential::CpuPotential;
use supple::sim::{Settings, Simulation, SolverMode};

const GRAVITY: f64 = 9.81;

const HALF: DVec3 = DVec3::new(0.02, 0.02, 0.01);

/// Free rigid blocks without tissue, each with a grid of vertices on its lower face.
fn blocks(count: usize) -> Avatar {
    let half = HALF.to_array();
    let mass = 8000.0 * HALF.x * HALF.y * HALF.z;
    let mut second_moment = [[0.0; 4]; 4];
    for axis in 0..3 {
        second_moment[axis][axis] = mass * half[axis] * half[axis] / 3.0;
    }
    second_moment[3][3] = mass;
    const GRID: usize = 5;
    let at = |k: usize| -1.0 + 2.0 * k as f64 / (GRID - 1) as f64;
    let grid = (0..GRID * GRID).map(|k| HALF * DVec3::new(at(k % GRID), at(k / GRID), -1.0));
    let grid: Vec<DVec3> = grid.collect();
    let vertices = count * grid.len();
    let empty = PointSet {
        position: Vec::new(),
        measure: Vec::new(),
        skinning: Rows::default(),
        basis: Rows::default(),
        pose_blend: PoseBlend::default(),
    };
    let skeleton = Skeleton {
        names: (0..count).map(|j| format!("block {j}")).collect(),
        parents: vec![None; count],
        joints: vec![DVec3::ZERO; count],
        aliases: Vec::new(),
        limits: Vec::new(),
    };
    let avatar = Avatar {
        name: "blocks".into(),
        joints: JointList::of_bones(&skeleton),
        up: UpAxis::Z,
        skeleton,
        bone_masses: vec![BoneMass { second_moment }; count],
        handles: Vec::new(),
        cubature: empty.clone(),
        skin: PointSet {
            position: (0..count).flat_map(|_| grid.clone()).collect(),
            measure: vec![4.0 * HALF.x * HALF.y / grid.len() as f64; vertices],
            skinning: (0..vertices)
                .map(|v| {
                    [SkinWeight {
                        bone: (v / grid.len()) as u32,
                        weight: 1.0,
                    }]
                })
                .collect(),
            basis: (0..vertices).map(|_| []).collect(),
            ..empty
        },
        triangles: Vec::new(),
        layer: SoftLayer {
            skin_embedding: (0..vertices).map(|_| []).collect(),
            ..SoftLayer::default()
        },
        ..support::full_space_limb(&support::SMALL, 1, true)
    };
    avatar.validate().unwrap();
    avatar
}

fn simulation(avatar: &Avatar, solver: SolverMode) -> Result<Simulation<CpuPotential>> {
    let potential = CpuPotential::new(Arc::new(avatar.clone()), 1)?;
    let settings = Settings {
        solver,
        integrator: Integrator::BackwardEuler,
        ..Settings::default()
    };
    Simulation::new(avatar, potential, settings)
}

const CONVERGED: SolverMode = SolverMode::Converged {
    tolerance: 1e-11,
    max_iterations: 100,
};
