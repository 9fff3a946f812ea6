//! A world restored goes on with the same bits; what cannot be restored is refused.

use super::limb;
use std::sync::Arc;
use supple::collider::{Collider, Shape};
use supple::glam::DVec3;
use supple::model::{Avatar, Frame, RigidBody, State, UpAxis};
use supple::potential::TissueFactors;
use supple::world::{Backend, InstanceId, Snapshot};
use supple::{Result, World};

fn at(x: f64, y: f64) -> Frame {
    Frame {
        position: DVec3::new(x, y, 0.0),
        ..Frame::IDENTITY
    }
}

/// Two assets, three instances, a ball on two of them, a floor.
fn lively(assets: [Arc<Avatar>; 2]) -> Result<(World, Vec<InstanceId>)> {
    let mut world = World::new(Backend::Cpu)?;
    let [a, b] = assets;
    // A body between the avatars: order of assets is not that of what was added.
    let first = world.add_avatar(a)?;
    let aside = RigidBody::new("aside", Shape::Sphere { radius: 0.02 }, 900.0)?.at(at(5.0, 1.0));
    let gone = world.add_body(aside)?;
    let ball = RigidBody::new("ball", Shape::Sphere { radius: 0.05 }, 900.0)?;
    world.add_body(ball.at(at(0.12, 0.095)))?;
    let second = world.add_avatar(b)?;
    let mut keys = vec![world.add_instance(first)?];
    keys.push(world.add_instance_at(second, &at(0.0, -0.02))?);
    keys.push(world.add_instance_at(first, &at(0.0, 1.0))?);
    world.remove_body(gone)?;
    world.instance_mut(keys[2])?.ragdoll(1.0)?;
    let mut factors = TissueFactors::default();
    factors.stiffness = 1.5;
    factors.tension = 0.5;
    world.instance_mut(keys[1])?.set_factors(factors)?;
    let mut floor = Collider::ground(UpAxis::Y);
    // Far above the first instances: what a world never should hold, but its bits are the same all the same.
    floor.frame.position.y = 0.7;
    floor.previous = floor.frame;
    floor.friction = 0.3;
    world.add_collider(floor)?;
    Ok((world, keys))
}

fn run(world: &mut World, keys: &[InstanceId], steps: std::ops::Range<u32>) -> Result<Vec<State>> {
    for step in steps {
        let frame = at(0.0, 0.002 * f64::from(step).sin());
        world.instance_mut(keys[0])?.follow_frames(&[frame])?;
        world.step_blocking(0.012)?;
    }
    let state = |&key| Ok(world.instance(key)?.state().clone());
    keys.iter().map(state).collect()
}

#[test]
fn a_restored_world_goes_on_with_the_same_bits() -> Result<()> {
    let assets = || [limb(4, 6), limb(5, 8)];
    let (mut world, keys) = lively(assets())?;
    run(&mut world, &keys, 0..12)?;
    let text = serde_json::to_string(&world.snapshot()?).unwrap();
    let wanted = run(&mut world, &keys, 12..30)?;
    assert!(
        world.instance(keys[0])?.report().contacts > 0,
        "nothing touched"
    );
    let snapshot: Snapshot = serde_json::from_str(&text).unwrap();
    // Bodies and instances meet and part on the way: in the same world, and in one that has only been handed the avatars.
    let mut fresh = World::new(Backend::Cpu)?;
    for asset in assets() {
        fresh.add_avatar(asset)?;
    }
    for world in [&mut world, &mut fresh] {
        world.restore(&snapshot)?;
        let found = run(world, &keys, 12..30)?;
        for (i, (found, wanted)) in found.iter().zip(&wanted).enumerate() {
            assert_eq!(found.frames, wanted.frames, "instance {i}");
            assert!(found == wanted, "instance {i}: handles");
        }
    }
    Ok(())
}

#[test]
fn what_cannot_be_restored_is_refused_and_changes_nothing() -> Result<()> {
    let (mut world, keys) = lively([limb(4, 6), limb(5, 8)])?;
    run(&mut world, &keys, 0..5)?;
    let snapshot = world.snapshot()?;
    let (mut other, other_keys) = lively([limb(4, 6), limb(6, 8)])?;
    let before = other.instance(other_keys[1])?.state().clone();
    let error = other.restore(&snapshot).unwrap_err().to_string();
    assert!(error.contains("avatars[1]"), "{error}");
    let error = World::new(Backend::Cpu)?.restore(&snapshot).unwrap_err();
    assert!(error.to_string().contains("2 avatars"), "{error}");
    assert_eq!(other.instance(other_keys[1])?.state(), &before);
    let whole = serde_json::to_value(&snapshot).unwrap();
    let sections = whole["sections"].as_array().unwrap().len();
    for k in 0..sections {
        let mut cut = whole.clone();
        cut["sections"][k]["content"].as_array_mut().unwrap().pop();
        let cut: Snapshot = serde_json::from_value(cut).unwrap();
        assert!(world.restore(&cut).is_err(), "section {k} cut short");
        let mut missing = whole.clone();
        missing["sections"].as_array_mut().unwrap().remove(k);
        let missing: Snapshot = serde_json::from_value(missing).unwrap();
        // The last three are those that older snapshots have not.
        let restored = world.restore(&missing).is_ok();
        assert_eq!(restored, k + 3 >= sections, "section {k} is missing");
    }
    world.restore(&snapshot)?;
    let now = world.snapshot()?;
    assert_eq!(now, snapshot);
    Ok(())
}

/// Drivers of version 1 end with the factors but for tension: of a world with one instance, eight bytes earlier.
#[test]
fn a_snapshot_from_before_muscles_could_be_tense_is_restored_with_relaxed_ones() -> Result<()> {
    let mut world = World::new(Backend::Cpu)?;
    let avatar = world.add_avatar(limb(4, 6))?;
    let key = world.add_instance(avatar)?;
    let mut factors = TissueFactors::with_bounce(0.75)?;
    factors.stiffness = 1.5;
    world.instance_mut(key)?.set_factors(factors)?;
    let before = world.snapshot()?;
    let mut value = serde_json::to_value(&before).unwrap();
    let sections = value["sections"].as_array_mut().unwrap().iter_mut();
    let tag = serde_json::json!(b"DRIV");
    let drivers = sections.into_iter().find(|s| s["tag"] == tag).unwrap();
    drivers["version"] = 1.into();
    let content = drivers["content"].as_array_mut().unwrap();
    content.truncate(content.len() - 8);
    let old: Snapshot = serde_json::from_value(value).unwrap();
    factors.tension = 1.0;
    world.instance_mut(key)?.set_factors(factors)?;
    assert_ne!(world.snapshot()?, before);
    world.restore(&old)?;
    assert_eq!(world.snapshot()?, before);
    Ok(())
}

/// The avatar has room for a body by then that it had not before.
#[test]
fn a_moment_before_a_body_came_is_restored() -> Result<()> {
    let mut world = World::new(Backend::Cpu)?;
    let asset = world.add_avatar(limb(5, 8))?;
    let keys = [world.add_instance(asset)?];
    run(&mut world, &keys, 0..2)?;
    let early = world.snapshot()?;
    let expected = run(&mut world, &keys, 2..4)?;
    let ball = RigidBody::new("ball", Shape::Sphere { radius: 0.05 }, 900.0)?;
    world.add_body(ball.at(at(0.12, 0.095)))?;
    run(&mut world, &keys, 4..6)?;
    let bones = world.instance(keys[0])?.avatar().bones();
    assert!(world.instance(keys[0])?.state().frames.len() > bones);
    world.restore(&early)?;
    let again = run(&mut world, &keys, 2..4)?;
    for (a, b) in again.iter().zip(&expected) {
        assert_eq!(a.frames[..bones], b.frames[..bones]);
        assert_eq!(a.handles, b.handles);
    }
    Ok(())
}
