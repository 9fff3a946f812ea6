//! What drives a character: the host's bones, springs, nothing.

use super::{converged, limb};
use crate::support;
use std::sync::Arc;
use supple::collider::{Collider, Shape};
use supple::glam::{DMat3, DVec3};
use supple::model::Frame;
use supple::potential::CpuPotential;
use supple::sim::{Pin, Settings, Simulation, SolverMode};
use supple::skeleton::Spring;
use supple::world::{Backend, LONGEST_STEP};
use supple::{Result, World};

/// One asset, one instance: a world does what the layer below does, bit by bit.
#[test]
fn a_world_of_one_is_a_simulation() -> Result<()> {
    let avatar = limb(5, 8);
    let floor = Collider {
        friction: 0.4,
        ..Collider::new(Shape::Sphere { radius: 0.05 }, at(-0.085))
    };
    let settings = Settings {
        solver: SolverMode::TWO_ITERATIONS,
        ..Settings::default()
    };
    let potential = CpuPotential::new(avatar.clone(), 1)?;
    let mut simulation = Simulation::new(&avatar, potential, settings)?;
    let mut world = World::new(Backend::Cpu)?.with_settings(settings)?;
    let key = world.add_avatar(avatar)?;
    let key = world.add_instance(key)?;
    // Stood up about the file's origin.
    world.instance_mut(key)?.teleport_to(&Frame::IDENTITY)?;
    world.add_collider(floor.clone())?;
    simulation.instances_mut()[0].colliders.push(floor);
    simulation.instances_mut()[0].gravity = world.gravity();
    let mut contacts = 0;
    for step in 0..40 {
        let angle = 0.01 * f64::from(step);
        let frame = Frame {
            rotation: DMat3::from_rotation_x(angle),
            position: DVec3::new(0.0, 0.0, 0.001 * f64::from(step)),
        };
        world.instance_mut(key)?.follow_frames(&[frame])?;
        world.step_blocking(0.01)?;
        let instance = &mut simulation.instances_mut()[0];
        instance.pins.clear();
        instance.pins.push(Pin { bone: 0, frame });
        let report = simulation.step_blocking()?.instances.remove(0);
        let instance = &simulation.instances()[0];
        assert_eq!(world.instance(key)?.state(), &instance.state, "step {step}");
        assert_eq!(world.instance(key)?.report().loads, report.loads);
        contacts += world.instance(key)?.report().contacts;
    }
    assert!(contacts > 0);
    Ok(())
}

/// Bones that fly evenly from the first moment on carry their tissue along, pinned or drawn by springs; without a word they
/// start from rest, and it is left behind.
#[test]
fn what_begins_on_its_way_feels_no_blow() -> Result<()> {
    let avatar = limb(5, 8);
    let displaced = |begin: bool, tracked: bool| -> Result<f64> {
        let mut world = World::new(Backend::Cpu)?;
        world.set_gravity(DVec3::ZERO);
        let key = world.add_avatar(avatar.clone())?;
        let key = world.add_instance(key)?;
        let start = world.instance(key)?.frames().to_vec();
        let drive = |world: &mut World, step: i32| {
            let mut frames = start.clone();
            frames[0].position += 0.02 * f64::from(step) * DVec3::X;
            let character = world.instance_mut(key)?;
            let spring = |stiffness| Spring {
                stiffness,
                damping: 0.01 * stiffness,
            };
            match tracked {
                true => character.track_frames(&frames, spring(1e3), spring(1e5))?,
                false => character.follow_frames(&frames)?,
            }
            Ok::<_, supple::Error>(frames)
        };
        drive(&mut world, 0)?;
        let mut longest: f64 = 0.0;
        for step in 1..6 {
            if begin && step == 1 {
                let mut next = start.clone();
                next[0].position += 0.02 * DVec3::X;
                world.instance_mut(key)?.begin_moving(&next, 0.01)?;
            } else {
                drive(&mut world, step)?;
            }
            world.step_blocking(0.01)?;
            let displacement = world.instance(key)?.displacement();
            longest = displacement
                .iter()
                .map(|d| d.length())
                .fold(longest, f64::max);
        }
        Ok(longest)
    };
    for tracked in [false, true] {
        let (begun, blow) = (displaced(true, tracked)?, displaced(false, tracked)?);
        assert!(begun < 1e-7 && blow > 1e-4, "{tracked}: {begun} and {blow}");
    }
    let mut world = World::new(Backend::Cpu)?;
    let key = world.add_avatar(avatar.clone())?;
    let key = world.add_instance(key)?;
    let frames = world.instance(key)?.frames().to_vec();
    let character = world.instance_mut(key)?;
    for (frames, step, field) in [
        (&frames[..], 0.01, "nothing drives"),
        (&[], 0.01, "0 given"),
    ] {
        let message = character
            .begin_moving(frames, step)
            .unwrap_err()
            .to_string();
        assert!(message.contains(field), "{message}");
    }
    Ok(())
}

/// Nobody drives a chain of bones: it stands as it was bound, under gravity.
#[test]
fn what_nothing_drives_stands() -> Result<()> {
    let avatar = Arc::new(support::full_space_limb(&support::SMALL, 4, false));
    let mut world = World::new(Backend::Cpu)?;
    let key = world.add_avatar(avatar.clone())?;
    let key = world.add_instance(key)?;
    let start = world.instance(key)?.state().clone();
    for _ in 0..120 {
        world.step_blocking(1.0 / 60.0)?;
    }
    let end = world.instance(key)?.state();
    let apart = |(a, b): (&Frame, &Frame)| a.position.distance(b.position);
    let sag = start
        .frames
        .iter()
        .zip(&end.frames)
        .map(apart)
        .fold(0.0, f64::max);
    println!("{:.3} mm of {:.0} mm", sag * 1e3, 250.0);
    assert!(sag < 1e-3, "{sag} m");
    // Once it has settled nothing moves at all; and a settled ragdoll is where it was put.
    let last = world.settle_blocking()?;
    assert!(last < 1e-7, "{last:e} m");
    let settled = world.instance(key)?.state().clone();
    for _ in 0..60 {
        world.step_blocking(1.0 / 60.0)?;
    }
    let state = world.instance(key)?.state();
    let moved = (settled.frames.iter().zip(&state.frames))
        .map(apart)
        .fold(0.0, f64::max);
    assert!(moved < 1e-6, "{moved:e} m");
    world.instance_mut(key)?.ragdoll(0.1)?;
    world.settle_blocking()?;
    assert_eq!(world.instance(key)?.frames()[0], settled.frames[0]);
    world.instance_mut(key)?.ragdoll(0.0)?;
    for _ in 0..10 {
        world.step_blocking(1.0 / 60.0)?;
    }
    let fallen = start.frames[0].position.y - world.instance(key)?.frames()[0].position.y;
    assert!(fallen > 0.1, "{fallen} m in 10 frames");
    Ok(())
}

/// A teleport is not felt, a long step is none, sleep and wake neither.
#[test]
fn jumps_are_not_felt() -> Result<()> {
    let mut world = converged()?;
    let key = world.add_avatar(limb(4, 6))?;
    let key = world.add_instance(key)?;
    let drive = |world: &mut World, x: f64| world.instance_mut(key)?.follow_frames(&[at_x(x)]);
    let swing = |world: &World| {
        let handles = world.instance(key).unwrap().handles().iter();
        handles.map(|h| h.length()).fold(0.0, f64::max)
    };
    for step in 0..5 {
        drive(&mut world, 0.001 * f64::from(step))?;
        world.step_blocking(0.01)?;
    }
    let before = swing(&world);
    let away = Frame {
        rotation: DMat3::from_rotation_z(2.0),
        position: DVec3::new(3.0, -2.0, 5.0),
    };
    world.instance_mut(key)?.teleport_to(&away)?;
    // The host's motion goes on from there.
    let here = world.instance(key)?.frames()[0];
    let onward = here.compose(&at_x(0.001));
    world.instance_mut(key)?.follow_frames(&[onward])?;
    world.step_blocking(0.01)?;
    assert!(
        swing(&world) < before + 2e-4,
        "{} after {before}",
        swing(&world)
    );
    world.step_blocking(2.0 * LONGEST_STEP)?;
    world.instance_mut(key)?.reset();
    drive(&mut world, 7.0)?;
    world.step_blocking(1.0)?;
    assert!(swing(&world) < 1e-9, "{}", swing(&world));
    assert_eq!(world.instance(key)?.frames()[0], at_x(7.0));
    world.instance_mut(key)?.sleep();
    for step in 0..10 {
        drive(&mut world, 7.0 + 0.1 * f64::from(step))?;
        world.step_blocking(0.01)?;
    }
    world.instance_mut(key)?.wake();
    drive(&mut world, 8.0)?;
    world.step_blocking(0.01)?;
    assert!(swing(&world) < 1e-5, "{}", swing(&world));
    Ok(())
}

#[test]
fn unusable_input_is_refused_by_name_and_changes_nothing() -> Result<()> {
    let mut world = converged()?;
    let key = world.add_avatar(limb(4, 6))?;
    let key = world.add_instance(key)?;
    world.step_blocking(0.01)?;
    let before = world.instance(key)?.state().clone();
    for step in [0.0, -0.01, f64::NAN, f64::INFINITY] {
        let error = world.step_blocking(step).unwrap_err().to_string();
        assert!(error.contains("time_step"), "{error}");
    }
    let character = world.instance_mut(key)?;
    let skewed = Frame {
        rotation: DMat3::from_diagonal(DVec3::new(1.0, 1.0, 1.1)),
        ..Frame::IDENTITY
    };
    let error = character.follow_frames(&[skewed]).unwrap_err().to_string();
    assert!(error.contains("bone 0"), "{error}");
    assert!(character.follow_frames(&[]).is_err());
    assert!(character.follow_world(&[]).is_err());
    assert!(character.ragdoll(-1.0).is_err());
    assert!(character.teleport_to(&skewed).is_err());
    assert_eq!(character.state(), &before);
    assert!(
        world
            .add_instance_at(world_key_of_another(), &Frame::IDENTITY)
            .is_err()
    );
    Ok(())
}

/// The skin is there before the first step, and the first bones that are said are where a character starts.
#[test]
fn what_is_said_first_is_where_it_starts() -> Result<()> {
    let mut world = World::new(Backend::Cpu)?;
    let avatar = limb(4, 6);
    let vertices = avatar.skin.len();
    let key = world.add_avatar(avatar)?;
    let key = world.add_instance(key)?;
    let (mut skin, mut normals) = (Vec::new(), Vec::new());
    world.read_skin_blocking(key, &mut skin, &mut normals)?;
    assert_eq!((skin.len(), normals.len()), (vertices, vertices));
    let rest = skin[0];
    world.set_gravity(DVec3::ZERO);
    world.instance_mut(key)?.follow_frames(&[at_x(0.8)])?;
    world.read_skin_blocking(key, &mut skin, &mut normals)?;
    assert!((skin[0] - rest).length() > 0.5, "{} {rest}", skin[0]);
    world.step_blocking(0.01)?;
    let swing = |world: &World| {
        let handles = world.instance(key).unwrap().handles().iter();
        handles.map(|h| h.length()).fold(0.0, f64::max)
    };
    assert!(swing(&world) < 1e-9, "{}", swing(&world));
    // From then on a jump is one.
    world.instance_mut(key)?.follow_frames(&[at_x(0.81)])?;
    world.step_blocking(0.01)?;
    assert!(swing(&world) > 1e-3, "{}", swing(&world));
    Ok(())
}

#[test]
fn an_unusable_collider_is_named_and_nothing_moves() -> Result<()> {
    let mut world = converged()?;
    let key = world.add_avatar(limb(4, 6))?;
    let key = world.add_instance(key)?;
    let ball = Collider::new(Shape::Sphere { radius: 0.05 }, at(-0.08));
    let first = world.add_collider(ball.clone())?;
    let second = world.add_collider(ball)?;
    world.step_blocking(0.01)?;
    let before = world.instance(key)?.state().clone();
    for spoil in [
        (|c| c.frame.position.x = f64::NAN) as fn(&mut Collider),
        |c| c.stiffness = Some(-1.0),
        |c| c.shape = Shape::Sphere { radius: f64::NAN },
    ] {
        let good = world.collider_mut(second)?.clone();
        spoil(world.collider_mut(second)?);
        let error = world.step_blocking(0.01).unwrap_err().to_string();
        assert!(error.contains(&format!("{second:?}")), "{error}");
        assert!(!error.contains(&format!("{first:?}")), "{error}");
        assert_eq!(world.instance(key)?.state(), &before);
        *world.collider_mut(second)? = good;
    }
    world.step_blocking(0.01)?;
    Ok(())
}

/// A key that no world has given.
fn world_key_of_another() -> supple::world::AvatarId {
    Default::default()
}

fn at(y: f64) -> Frame {
    Frame {
        position: DVec3::new(0.12, y, 0.0),
        ..Frame::IDENTITY
    }
}

fn at_x(x: f64) -> Frame {
    Frame {
        position: DVec3::X * x,
        ..Frame::IDENTITY
    }
}
