//! The bone press in equilibrium, 12 mm deep, in any space: what reduced models are measured with.

use std::sync::Arc;
use supple::bake::{HandlePlace, HandleRegion, Recipe, Truncation, bake};
use supple::collider::{Collider, Shape};
use supple::glam::DVec3;
use supple::material::{Material, StableNeoHookean};
use supple::model::{Avatar, Frame};
use supple::potential::Potential;
use supple::reference::{Reference, min_det_f};
use supple::sample::Limb;
use supple::sim::{LinearSolver, Pin, Settings, Simulation, SolverMode, SparseCholesky};

/// What a press ends in.
#[allow(dead_code, reason = "every user reads its own part")]
pub struct Pressed {
    /// Displacement of the skin from rest, m.
    pub displacement: Vec<DVec3>,
    /// What the sphere is pushed back with, N.
    pub force: f64,
    /// Smallest det F over all tets.
    pub min_det_f: f64,
}

/// The sphere of the benchmark (3 cm) pressed 12 mm into `avatar`, in steps so long that inertia is
/// nothing. `sparse` picks the solver that the full space wants.
pub fn press(avatar: &Avatar, sparse: bool) -> Pressed {
    let sphere = |depth: f64| Frame {
        position: DVec3::new(0.1, 0.0, 0.07 - depth),
        ..Frame::IDENTITY
    };
    let potential = Reference::new(Arc::new(avatar.clone()), 1, 1000).unwrap();
    let settings = Settings {
        time_step: 100.0,
        solver: SolverMode::Converged {
            tolerance: 1e-6,
            max_iterations: 100,
        },
        ..Settings::default()
    };
    let mut simulation = if sparse {
        let solver: Box<dyn LinearSolver + Send + Sync> =
            Box::new(SparseCholesky::new(potential.pattern()).unwrap());
        Simulation::with_solver(avatar, potential, settings, solver).unwrap()
    } else {
        Simulation::new(avatar, potential, settings).unwrap()
    };
    let instance = &mut simulation.instances_mut()[0];
    let frame = instance.state.frames[0];
    instance.pins.push(Pin { bone: 0, frame });
    let ball = Shape::Sphere { radius: 0.03 };
    instance.colliders.push(Collider::new(ball, sphere(0.0)));
    let mut force = 0.0;
    for depth in [0.0, 0.004, 0.008, 0.012] {
        let instance = &mut simulation.instances_mut()[0];
        instance.colliders[0].frame = sphere(depth);
        instance.previous = instance.state.clone();
        force = -simulation.step_blocking().unwrap().instances[0]
            .contact_force
            .z;
    }
    let (mut skin, mut normals) = (Vec::new(), Vec::new());
    simulation
        .read_skin_blocking(0, &mut skin, &mut normals)
        .unwrap();
    let rest = &avatar.skin.position;
    Pressed {
        displacement: skin.iter().zip(rest).map(|(x, rest)| *x - *rest).collect(),
        force,
        min_det_f: min_det_f(&avatar.layer, &simulation.instances()[0].state),
    }
}

/// ‖a − b‖ / ‖b‖ over the skin.
pub fn relative_error(a: &Pressed, b: &Pressed) -> f64 {
    let square = |v: &mut dyn Iterator<Item = DVec3>| v.map(|d| d.length_squared()).sum::<f64>();
    let pairs = a.displacement.iter().zip(&b.displacement);
    let difference = square(&mut pairs.map(|(a, b)| *a - *b));
    (difference / square(&mut b.displacement.iter().copied())).sqrt()
}

/// The limb (mesh S) with `count` handles, on all of its skin or in the volume around the contact.
pub fn reduced(place: HandlePlace, count: usize, truncation: Truncation) -> Avatar {
    let around_contact = [[0.04, -0.045, -0.005], [0.16, 0.045, 0.045]];
    let recipe = Recipe {
        material: Some(Material::StableNeoHookean(StableNeoHookean {
            youngs_modulus: 30e3,
            poissons_ratio: 0.4,
        })),
        handles: vec![HandleRegion {
            place,
            count: Some(count),
            within: (place == HandlePlace::Volume).then_some(around_contact),
            ..HandleRegion::default()
        }],
        truncation,
        captured_under_gravity: false,
        ..Recipe::default()
    };
    let mut silent = |_: usize| {};
    bake(&Limb::S.body().unwrap(), &recipe, &mut silent)
        .unwrap()
        .0
}
