//! Instances, bodies and colliders that come and go at run time.

use super::{converged, limb};
use supple::Result;
use supple::collider::{Collider, Shape};
use supple::glam::DVec3;
use supple::model::{Frame, RigidBody};

#[test]
fn what_goes_is_felt_no_more_and_its_key_names_nothing() -> Result<()> {
    let mut world = converged()?;
    let avatar = world.add_avatar(limb(4, 6))?;
    let first = world.add_instance(avatar)?;
    let aside = Frame {
        position: DVec3::Z,
        ..Frame::IDENTITY
    };
    let second = world.add_instance_at(avatar, &aside)?;
    let ball = Shape::Sphere { radius: 0.03 };
    let on_top = Frame {
        position: DVec3::new(0.12, 0.075, 0.0),
        ..Frame::IDENTITY
    };
    let ball = world.add_body(RigidBody::new("ball", ball, 1000.0)?.at(on_top))?;
    let floor = world.add_collider(Collider::new(Shape::HalfSpace, at(-5.0)))?;
    for _ in 0..30 {
        world.step_blocking(0.01)?;
    }
    assert!(world.instance(first)?.report().contacts > 0);
    assert_eq!(world.instance(second)?.report().contacts, 0);
    let before = world.instance(first)?.state().clone();
    world.remove_body(ball)?;
    world.remove_instance(second)?;
    world.remove_collider(floor)?;
    assert!(world.body_frame(ball).is_err());
    assert!(world.instance(second).is_err());
    assert!(world.collider_mut(floor).is_err());
    // The state goes on from where it was.
    assert_eq!(world.instance(first)?.state(), &before);
    world.step_blocking(0.01)?;
    assert_eq!(world.instance(first)?.report().contacts, 0);
    let third = world.add_instance(avatar)?;
    assert_ne!(third, second);
    world.step_blocking(0.01)?;
    world.remove_avatar(avatar)?;
    assert!(world.instance(first).is_err() && world.instance(third).is_err());
    world.step_blocking(0.01)?;
    Ok(())
}

fn at(y: f64) -> Frame {
    Frame {
        position: DVec3::Y * y,
        ..Frame::IDENTITY
    }
}
