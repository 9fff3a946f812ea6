//! Fine handles in a world: a budget that may change, room for nearer ones, bodies that wake them, snapshots.

use crate::sim::fine::{LIMB, RADIUS, apart, sphere, way};
use std::sync::Arc;
use supple::collider::{Collider, Shape};
use supple::glam::DVec3;
use supple::model::{Avatar, Frame, RigidBody, UpAxis};
use supple::potential::CpuPotential;
use supple::sim::{Pin, Settings, Simulation, SkinSpring};
use supple::world::{Backend, ColliderId, InstanceId};
use supple::{Result, World};

/// The limb with its bone followed, a sphere above it, and how many fine handles may be awake.
fn world(budget: usize) -> Result<(World, InstanceId, ColliderId)> {
    let settings = Settings {
        fine_handles: budget,
        ..Settings::default()
    };
    let mut world = World::new(Backend::Cpu)?
        .with_up(UpAxis::Z)
        .with_settings(settings)?;
    let avatar = world.add_avatar(Arc::new(Avatar {
        up: UpAxis::Z,
        ..LIMB.clone()
    }))?;
    let limb = world.add_instance(avatar)?;
    let shape = Shape::Sphere { radius: RADIUS };
    let collider = world.add_collider(Collider::new(shape, sphere(-0.06)))?;
    Ok((world, limb, collider))
}

fn step(
    world: &mut World,
    limb: InstanceId,
    collider: ColliderId,
    frame: Frame,
) -> Result<Vec<DVec3>> {
    let at = LIMB.rest_state().frames;
    world.instance_mut(limb)?.follow_frames(&at)?;
    world.collider_mut(collider)?.frame = frame;
    world.step_blocking(0.01)?;
    let (mut skin, mut normals) = (Vec::new(), Vec::new());
    world.read_skin_blocking(limb, &mut skin, &mut normals)?;
    Ok(skin)
}

fn longest(displacement: &[DVec3]) -> f64 {
    displacement.iter().map(|d| d.length()).fold(0.0, f64::max)
}

fn awake(world: &World, limb: InstanceId) -> Result<Vec<u32>> {
    let mut awake = world.instance(limb)?.state().awake.clone();
    awake.sort_unstable();
    Ok(awake)
}

/// Bit by bit what the layer below does, and without a budget what it does without slots.
#[test]
fn a_world_wakes_what_a_simulation_wakes() -> Result<()> {
    for budget in [0, 12] {
        let (mut world, limb, collider) = world(budget)?;
        let avatar = Avatar {
            up: UpAxis::Z,
            ..LIMB.clone()
        };
        let avatar = Arc::new(avatar.with_fine_slots(budget)?);
        let potential = CpuPotential::new(avatar.clone(), 1)?;
        let mut simulation = Simulation::new(&avatar, potential, *world.settings())?;
        let instance = &mut simulation.instances_mut()[0];
        let frame = instance.state.frames[0];
        instance.pins.push(Pin { bone: 0, frame });
        let shape = Shape::Sphere { radius: RADIUS };
        (instance.colliders).push(Collider::new(shape, sphere(-0.06)));
        let (mut skin, mut normals, mut most) = (Vec::new(), Vec::new(), 0);
        let mut deepest = 0.0f64;
        for depth in way(0.005).into_iter().take(110) {
            let of_world = step(&mut world, limb, collider, sphere(depth))?;
            simulation.instances_mut()[0].colliders[0].frame = sphere(depth);
            simulation.step_blocking()?;
            simulation.read_skin_blocking(0, &mut skin, &mut normals)?;
            assert_eq!(
                world.instance(limb)?.state(),
                &simulation.instances()[0].state
            );
            assert!(of_world == skin, "{depth}");
            most = most.max(awake(&world, limb)?.len());
            let displacement = world.instance(limb)?.displacement();
            let (shown, drawn) = (longest(&displacement), apart(&skin, &LIMB.skin.position));
            assert!((shown - drawn).abs() < 1e-9, "{shown} {drawn}");
            deepest = deepest.max(shown);
        }
        assert_eq!(most, budget);
        assert!(deepest > 3e-3, "{deepest}");
    }
    Ok(())
}

#[test]
fn a_budget_may_change_between_steps() -> Result<()> {
    let (mut world, limb, collider) = world(0)?;
    let mut before = Vec::new();
    for depth in way(0.002).into_iter().take(65) {
        before = step(&mut world, limb, collider, sphere(depth))?;
    }
    assert!(awake(&world, limb)?.is_empty());
    let mut set = |world: &mut World, budget: usize, steps: usize| -> Result<(usize, f64)> {
        let settings = Settings {
            fine_handles: budget,
            ..*world.settings()
        };
        world.set_settings(settings)?;
        let mut jump = 0.0f64;
        for _ in 0..steps {
            let now = step(world, limb, collider, sphere(0.002))?;
            jump = jump.max(apart(&now, &before));
            before = now;
        }
        Ok((awake(world, limb)?.len(), jump))
    };
    // What wakes in a press takes its share of it: the skin yields by less than the press is deep.
    let (count, jump) = set(&mut world, 8, 30)?;
    assert!(count == 8 && jump < 2e-3, "{count}, {jump}");
    let (count, jump) = set(&mut world, 5, 200)?;
    assert!(count == 5 && jump < 3e-4, "{count}, {jump}");
    let (count, jump) = set(&mut world, 0, 250)?;
    assert!(count == 0 && jump < 3e-4, "{count}, {jump}");
    Ok(())
}

/// A sphere that slides further than the budget reaches has the nearest handles under it all the way.
#[test]
fn the_nearest_have_the_room() -> Result<()> {
    const BUDGET: usize = 6;
    let (mut world, limb, collider) = world(BUDGET)?;
    let along = |x: f64| Frame {
        position: DVec3::new(x, 0.0, 0.04 + RADIUS - 2e-3),
        ..Frame::IDENTITY
    };
    let distance = |handle: u32, x: f64| {
        let position = LIMB.fine.positions[handle as usize];
        position.distance(along(x).position) - RADIUS
    };
    let mut seen = Vec::new();
    for k in 0..600 {
        let x = 0.07 + 1e-3 * f64::from(k.min(110));
        step(&mut world, limb, collider, along(x))?;
        let awake = awake(&world, limb)?;
        assert!(awake.len() <= BUDGET);
        seen.extend(awake);
    }
    let end = 0.18;
    let last = awake(&world, limb)?;
    let farthest = last.iter().map(|h| distance(*h, end)).fold(0.0, f64::max);
    let waiting = (0..LIMB.fine.len() as u32).filter(|h| !last.contains(h));
    let nearest = waiting
        .map(|h| distance(h, end))
        .fold(f64::INFINITY, f64::min);
    assert!(
        farthest < nearest + LIMB.fine.spacing + 2e-3,
        "{farthest} {nearest}"
    );
    seen.sort_unstable();
    seen.dedup();
    assert!(seen.len() > 3 * BUDGET, "{}", seen.len());
    Ok(())
}

#[test]
fn a_body_wakes_them_and_a_restored_world_goes_on_with_the_same_bits() -> Result<()> {
    let (mut world, limb, collider) = world(15)?;
    let away = Frame {
        position: DVec3::Z * 5.0,
        ..Frame::IDENTITY
    };
    let ball = RigidBody::new("ball", Shape::Sphere { radius: RADIUS }, 2000.0)?;
    world.add_body(ball.at(Frame {
        position: DVec3::new(0.125, 0.0, 0.1),
        ..Frame::IDENTITY
    }))?;
    let run = |world: &mut World, steps: usize| -> Result<Vec<DVec3>> {
        let mut skin = Vec::new();
        for _ in 0..steps {
            skin = step(world, limb, collider, away)?;
        }
        Ok(skin)
    };
    run(&mut world, 20)?;
    assert_eq!(awake(&world, limb)?.len(), 15);
    let snapshot = world.snapshot()?;
    let skin = run(&mut world, 15)?;
    let handles = world.instance(limb)?.state().clone();
    // In a world that had another budget, and in this one.
    let (mut other, ..) = self::world(3)?;
    for world in [&mut other, &mut world] {
        world.restore(&snapshot)?;
        assert_eq!(world.settings().fine_handles, 15);
        let again = run(world, 15)?;
        assert!(again == skin && *world.instance(limb)?.state() == handles);
    }
    assert!(apart(&skin, &LIMB.skin.position) > 1e-4);
    Ok(())
}

/// What takes hold of the skin wakes them, and they are part of the point that it holds.
#[test]
fn a_spring_on_the_skin_wakes_them_and_pulls_at_them() -> Result<()> {
    const STIFFNESS: f64 = 300.0;
    let pulled = |budget: usize| -> Result<f64> {
        let (mut world, limb, _) = world(budget)?;
        world.set_gravity(DVec3::ZERO);
        let settings = Settings {
            solver: super::CONVERGED,
            ..*world.settings()
        };
        world.set_settings(settings)?;
        let top = DVec3::new(0.125, 0.0, 0.04);
        let distance = |v: &usize| LIMB.skin.position[*v].distance(top);
        let vertices = 0..LIMB.skin.len();
        let vertex = vertices.min_by(|a, b| distance(a).total_cmp(&distance(b)));
        let vertex = vertex.unwrap_or_default();
        let start = LIMB.skin.position[vertex];
        let to = start + DVec3::new(0.004, 0.0, 0.008);
        let at = LIMB.rest_state().frames;
        world.instance_mut(limb)?.follow_frames(&at)?;
        world.step_blocking(0.01)?;
        let avatar = world.instance(limb)?.avatar().clone();
        let spring = SkinSpring::new(&avatar, vertex, to, STIFFNESS)?;
        world.instance_mut(limb)?.pull_skin(&[spring]);
        let (mut skin, mut normals) = (Vec::new(), Vec::new());
        for _ in 0..150 {
            world.instance_mut(limb)?.follow_frames(&at)?;
            world.step_blocking(0.01)?;
        }
        world.read_skin_blocking(limb, &mut skin, &mut normals)?;
        assert_eq!(awake(&world, limb)?.len(), budget);
        let force = STIFFNESS * (to - skin[vertex]);
        let load = world.instance(limb)?.report().loads[0].force;
        let error = (load + force).length();
        assert!(error < 1e-3 * force.length(), "{load} N, {force} N");
        Ok(skin[vertex].distance(start))
    };
    let (coarse, fine) = (pulled(0)?, pulled(12)?);
    assert!(fine > 1.3 * coarse, "{fine} m, {coarse} m");
    Ok(())
}
