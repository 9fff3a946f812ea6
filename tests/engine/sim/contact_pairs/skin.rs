//! Skin dragged by a plate in full space.

use super::support;
use std::sync::Arc;
use supple::Result;
use supple::collider::{Collider, Shape};
use supple::glam::DVec3;
use supple::model::Frame;
use supple::potential::{CpuPotential, Potential};
use supple::sim::{Pin, Settings, Simulation, SolverMode, Stop};
use supple_bake::SparseCholesky;

/// In full space a plate drags the skin until all of it slides: then the drag is μ times the push.
#[test]
fn sliding_skin_is_dragged_by_its_friction() -> Result<()> {
    let avatar = support::full_space_limb(&support::SMALL, 1, true);
    let potential = CpuPotential::new(Arc::new(avatar.clone()), 1)?;
    let solver = Box::new(SparseCholesky::new(potential.pattern())?);
    let settings = Settings {
        solver: SolverMode::CONVERGED,
        ..Settings::default()
    };
    let mut simulation = Simulation::with_solver(&avatar, potential, settings, solver)?;
    let instance = &mut simulation.instances_mut()[0];
    let frame = instance.state.frames[0];
    instance.pins.push(Pin { bone: 0, frame });
    let plate = |x: f64| Frame {
        position: DVec3::new(x, 0.0, -0.037),
        ..Frame::IDENTITY
    };
    for direction in [1.0, -1.0] {
        simulation.instances_mut()[0].colliders = vec![Collider::new(Shape::HalfSpace, plate(0.0))];
        for _ in 0..5 {
            simulation.step_blocking()?;
        }
        simulation.instances_mut()[0].colliders[0].friction = 0.4;
        let mut force = DVec3::ZERO;
        for step in 1..=30 {
            let x = direction * 2e-3 * f64::from(step);
            simulation.instances_mut()[0].colliders[0].frame = plate(x);
            let report = simulation.step_blocking()?.instances.remove(0);
            assert_eq!(report.stop, Stop::Converged, "step {step}");
            force = report.contact_force;
        }
        assert!(force.z > 1.0, "{force}");
        let ratio = direction * force.x / force.z;
        assert!((ratio - 0.4).abs() < 1e-6, "{force}: ratio {ratio}");
    }
    Ok(())
}
