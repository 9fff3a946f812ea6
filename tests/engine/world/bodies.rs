//! Bodies that several avatars touch: one system, equal forces, momentum kept.

use super::{CONVERGED, converged, limb};
use supple::collider::Shape;
use supple::glam::DVec3;
use supple::internal::cpu::mechanics;
use supple::model::{Frame, Integrator, RigidBody};
use supple::sim::Settings;
use supple::world::{BodyId, Character, InstanceId};
use supple::{Result, World};

const BOX: Shape = Shape::Box {
    half_extents: [0.04, 0.03, 0.02],
};

/// The limbs' radius and half the box, m.
const APART: f64 = 0.04 + 0.03;

fn at(y: f64) -> Frame {
    Frame {
        position: DVec3::Y * y,
        ..Frame::IDENTITY
    }
}

/// Two limbs of different assets with a box between them, `gap` from each, nothing falling.
fn box_between(gap: f64) -> Result<(World, [InstanceId; 2], BodyId)> {
    let mut world = converged()?.with_up(supple::model::UpAxis::Z);
    world.set_gravity(DVec3::ZERO);
    let (a, b) = (limb(5, 8), limb(6, 10));
    let [a, b] = [world.add_avatar(a)?, world.add_avatar(b)?];
    let left = world.add_instance_at(a, &at(-APART - gap))?;
    let right = world.add_instance_at(b, &at(APART + gap))?;
    let body = RigidBody::new("box", BOX, 500.0)?.at(Frame {
        position: DVec3::X * 0.125,
        ..Frame::IDENTITY
    });
    let body = world.add_body(body)?;
    Ok((world, [left, right], body))
}

/// Momentum of all that moves, kg m/s.
fn momentum(world: &World, instances: &[InstanceId], body: BodyId, h: f64) -> Result<DVec3> {
    let of_avatar = |character: &Character| {
        let instance = character.instance();
        let (before, after) = (instance.history.previous(), &instance.state);
        mechanics(character.avatar(), before, after, h, DVec3::ZERO).momentum
    };
    let of_body = RigidBody::new("box", BOX, 500.0)?.mass;
    let (before, after) = world.body_motion(body)?;
    let mut sum = of_body.momentum(&before, &after, h);
    for &instance in instances {
        sum += of_avatar(world.instance(instance)?);
    }
    Ok(sum)
}

#[test]
fn a_box_squeezed_by_two_assets_meets_equal_forces() -> Result<()> {
    let (mut world, limbs, body) = box_between(0.0)?;
    let h = 0.01;
    for step in 1..=60 {
        let pressed = 0.004 * f64::from(step.min(30)) / 30.0;
        for (limb, side) in limbs.into_iter().zip([-1.0, 1.0]) {
            let frame = at(side * (APART - pressed));
            world.instance_mut(limb)?.follow_frames(&[frame])?;
        }
        world.step_blocking(h)?;
    }
    let [left, right] = limbs.map(|limb| world.instance(limb).unwrap().report().contact_force);
    println!("{left} {right} N");
    assert!(left.y < -1.0, "{left}: not pressed");
    assert!(
        (left + right).length() < 0.01 * left.length(),
        "{left} against {right}"
    );
    let place = world.body_frame(body)?.position;
    // The softer one gives way more.
    assert!(place.y.abs() < 0.004, "{place}");
    Ok(())
}

#[test]
fn what_flies_together_keeps_its_momentum() -> Result<()> {
    let (world, limbs, body) = box_between(0.002)?;
    // Whose momentum is that of a step's chord.
    let mut world = world.with_settings(Settings {
        integrator: Integrator::BackwardEuler,
        solver: CONVERGED,
        report_at_end: true,
        ..Settings::default()
    })?;
    let h = 0.005;
    for limb in limbs {
        world.instance_mut(limb)?.ragdoll(0.0)?;
    }
    world.step_blocking(h)?;
    for (limb, side) in limbs.into_iter().zip([-1.0, 0.4]) {
        let instance = world.instance_mut(limb)?.instance_mut();
        let velocity = DVec3::new(0.0, -0.5 * side, 0.1);
        let at = instance.state.frames[0];
        instance.set_motion(0, at, velocity, DVec3::ZERO);
    }
    let start = momentum(&world, &limbs, body, h)?;
    assert!(start.length() > 0.01);
    let (mut touched, mut moved) = ([false; 2], 0.0f64);
    let body_momentum = |world: &World| -> Result<DVec3> {
        let (before, after) = world.body_motion(body)?;
        Ok(RigidBody::new("box", BOX, 500.0)?
            .mass
            .momentum(&before, &after, h))
    };
    for _ in 0..60 {
        let before = body_momentum(&world)?;
        world.step_blocking(h)?;
        // ṗ = f: nothing but the avatars' contact moves the box.
        let (after, push) = (
            body_momentum(&world)?,
            world.body_report(body)?.contact_force,
        );
        let change = (after - before) / h;
        assert!(
            (change - push).length() < 1e-5 * (1.0 + push.length()),
            "{change} {push}"
        );
        for (touched, limb) in touched.iter_mut().zip(limbs) {
            *touched |= world.instance(limb)?.report().contacts > 0;
        }
        let now = momentum(&world, &limbs, body, h)?;
        moved = moved.max((now - start).length());
    }
    assert_eq!(touched, [true; 2], "nothing met");
    println!("{:e} of {start} kg m/s", moved / start.length());
    assert!(moved < 1e-6 * start.length(), "{moved:e} of {start}");
    Ok(())
}
