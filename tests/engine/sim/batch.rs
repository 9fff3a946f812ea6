//! Several instances at once, and the same bits every time.

use std::sync::Arc;
use supple::Result;
use supple::collider::{Collider, Shape};
use supple::glam::DVec3;
use supple::internal::{random_avatar, random_state};
use supple::model::Frame;
use supple::potential::CpuPotential;
use supple::sim::{Instance, Settings, Simulation, SolverMode, StepReport};
use supple::skeleton::Tracking;

/// Three states of one asset with everything different: pose, velocity, targets, colliders.
fn drive(instance: &mut Instance, k: usize, avatar: &supple::model::Avatar) {
    instance.state = random_state(10 + k as u64, avatar, 0.2, 0.004);
    let mut previous = instance.state.clone();
    for handle in &mut previous.handles {
        *handle *= 0.99;
    }
    (instance.history).set_previous(&previous, &instance.state, 0.01);
    instance.targets = vec![Tracking::new(k, avatar.skeleton.bind_pose()[k])];
    instance.gravity = DVec3::new(k as f64, 0.0, -9.0);
    let frame = Frame {
        position: DVec3::new(0.05, 0.0, 0.01 * k as f64),
        ..Frame::IDENTITY
    };
    instance.colliders = vec![
        Collider {
            stiffness: Some(1e6),
            margin: 1e-4,
            ..Collider::new(Shape::Sphere { radius: 0.04 }, frame)
        };
        k
    ];
}

type Run = (Vec<Instance>, Vec<StepReport>);

fn run(settings: Settings, which: &[usize]) -> Result<Run> {
    let avatar = random_avatar(3, 4, 9, 60, 60);
    let potential = CpuPotential::new(Arc::new(avatar.clone()), which.len())?;
    let mut simulation = Simulation::new(&avatar, potential, settings)?;
    for (instance, &k) in simulation.instances_mut().iter_mut().zip(which) {
        drive(instance, k, &avatar);
    }
    let reports = (0..8).map(|_| simulation.step_blocking());
    let reports = reports.collect::<Result<Vec<_>>>()?;
    Ok((simulation.instances().to_vec(), reports))
}

fn modes() -> [Settings; 2] {
    [
        SolverMode::OneIteration,
        SolverMode::Converged {
            tolerance: 1e-7,
            max_iterations: 30,
        },
    ]
    .map(|solver| Settings {
        solver,
        ..Settings::default()
    })
}

#[test]
fn three_at_once_are_three_alone_bit_for_bit() -> Result<()> {
    for settings in modes() {
        let (together, reports) = run(settings, &[0, 1, 2])?;
        let mut iterations = Vec::new();
        for k in 0..3 {
            let (alone, lone_reports) = run(settings, &[k])?;
            assert_eq!(together[k].state, alone[0].state, "instance {k}");
            for (report, lone) in reports.iter().zip(&lone_reports) {
                assert_eq!(report.instances[k], lone.instances[0], "instance {k}");
            }
            iterations.push(
                lone_reports
                    .iter()
                    .map(|r| r.instances[0].iterations)
                    .sum::<usize>(),
            );
        }
        if settings.solver != SolverMode::OneIteration {
            assert!(iterations[0] != iterations[1] || iterations[1] != iterations[2]);
        }
    }
    Ok(())
}

#[test]
fn the_same_input_gives_the_same_bits() -> Result<()> {
    for settings in modes() {
        let (a, _) = run(settings, &[2, 1])?;
        let (b, _) = run(settings, &[2, 1])?;
        assert_eq!(a[0].state, b[0].state);
        assert_eq!(a[1].state, b[1].state);
    }
    Ok(())
}

#[test]
fn an_absurd_velocity_is_an_error_or_a_finite_state() -> Result<()> {
    for speed in [1e3, 1e12, 1e100, 1e300] {
        let avatar = random_avatar(3, 4, 9, 60, 60);
        let potential = CpuPotential::new(Arc::new(avatar.clone()), 1)?;
        let mut simulation = Simulation::new(&avatar, potential, Settings::default())?;
        let instance = &mut simulation.instances_mut()[0];
        instance.state.handles[0] = DVec3::X * speed;
        let before = instance.state.clone();
        match simulation.step_blocking() {
            Err(_) => assert_eq!(simulation.instances()[0].state, before),
            Ok(_) => assert!(simulation.instances()[0].state.is_finite()),
        }
    }
    Ok(())
}
