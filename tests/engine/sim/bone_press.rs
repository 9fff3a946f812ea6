//! The bone press on mesh S in its full space: the ground truth of everything reduced.

use crate::support;

use supple::collider::{Collider, Shape};
use supple::glam::DVec3;
use supple::model::{Frame, Integrator};
use supple::potential::CpuPotential;
use supple::sim::{Pin, Settings, Simulation, SolverMode, Stop};
use supple_bake::full_space_simulation;
use supple_samples::Limb;

/// The sphere of 3 cm, its centre at height `z`.
fn sphere(z: f64) -> Frame {
    Frame {
        position: DVec3::new(0.1, 0.0, z),
        ..Frame::IDENTITY
    }
}

/// Mesh S around its pinned bone, under the sphere.
fn press(time_step: f64, solver: SolverMode) -> Simulation<CpuPotential> {
    let settings = Settings {
        time_step,
        integrator: Integrator::BackwardEuler,
        solver,
        ..Settings::default()
    };
    let limb = support::full_space_limb(&Limb::S, 1, false);
    let (avatar, mut simulation) = full_space_simulation(&limb, 1, settings).unwrap();
    // The limb is in its full space already, by a construction of its own.
    assert_eq!(avatar.handles, limb.handles);
    let instance = &mut simulation.instances_mut()[0];
    let frame = instance.state.frames[0];
    instance.pins.push(Pin { bone: 0, frame });
    let ball = Shape::Sphere { radius: 0.03 };
    instance.colliders.push(Collider::new(ball, sphere(0.075)));
    simulation
}

#[test]
fn press_forces_on_mesh_s() {
    let solver = SolverMode::Converged {
        tolerance: 1e-7,
        max_iterations: 200,
    };
    // So long a step that inertia is nothing: each ends in equilibrium.
    let mut simulation = press(100.0, solver);
    for (depth, expected) in [(-0.002, 0.0), (0.006, 4.3), (0.009, 9.1), (0.012, 15.9)] {
        let instance = &mut simulation.instances_mut()[0];
        instance.colliders[0].frame = sphere(0.07 - depth);
        instance.history.rest(&instance.state);
        let report = simulation.step_blocking().unwrap().instances.remove(0);
        assert_eq!(report.stop, Stop::Converged);
        let force = -report.contact_force.z;
        println!(
            "{depth} m: {force:.3} N in {} iterations",
            report.iterations
        );
        let error = (force - expected).abs();
        assert!(
            error <= 0.05 * expected,
            "{force} N at {depth} m, expected {expected} N"
        );
        // What the pinned bone bears is the press and the weight; nothing else touches.
        let missing = report.contact_force + report.weight + report.loads[0].force;
        assert!(missing.length() < 1e-4, "{missing} N is missing");
    }
}

#[test]
fn one_iteration_a_step_ends_at_the_same_force() {
    let mut simulation = press(0.01, SolverMode::OneIteration);
    let (mut force, mut shift) = (0.0, 0.0f64);
    for step in 25..=100 {
        let u = f64::clamp((0.01 * step as f64 - 0.25) / 0.5, 0.0, 1.0);
        let instance = &mut simulation.instances_mut()[0];
        instance.colliders[0].frame = sphere(0.075 - 0.017 * u * u * (3.0 - 2.0 * u));
        let report = simulation.step_blocking().unwrap().instances.remove(0);
        force = -report.contact_force.z;
        shift = shift.max(report.diagonal_shift);
    }
    println!("{force:.3} N at t = 1 s");
    assert!((force - 15.9).abs() < 0.05 * 15.9, "{force} N");
    assert_eq!(shift, 0.0, "the solver's Hessian is positive definite");
}
