//! Spring bones of characters: who prescribes, jumps, sleep, snapshots.

use crate::support::{LIMP, SMALL, full_space_limb, with_tail};
use std::sync::Arc;
use supple::collider::{Collider, Shape};
use supple::glam::{DMat3, DVec3};
use supple::model::{Avatar, Frame, SpringJoint, UpAxis};
use supple::sim::SpringMode;
use supple::skeleton::Spring;
use supple::world::{Backend, InstanceId, Snapshot};
use supple::{Result, World};

pub fn tailed() -> Arc<Avatar> {
    let hair = SpringJoint {
        stiffness: 0.4,
        drag_force: 0.2,
        gravity: DVec3::new(0.02, 0.0, -0.1),
        hit_radius: 0.005,
        ..LIMP
    };
    Arc::new(with_tail(&full_space_limb(&SMALL, 1, true), 3, hair))
}

pub fn world(avatar: &Arc<Avatar>, backend: Backend) -> Result<(World, InstanceId)> {
    let mut world = World::new(backend)?.with_up(UpAxis::Z);
    let key = world.add_avatar(avatar.clone())?;
    let key = world.add_instance(key)?;
    Ok((world, key))
}

/// All bones in the bind pose, moved by a root that is shaken.
pub fn shaken(avatar: &Avatar, step: u32) -> Vec<Frame> {
    let time = 0.012 * f64::from(step);
    let root = Frame {
        rotation: DMat3::from_rotation_z(0.5 * (9.0 * time).sin()),
        position: DVec3::new(0.0, 0.04 * (13.0 * time).sin(), 0.0),
    };
    let rest = avatar.rest_state();
    rest.frames
        .iter()
        .map(|frame| root.compose(frame))
        .collect()
}

pub fn step(world: &mut World, key: InstanceId, frames: &[Frame]) -> Result<Vec<Frame>> {
    world.instance_mut(key)?.follow_frames(frames)?;
    world.step_blocking(0.012)?;
    Ok(world.instance(key)?.frames().to_vec())
}

/// Largest difference of rotations.
fn apart(a: &[Frame], b: &[Frame]) -> f64 {
    let pairs = a.iter().zip(b);
    let turn = |(a, b): (&Frame, &Frame)| (a.rotation - b.rotation).to_cols_array();
    pairs
        .flat_map(turn)
        .fold(0.0, |most, d| f64::max(most, d.abs()))
}

#[test]
fn a_host_that_prescribes_them_wins_unless_it_lets_them_swing() -> Result<()> {
    let avatar = tailed();
    let (mut world, key) = world(&avatar, Backend::Cpu)?;
    for k in 0..40 {
        let wanted = shaken(&avatar, k);
        let found = step(&mut world, key, &wanted)?;
        assert!(apart(&found, &wanted) < 1e-14, "step {k}");
    }
    world.instance_mut(key)?.set_spring_mode(SpringMode::All);
    let mut most = 0.0_f64;
    for k in 40..80 {
        let wanted = shaken(&avatar, k);
        let found = step(&mut world, key, &wanted)?;
        assert!(apart(&found[..1], &wanted[..1]) < 1e-14);
        most = most.max(apart(&found, &wanted));
    }
    assert!(most > 0.1, "{most}");
    // Tracked bones are drawn, and what springs carry swings about where they are.
    let spring = Spring {
        stiffness: 1e4,
        damping: 10.0,
    };
    (world.instance_mut(key)?).set_spring_mode(SpringMode::Free);
    for k in 80..120 {
        let wanted = shaken(&avatar, k);
        (world.instance_mut(key)?).track_frames(&wanted, spring, spring)?;
        world.step_blocking(0.012)?;
        most = most.min(apart(world.instance(key)?.frames(), &wanted));
    }
    assert!(most > 1e-4, "{most}");
    Ok(())
}

#[test]
fn gravity_is_that_of_the_file_turned_to_the_world() -> Result<()> {
    let mut avatar = (*tailed()).clone();
    avatar.up = UpAxis::Y;
    for joint in &mut avatar.springs.joints {
        (joint.gravity, joint.stiffness) = (DVec3::NEG_Y * 0.3, 0.0);
    }
    for up in [UpAxis::Y, UpAxis::Z] {
        let mut world = World::new(Backend::Cpu)?.with_up(up);
        let key = world.add_avatar(avatar.clone())?;
        let key = world.add_instance(key)?;
        for _ in 0..400 {
            world.step_blocking(0.012)?;
        }
        let frame = world.instance(key)?.frames()[3];
        let down = frame.rotation * avatar.springs.joints[2].tail.normalize();
        assert!(down.dot(up.direction()) < -0.99, "{up:?}: {down}");
    }
    Ok(())
}

#[test]
fn a_jump_is_not_felt_and_a_reset_is_at_rest() -> Result<()> {
    let mut avatar = (*tailed()).clone();
    (avatar.springs.joints.iter_mut()).for_each(|joint| joint.gravity = DVec3::ZERO);
    let avatar = Arc::new(avatar);
    let ((mut jumps, a), (mut stays, b)) =
        (world(&avatar, Backend::Cpu)?, world(&avatar, Backend::Cpu)?);
    for (world, key) in [(&mut jumps, a), (&mut stays, b)] {
        (world.instance_mut(key)?).set_spring_mode(SpringMode::All);
    }
    let away = Frame {
        rotation: DMat3::from_rotation_x(1.1),
        position: DVec3::new(100.0, -3.0, 20.0),
    };
    let local = |frames: &[Frame]| -> Vec<Frame> {
        let seen = |f: &Frame| Frame {
            rotation: frames[0].rotation.transpose() * f.rotation,
            position: frames[0].inverse_transform(f.position),
        };
        frames.iter().map(seen).collect()
    };
    for k in 0..60 {
        let wanted = shaken(&avatar, k);
        let moved: Vec<Frame> = wanted.iter().map(|f| away.compose(f)).collect();
        if k == 30 {
            let standing = stays.instance(b)?.placement();
            (jumps.instance_mut(a)?).teleport_to(&away.compose(&standing))?;
        }
        let found = step(&mut jumps, a, if k < 30 { &wanted } else { &moved })?;
        let expected = step(&mut stays, b, &wanted)?;
        assert!(apart(&local(&found), &local(&expected)) < 1e-9, "step {k}");
    }
    let frames = shaken(&avatar, 60);
    (jumps.instance_mut(a)?).follow_frames(&frames)?;
    (jumps.instance_mut(a)?).reset();
    let found = step(&mut jumps, a, &frames)?;
    assert!(apart(&found, &frames) < 1e-12);
    Ok(())
}

#[test]
fn sleep_keeps_them_as_they_are_and_they_go_on_when_it_ends() -> Result<()> {
    let avatar = tailed();
    let (mut world, key) = world(&avatar, Backend::Cpu)?;
    (world.instance_mut(key)?).set_spring_mode(SpringMode::All);
    let mut before = Vec::new();
    for k in 0..30 {
        before = step(&mut world, key, &shaken(&avatar, k))?;
    }
    world.instance_mut(key)?.sleep();
    let asleep = step(&mut world, key, &shaken(&avatar, 30))?;
    let turned = |frames: &[Frame], bone: usize| {
        frames[bone - 1].rotation.transpose() * frames[bone].rotation
    };
    for bone in 1..4 {
        // The first hangs on the root, which has moved on.
        let parent = if bone == 1 { 0 } else { bone - 1 };
        let [a, b] = [&before, &asleep].map(|f| f[parent].rotation.transpose() * f[bone].rotation);
        assert!(a.abs_diff_eq(b, 1e-12), "bone {bone}");
    }
    assert!(apart(&asleep, &shaken(&avatar, 30)) > 0.01);
    world.instance_mut(key)?.wake();
    let awake = step(&mut world, key, &shaken(&avatar, 31))?;
    let moved = (turned(&awake, 2) - turned(&asleep, 2)).to_cols_array();
    assert!(moved.iter().all(|d| d.abs() < 0.2), "{moved:?}");
    Ok(())
}

#[test]
fn a_restored_world_swings_on_with_the_same_bits() -> Result<()> {
    let avatar = tailed();
    let (mut world, key) = world(&avatar, Backend::Cpu)?;
    (world.instance_mut(key)?).set_spring_mode(SpringMode::All);
    let ball = Collider::new(
        Shape::Sphere { radius: 0.1 },
        Frame {
            position: DVec3::new(-0.35, 0.0, -0.12),
            ..Frame::IDENTITY
        },
    );
    world.add_collider(ball)?;
    // Steps of several lengths: velocities go over from one to the other.
    let run = |world: &mut World, steps: std::ops::Range<u32>| -> Result<Vec<Frame>> {
        for k in steps {
            (world.instance_mut(key)?).follow_frames(&shaken(&avatar, k))?;
            world.step_blocking(0.004 + 0.01 * f64::from(k % 5))?;
        }
        Ok(world.instance(key)?.frames().to_vec())
    };
    run(&mut world, 0..25)?;
    let text = serde_json::to_string(&world.snapshot()?).unwrap();
    let wanted = run(&mut world, 25..60)?;
    assert!(apart(&wanted, &shaken(&avatar, 59)) > 0.01);
    let snapshot: Snapshot = serde_json::from_str(&text).unwrap();
    let mut fresh = World::new(Backend::Cpu)?;
    fresh.add_avatar(avatar.clone())?;
    for world in [&mut world, &mut fresh] {
        world.restore(&snapshot)?;
        assert_eq!(run(world, 25..60)?, wanted);
    }
    Ok(())
}
