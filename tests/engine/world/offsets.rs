//! A host's offsets of the skin in a world: they change the shape, and are no motion.

use std::sync::Arc;
use supple::collider::{Collider, Shape};
use supple::glam::DVec3;
use supple::internal::{pose_offsets, random_avatar};
use supple::model::{Avatar, Frame, PoseBlend, SkinWeight, TimeDerivative};
use supple::world::{Backend, InstanceId};
use supple::{Result, World};

/// Its points follow its skin, and it has no blend shapes of its own.
fn avatar() -> Arc<Avatar> {
    let mut avatar = random_avatar(5, 3, 6, 40, 120);
    avatar.skin.pose_blend = PoseBlend::default();
    avatar.cubature.pose_blend = PoseBlend::default();
    Arc::new(avatar)
}

/// One instance that follows its bind pose, or falls.
fn world(avatar: &Arc<Avatar>) -> Result<(World, InstanceId)> {
    let mut world = World::new(Backend::Cpu)?.with_up(avatar.up);
    let key = world.add_avatar(avatar.clone())?;
    let key = world.add_instance(key)?;
    Ok((world, key))
}

fn skin(world: &mut World, key: InstanceId) -> Result<Vec<DVec3>> {
    let (mut positions, mut normals) = (Vec::new(), Vec::new());
    world.read_skin_blocking(key, &mut positions, &mut normals)?;
    Ok(positions)
}

/// Σ_j w_j (R_j (X + u − J_j) + c_j): what a host's own skinning makes of the shape with its offset.
fn skinned(avatar: &Avatar, frames: &[Frame], offsets: &[[f32; 3]]) -> Vec<DVec3> {
    let vertices = avatar.skin.position.iter().zip(offsets);
    let posed = |(v, (x, u)): (usize, (&DVec3, &[f32; 3]))| {
        let unposed = *x + DVec3::from(u.map(f64::from));
        let by = |w: &SkinWeight| {
            let j = w.bone as usize;
            w.weight * frames[j].transform(unposed - avatar.skeleton.joints[j])
        };
        avatar.skin.skinning.row(v).iter().map(by).sum()
    };
    vertices.enumerate().map(posed).collect()
}

fn farthest(a: &[DVec3], b: &[DVec3]) -> f64 {
    assert_eq!(a.len(), b.len());
    let pairs = a.iter().zip(b);
    pairs.map(|(a, b)| a.distance(*b)).fold(0.0, f64::max)
}

#[test]
fn untouched_the_skin_is_the_skinned_one_with_its_offset() -> Result<()> {
    let avatar = avatar();
    let (mut world, key) = world(&avatar)?;
    let frames = world.instance(key)?.frames().to_vec();
    world.instance_mut(key)?.follow_frames(&frames)?;
    let plain = skinned(&avatar, &frames, &vec![[0.0; 3]; avatar.skin.len()]);
    let bare = world.skin_bounds(key)?;
    for step in 0..20 {
        // From one step to the next by centimetres.
        let offsets = pose_offsets(step, &avatar, 0.02);
        world.instance_mut(key)?.set_pose_offsets(&offsets)?;
        world.step_blocking(0.01)?;
        let character = world.instance(key)?;
        assert!(
            character.handles().iter().all(|phi| *phi == DVec3::ZERO),
            "step {step}"
        );
        let wanted = skinned(&avatar, character.frames(), &offsets);
        let error = farthest(&skin(&mut world, key)?, &wanted);
        assert!(error < 1e-15, "{error:e} m");
        assert!(farthest(&wanted, &plain) > 0.01);
        // What is culled by grows by the longest of them.
        let longest = offsets
            .iter()
            .map(|u| DVec3::from(u.map(f64::from)).length());
        let longest = DVec3::splat(longest.fold(0.0, f64::max));
        let [low, high] = world.skin_bounds(key)?;
        assert!(low.distance(bare[0] - longest) + high.distance(bare[1] + longest) < 1e-8);
    }
    // Taken away, and while it sleeps.
    world.instance_mut(key)?.set_pose_offsets(&[])?;
    world.step_blocking(0.01)?;
    assert!(farthest(&skin(&mut world, key)?, &plain) < 1e-15);
    let offsets = pose_offsets(30, &avatar, 0.02);
    let character = world.instance_mut(key)?;
    character.sleep();
    character.set_pose_offsets(&offsets)?;
    world.step_blocking(0.01)?;
    let wanted = skinned(&avatar, &frames, &offsets);
    assert!(farthest(&skin(&mut world, key)?, &wanted) < 1e-15);
    Ok(())
}

/// Whatever shape tissue is told to have, its weight and its inertia are where it is, to what one step in f32 with one
/// refinement solves.
#[test]
fn changing_offsets_do_not_turn_what_falls() -> Result<()> {
    let avatar = Arc::new(Avatar {
        captured_under_gravity: false,
        ..(*avatar()).clone()
    });
    let (mut world, key) = world(&avatar)?;
    world.instance_mut(key)?.ragdoll(0.0)?;
    let start = world.instance(key)?.frames().to_vec();
    // xⁿ⁺¹ = Σ c_k xⁿ⁻ᵏ + h̃² g: the first step is one of backward Euler, and counts so in the two that follow.
    let (mut fall, mut past) = (0.0, [0.0; 3]);
    let mut derivatives = [TimeDerivative::backward_euler(1e-4); 2];
    for step in 0..20 {
        let offsets = pose_offsets(step, &avatar, 0.02);
        world.instance_mut(key)?.set_pose_offsets(&offsets)?;
        world.step_blocking(0.01)?;
        let derivative = match step {
            0 => TimeDerivative::backward_euler(0.01),
            _ => TimeDerivative::bdf2(0.01, 0.01),
        };
        let weights = derivative.inertial_weights(&derivatives);
        let pulled: f64 = weights.iter().zip(past).map(|(c, x)| c * (x - fall)).sum();
        past = [fall, past[0], past[1]];
        fall += pulled + derivative.step * derivative.step * 9.81;
        derivatives = [derivative, derivatives[0]];
    }
    // About g t²/2.
    assert!((fall / (0.5 * 9.81 * 0.04) - 1.0).abs() < 0.05, "{fall} m");
    let fallen = -fall * avatar.up.direction();
    let character = world.instance(key)?;
    for (now, then) in character.frames().iter().zip(&start) {
        let gone = now.position - then.position;
        assert!(
            gone.distance(fallen) < 1e-6 * fallen.length(),
            "{gone} {fallen}"
        );
        let turned = (now.rotation - then.rotation).to_cols_array();
        assert!(turned.iter().all(|x| x.abs() < 1e-6), "{turned:?}");
    }
    Ok(())
}

/// A collider far below the skin is met where offsets reach down to it.
#[test]
fn what_offsets_reach_is_met() -> Result<()> {
    let avatar = avatar();
    let (mut world, key) = world(&avatar)?;
    let frames = world.instance(key)?.frames().to_vec();
    world.instance_mut(key)?.follow_frames(&frames)?;
    let below = -avatar.up.direction();
    let posed = skin(&mut world, key)?;
    let depth = |x: &DVec3| below.dot(*x);
    let lowest = posed.iter().map(depth).fold(f64::MIN, f64::max);
    let floor = Shape::Box {
        half_extents: [1.0, 1.0, 0.01],
    };
    let frame = Frame {
        position: (lowest + 0.05 + 0.01) * below,
        ..Frame::IDENTITY
    };
    world.add_collider(Collider::new(floor, frame))?;
    world.step_blocking(0.01)?;
    assert_eq!(world.instance(key)?.report().contacts, 0);
    let down = (0.0501 * below).as_vec3().to_array();
    let offsets = vec![down; avatar.offset_vertices()];
    world.instance_mut(key)?.set_pose_offsets(&offsets)?;
    world.step_blocking(0.01)?;
    assert!(world.instance(key)?.report().contacts > 0);
    Ok(())
}

#[test]
fn offsets_that_cannot_be_leave_those_that_were() -> Result<()> {
    let avatar = avatar();
    let (mut world, key) = world(&avatar)?;
    let good = pose_offsets(1, &avatar, 0.01);
    let character = world.instance_mut(key)?;
    character.set_pose_offsets(&good)?;
    let mut bad = good.clone();
    bad[3] = [12.0, 0.0, 0.0];
    for (offsets, name) in [
        (&bad[..], "pose_offsets[3]: [12.0, 0.0, 0.0]"),
        (&good[1..], "119 given"),
    ] {
        let error = character.set_pose_offsets(offsets).unwrap_err().to_string();
        assert!(error.contains(name), "{error}");
        assert_eq!(character.instance().pose_offsets.as_slice(), good);
    }
    Ok(())
}

#[test]
fn a_snapshot_keeps_offsets() -> Result<()> {
    let avatar = avatar();
    let (mut world, key) = world(&avatar)?;
    world.instance_mut(key)?.ragdoll(1.0)?;
    world.add_ground()?;
    let offsets = pose_offsets(4, &avatar, 0.01);
    world.instance_mut(key)?.set_pose_offsets(&offsets)?;
    world.step_blocking(0.01)?;
    let snapshot = world.snapshot()?;
    let run = |world: &mut World| -> Result<_> {
        for _ in 0..5 {
            world.step_blocking(0.01)?;
        }
        Ok((world.instance(key)?.state().clone(), skin(world, key)?))
    };
    let wanted = run(&mut world)?;
    world.instance_mut(key)?.set_pose_offsets(&[])?;
    world.restore(&snapshot)?;
    assert_eq!(
        world.instance(key)?.instance().pose_offsets.as_slice(),
        offsets
    );
    assert!(run(&mut world)? == wanted);
    Ok(())
}
