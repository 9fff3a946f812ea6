//! The bone press on mesh S in its full space: the ground truth of everything reduced.

mod support;

use std::sync::Arc;
use supple::collider::{Collider, Shape};
use supple::glam::DVec3;
use supple::model::Frame;
use supple::reference::Reference;
use supple::sample::Limb;
use supple::sim::{Pin, Settings, Simulation, SolverMode, SparseCholesky, Stop};

/// A sphere of 3 cm that stands `press` m inside the limb's skin.
fn sphere(press: f64) -> Frame {
    Frame {
        position: DVec3::new(0.1, 0.0, 0.07 - press),
        ..Frame::IDENTITY
    }
}

#[test]
fn press_forces_on_mesh_s() {
    let avatar = support::full_space_limb(&Limb::S, 1, false);
    let potential = Reference::new(Arc::new(avatar.clone()), 1, 1000).unwrap();
    let solver = SparseCholesky::new(supple::potential::Potential::pattern(&potential)).unwrap();
    // So long a step that inertia is nothing: each ends in equilibrium.
    let settings = Settings {
        time_step: 100.0,
        solver: SolverMode::Converged {
            tolerance: 1e-7,
            max_iterations: 200,
        },
        ..Settings::default()
    };
    let mut simulation =
        Simulation::with_solver(&avatar, potential, settings, Box::new(solver)).unwrap();
    let instance = &mut simulation.instances_mut()[0];
    let frame = instance.state.frames[0];
    instance.pins.push(Pin { bone: 0, frame });
    instance.colliders.push(Collider {
        shape: Shape::Sphere { radius: 0.03 },
        frame: sphere(-0.002),
        previous: sphere(-0.002),
        stiffness: 1e8,
        margin: 0.0,
    });
    for (press, expected) in [
        (-0.002, 0.0),
        (0.003, f64::NAN),
        (0.006, 4.3),
        (0.009, 9.1),
        (0.012, 15.9),
    ] {
        let instance = &mut simulation.instances_mut()[0];
        instance.colliders[0].frame = sphere(press);
        instance.previous = instance.state.clone();
        let report = simulation.step_blocking().unwrap();
        let [report] = report.instances.try_into().unwrap();
        println!(
            "{press}: {:?} {} {} {}",
            report.stop, report.iterations, report.contact_force, report.contacts
        );
        assert_eq!(report.stop, Stop::Converged);
        let force = -report.contact_force.z;
        if expected > 0.0 {
            assert!(
                (force / expected - 1.0).abs() < 0.05,
                "{press} m: {force} N, expected {expected}"
            );
        }
    }
}
