//! What must hold at rest: the parametric shape where nothing touches, joints under load, and the
//! balance of contact, weight and what holds the bones.

use crate::support;

use std::sync::Arc;
use supple::Result;
use supple::collider::{Collider, Shape};
use supple::glam::{DMat3, DVec3};
use supple::internal::cpu::mechanics;
use supple::internal::math::rotation_exp;
use supple::model::{Avatar, Frame, Integrator};
use supple::potential::{CpuPotential, Evaluation, Potential};
use supple::sim::{Pin, Settings, Simulation, SolverMode};
use supple::skeleton::{Preload, Tracking};

fn simulation(avatar: &Avatar, settings: Settings) -> Simulation<CpuPotential> {
    let potential = CpuPotential::new(Arc::new(avatar.clone()), 1).unwrap();
    Simulation::new(avatar, potential, settings).unwrap()
}

/// A bent pose.
fn bent(avatar: &Avatar) -> Vec<Frame> {
    let angles = [
        DVec3::new(0.3, -0.2, 0.1),
        DVec3::new(0.1, 0.6, -0.2),
        DVec3::new(-0.2, 0.8, 0.3),
    ];
    avatar
        .skeleton
        .forward_kinematics(&angles.map(rotation_exp), DVec3::new(0.1, 0.2, 0.3))
}

#[test]
fn without_gravity_a_static_pose_is_forward_kinematics() -> Result<()> {
    let avatar = support::full_space_limb(&support::SMALL, 3, true);
    let mut simulation = simulation(&avatar, Settings::default());
    let frames = bent(&avatar);
    let instance = &mut simulation.instances_mut()[0];
    instance.gravity = DVec3::ZERO;
    instance.pose(&frames, &avatar.skeleton.parents);
    instance.targets = vec![Tracking::new(0, frames[0])];
    let start = instance.state.clone();
    for _ in 0..50 {
        simulation.step_blocking()?;
    }
    let state = &simulation.instances()[0].state;
    let [a, b] = [&start, state].map(|q| support::posed(&avatar, &avatar.skin, q));
    let error = support::largest_distance(&a, &b);
    assert!(error < 1e-12, "{error:e} m");
    Ok(())
}

/// Method §8 has springs sag by up to 0.1 mm; loaded beforehand they do not sag at all, for a shape that was captured under
/// gravity and for one that was not once it has settled. Bounds of motion.md §6.
#[test]
fn at_rest_under_gravity_nothing_moves_that_is_preloaded_and_settled() -> Result<()> {
    for captured in [true, false] {
        for (preload, targets) in [(Preload::Targets, true), (Preload::Pose, false)] {
            let avatar = support::full_space_limb(&support::SMALL, 3, captured);
            let mut simulation = simulation(&avatar, Settings::default());
            let frames = bent(&avatar);
            let instance = &mut simulation.instances_mut()[0];
            instance.pose(&frames, &avatar.skeleton.parents);
            instance.preload = preload;
            if targets {
                let targets = frames.iter().enumerate();
                instance.targets = targets.map(|(j, f)| Tracking::new(j, *f)).collect();
            } else {
                let frame = frames[0];
                instance.pins.push(Pin { bone: 0, frame });
            }
            if !captured {
                let last = simulation.settle_blocking()?;
                assert!(last < 1e-7, "{last:e} m");
            }
            let start = simulation.instances()[0].state.clone();
            let sagged = start.handles.iter().map(|h| h.length()).fold(0.0, f64::max);
            assert_eq!(sagged == 0.0, captured, "{sagged:e} m");
            for _ in 0..60 {
                simulation.step_blocking()?;
            }
            let state = &simulation.instances()[0].state;
            let [a, b] = [&start, state].map(|q| support::posed(&avatar, &avatar.skin, q));
            let moved = support::largest_distance(&a, &b);
            assert!(
                moved < 1e-5,
                "captured {captured}, {preload:?}: the skin moved {moved:e} m"
            );
            let swung = start.handles.iter().zip(&state.handles);
            let swung = swung.map(|(a, b)| a.distance(*b)).fold(0.0, f64::max);
            assert!(
                swung < 1e-6,
                "captured {captured}, {preload:?}: φ {swung:e} m"
            );
        }
    }
    Ok(())
}

/// What settles is where damped steps come to rest, and without preload springs sag.
#[test]
fn settling_is_where_a_long_run_ends() -> Result<()> {
    let avatar = support::full_space_limb(&support::SMALL, 3, false);
    let settings = Settings {
        integrator: Integrator::BackwardEuler,
        time_step: 0.05,
        ..Settings::default()
    };
    let mut ends = Vec::new();
    for settle in [false, true] {
        let mut simulation = simulation(&avatar, settings);
        let instance = &mut simulation.instances_mut()[0];
        let frame = instance.state.frames[0];
        instance.pins.push(Pin { bone: 0, frame });
        if settle {
            let pins = instance.pins.clone();
            simulation.settle_blocking()?;
            let instance = &simulation.instances()[0];
            assert_eq!(instance.pins, pins);
        } else {
            for _ in 0..400 {
                simulation.step_blocking()?;
            }
        }
        ends.push(simulation.instances()[0].state.clone());
    }
    let [a, b] = [0, 1].map(|k| support::posed(&avatar, &avatar.skin, &ends[k]));
    let apart = support::largest_distance(&a, &b);
    assert!(apart < 1e-6, "{apart:e} m apart");
    let start = support::posed(&avatar, &avatar.skin, &avatar.rest_state());
    let sag = support::largest_distance(&start, &b);
    assert!(sag > 1e-4, "it sags by {sag:e} m only");
    Ok(())
}

#[test]
fn under_gravity_a_captured_shape_stays_and_joints_sag_little() -> Result<()> {
    let avatar = support::full_space_limb(&support::SMALL, 3, true);
    let settings = Settings {
        // The limb weighs 1.5 kg over a lever of 0.1 m.
        bending_stiffness: 2e3,
        ..Settings::default()
    };
    let mut simulation = simulation(&avatar, settings);
    let frames = bent(&avatar);
    let instance = &mut simulation.instances_mut()[0];
    instance.pose(&frames, &avatar.skeleton.parents);
    let mut target = Tracking::new(0, frames[0]);
    // As stiff as the hand's, for its greater weight.
    target.rotation.as_mut().unwrap().stiffness = 2e3;
    target.position.as_mut().unwrap().stiffness = 1e6;
    instance.targets = vec![target];
    instance.preload = Preload::Off;
    for _ in 0..300 {
        simulation.step_blocking()?;
    }
    let state = &simulation.instances()[0].state;
    let displaced = state.handles.iter().map(|h| h.length()).fold(0.0, f64::max);
    assert!(displaced < 1e-6, "φ = {displaced:e} m");
    let mut skeleton = state.clone();
    skeleton.handles.fill(DVec3::ZERO);
    let [a, b] = [&skeleton, state].map(|q| support::posed(&avatar, &avatar.skin, q));
    let error = support::largest_distance(&a, &b);
    assert!(error < 1e-6, "{error:e} m off linear blend skinning");
    let gap = supple::internal::skeleton::joint_gap(&avatar.skeleton, &state.frames);
    let turned = state
        .frames
        .iter()
        .zip(&frames)
        .map(|(a, b)| b.motion_to(a).1.length());
    let turned = turned.fold(0.0, f64::max).to_degrees();
    println!("joint gap {gap:e} m, sag {turned}°");
    assert!(gap < 1e-4, "{gap:e} m");
    Ok(())
}

#[test]
fn joints_of_a_chain_hold_under_load() -> Result<()> {
    for bones in [2, 5, 10] {
        let limb = supple_samples::Limb {
            stations: 2 * bones,
            layers: 1,
            sectors: 4,
            length: 0.05 * bones as f64,
            ..support::SMALL
        };
        let avatar = support::full_space_limb(&limb, bones, true);
        let mut simulation = simulation(&avatar, Settings::default());
        let instance = &mut simulation.instances_mut()[0];
        // Hanging from its pinned first bone by eight times its weight.
        instance.gravity = DVec3::X * 80.0;
        let frame = instance.state.frames[0];
        instance.pins.push(Pin { bone: 0, frame });
        let mut gap = 0.0;
        for _ in 0..300 {
            gap = simulation.step_blocking()?.instances[0].max_joint_gap;
        }
        let mass = |j: usize| avatar.bone_masses[j].second_moment[3][3];
        let tissue: f64 = (0..avatar.cubature.len())
            .map(|i| {
                let beyond = avatar
                    .cubature
                    .skinning
                    .row(i)
                    .iter()
                    .filter(|w| w.bone > 0);
                avatar.density * avatar.cubature.measure[i] * beyond.map(|w| w.weight).sum::<f64>()
            })
            .sum();
        let load = 80.0 * ((1..bones).map(mass).sum::<f64>() + tissue);
        println!(
            "{bones} bones: largest gap {:.4} mm under {load:.1} N",
            gap * 1e3
        );
        // The first joint carries everything beyond it: k = 1e6 N/m.
        assert!(
            (gap * 1e6 / load - 1.0).abs() < 0.01,
            "{gap:e} m under {load} N"
        );
        assert!(gap < 5e-4);
    }
    Ok(())
}

#[test]
fn the_wrists_load_is_contact_and_weight() -> Result<()> {
    for (solver, pinned) in [
        (SolverMode::OneIteration, false),
        (SolverMode::CONVERGED, false),
        (SolverMode::OneIteration, true),
    ] {
        let avatar = support::full_space_limb(&support::SMALL, 1, false);
        let settings = Settings {
            solver,
            ..Settings::default()
        };
        let mut simulation = simulation(&avatar, settings);
        let instance = &mut simulation.instances_mut()[0];
        let frame = instance.state.frames[0];
        if pinned {
            instance.pins.push(Pin { bone: 0, frame });
        } else {
            instance.targets.push(Tracking::new(0, frame));
        }
        let plate = |press: f64| Frame {
            position: DVec3::new(0.1, 0.0, 0.14 - press),
            rotation: DMat3::IDENTITY,
        };
        let shape = Shape::Box {
            half_extents: [0.1; 3],
        };
        instance.colliders.push(Collider::new(shape, plate(0.0)));
        let mut last = None;
        for step in 1..=150 {
            let press = 0.006 * f64::min(1.0, step as f64 / 50.0);
            simulation.instances_mut()[0].colliders[0].frame = plate(press);
            last = Some(simulation.step_blocking()?);
        }
        let report = last.unwrap().instances.remove(0);
        let contact = report.contact_force;
        let missing = contact + report.weight + report.loads[0].force;
        println!("contact {contact} N, load {} N", report.loads[0].force);
        assert!(contact.z < -5.0, "{contact}");
        assert!(
            missing.length() < 1e-3 * contact.length(),
            "{missing} N is missing"
        );
    }
    Ok(())
}

/// Whatever a pinned bone and a collider do, and after one iteration of Newton's method as after many: what holds the bone
/// is the contact, the weight and the change of momentum, all at the state that the step ends with.
#[test]
fn a_pins_load_balances_contact_weight_and_momentum_in_every_step() -> Result<()> {
    let mut most = 0.0f64;
    for (captured, solver) in [
        (false, SolverMode::OneIteration),
        (true, SolverMode::OneIteration),
        (false, SolverMode::CONVERGED),
    ] {
        let avatar = support::full_space_limb(&support::SMALL, 1, captured);
        let settings = Settings {
            solver,
            integrator: Integrator::BackwardEuler,
            ..Settings::default()
        };
        let mut simulation = simulation(&avatar, settings);
        let instance = &mut simulation.instances_mut()[0];
        instance.factors.gravity = 0.5;
        instance.factors.stiffness = 1.5;
        let frame = instance.state.frames[0];
        instance.pins.push(Pin { bone: 0, frame });
        let shape = Shape::Box {
            half_extents: [0.1; 3],
        };
        let plate = |z: f64| Frame {
            position: DVec3::new(0.1, 0.0, z),
            rotation: DMat3::IDENTITY,
        };
        instance.colliders.push(Collider {
            friction: 0.5,
            ..Collider::new(shape, plate(0.14))
        });
        let mut momentum = DVec3::ZERO;
        for step in 1..=40 {
            let time = step as f64 * settings.time_step;
            let before = simulation.instances()[0].state.clone();
            let instance = &mut simulation.instances_mut()[0];
            instance.colliders[0].frame = plate(0.14 - 0.02 * time);
            instance.pins[0].frame.position =
                frame.position + DVec3::X * 0.002 * (20.0 * time).sin();
            let report = simulation.step_blocking()?.instances.remove(0);
            let after = &simulation.instances()[0].state;
            let moves = mechanics(&avatar, &before, after, settings.time_step, DVec3::ZERO);
            let change = (moves.momentum - momentum) / settings.time_step;
            momentum = moves.momentum;
            let borne = report.contact_force + report.weight + report.loads[0].force;
            let missing = (borne - change).length();
            assert!(
                missing < 1e-9 * (1.0 + report.contact_force.length()),
                "{missing} N in step {step}"
            );
            let whole: f64 = avatar.bone_masses[0].second_moment[3][3];
            let weight = 9.81 * (whole + 0.5 * avatar.tissue_mass());
            assert!((report.weight.z + weight).abs() < 1e-9 * weight);
            most = most.max(report.contact_force.length());
        }
    }
    assert!(most > 5.0, "pressed with {most} N only");
    Ok(())
}

/// Without a pin a report is of the prediction unless the settings ask for the end; the step itself is the same to the bit.
#[test]
fn reports_of_free_bones_are_of_the_end_on_request() -> Result<()> {
    let avatar = support::full_space_limb(&support::SMALL, 1, false);
    let run = |report_at_end| -> Result<_> {
        let settings = Settings {
            report_at_end,
            ..Settings::default()
        };
        let mut simulation = simulation(&avatar, settings);
        let instance = &mut simulation.instances_mut()[0];
        let frame = instance.state.frames[0];
        instance.targets.push(Tracking::new(0, frame));
        let place = |z: f64| Frame {
            position: DVec3::new(0.1, 0.0, z),
            rotation: DMat3::IDENTITY,
        };
        let plate = Shape::Box {
            half_extents: [0.1; 3],
        };
        instance.colliders.push(Collider::new(plate, place(0.14)));
        let mut report = None;
        for step in 1..=10 {
            simulation.instances_mut()[0].colliders[0].frame = place(0.14 - 0.0005 * step as f64);
            report = Some(simulation.step_blocking()?.instances.remove(0));
        }
        let state = simulation.instances()[0].state.clone();
        let mut at_end = [Evaluation::default()];
        let states = std::slice::from_ref(&state);
        pollster::block_on((simulation.potential_mut()).evaluate(states, &[true], &mut at_end))?;
        Ok((state, report.unwrap(), at_end))
    };
    let (state, report, [at_end]) = run(true)?;
    let (same, predicted, _) = run(false)?;
    assert_eq!(state, same);
    assert!(report.contact_force.length() > 0.1);
    assert_eq!(report.contact_force, at_end.contact_force);
    assert_eq!(report.contacts, at_end.contacts);
    assert_eq!(report.energies, at_end.energies);
    assert_ne!(predicted.contact_force, at_end.contact_force);
    Ok(())
}
