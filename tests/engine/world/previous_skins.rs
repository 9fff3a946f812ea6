//! The posed skin of the step before, for motion vectors.

use super::limb;
use supple::glam::DVec3;
use supple::model::Frame;
use supple::world::{AvatarId, Backend, InstanceId, LONGEST_STEP};
use supple::{Result, World};

/// A world with two instances of an asset, whose key comes with it, and one of another.
pub fn three(backend: Backend) -> Result<(World, AvatarId, [InstanceId; 3])> {
    let mut world = World::new(backend)?;
    let [a, b] = [world.add_avatar(limb(4, 6))?, world.add_avatar(limb(5, 8))?];
    let keys = [
        world.add_instance(a)?,
        world.add_instance(a)?,
        world.add_instance(b)?,
    ];
    Ok((world, a, keys))
}

fn at(x: f64) -> Frame {
    Frame {
        position: DVec3::X * x,
        ..Frame::IDENTITY
    }
}

fn skin(world: &mut World, key: InstanceId) -> Result<Vec<DVec3>> {
    let (mut positions, mut normals) = (Vec::new(), Vec::new());
    world.read_skin_blocking(key, &mut positions, &mut normals)?;
    Ok(positions)
}

fn previous(world: &mut World, key: InstanceId) -> Result<Vec<DVec3>> {
    let mut positions = Vec::new();
    world.read_previous_skin_blocking(key, &mut positions)?;
    Ok(positions)
}

/// The previous skin is the last step's, bit by bit, and the present one where an instance was put.
pub fn check(mut world: World, first_avatar: AvatarId, keys: [InstanceId; 3]) -> Result<()> {
    let drive = |world: &mut World, x: f64| {
        let mut instances = keys.into_iter().zip([1.0, -2.0, 3.0]);
        instances.try_for_each(|(key, way)| {
            let character = world.instance_mut(key)?;
            character.follow_frames(&[at(way * x)])
        })
    };
    drive(&mut world, 0.0)?;
    // Before the first step, and after it, nothing has moved.
    for _ in 0..2 {
        for key in keys {
            let now = skin(&mut world, key)?;
            assert!(!now.is_empty());
            assert_eq!(previous(&mut world, key)?, now);
        }
        world.step_blocking(0.01)?;
    }
    let mut last = keys.map(|key| skin(&mut world, key).unwrap());
    let mut step = |world: &mut World, x: f64, moved: [bool; 3]| -> Result<()> {
        drive(world, x)?;
        world.step_blocking(0.01)?;
        for ((key, last), moved) in keys.into_iter().zip(&mut last).zip(moved) {
            let now = skin(world, key)?;
            assert_ne!(now, *last);
            assert_eq!(previous(world, key)?, if moved { &*last } else { &now }[..]);
            *last = now;
        }
        Ok(())
    };
    step(&mut world, 0.001, [true; 3])?;
    step(&mut world, 0.003, [true; 3])?;
    // Who is looked at between steps has not moved for that.
    let [_, second, _] = keys;
    let before = previous(&mut world, second)?;
    world.instance_mut(second)?;
    skin(&mut world, second)?;
    assert_eq!(previous(&mut world, second)?, before);
    // One is put elsewhere, the others move on.
    world.instance_mut(second)?.teleport_to(&at(0.5))?;
    step(&mut world, 0.004, [true, false, true])?;
    step(&mut world, 0.005, [true; 3])?;
    world.instance_mut(second)?.reset();
    assert_eq!(previous(&mut world, second)?, skin(&mut world, second)?);
    step(&mut world, 0.006, [true, false, true])?;
    world.instance_mut(second)?.sleep();
    step(&mut world, 0.007, [true; 3])?;
    // Who comes has not moved; another asset's instances have.
    let fourth = world.add_avatar(limb(4, 8))?;
    let fourth = world.add_instance(fourth)?;
    step(&mut world, 0.008, [true; 3])?;
    assert_eq!(previous(&mut world, fourth)?, skin(&mut world, fourth)?);
    // A jump in time is none in space.
    drive(&mut world, 0.1)?;
    world.step_blocking(2.0 * LONGEST_STEP)?;
    for key in keys {
        assert_eq!(previous(&mut world, key)?, skin(&mut world, key)?);
    }
    // Nor is there one where room was made for more.
    drive(&mut world, 0.11)?;
    world.step_blocking(0.01)?;
    world.add_instance(first_avatar)?;
    world.step_blocking(0.01)?;
    assert_eq!(previous(&mut world, second)?, skin(&mut world, second)?);
    Ok(())
}

#[test]
fn the_previous_skin_is_that_of_the_step_before() -> Result<()> {
    let (world, avatar, keys) = three(Backend::Cpu)?;
    check(world, avatar, keys)
}
