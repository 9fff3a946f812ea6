//! Avatars stood up in worlds of another up.

use supple::glam::{DQuat, DVec3};
use supple::internal::math::rotation_exp;
use supple::internal::random_avatar;
use supple::model::{Frame, RigidBody, UpAxis};
use supple::{Result, collider::Shape};

#[test]
fn soles_at_height_zero_of_the_file_stand_at_height_zero_of_the_world() -> Result<()> {
    let mut avatar = random_avatar(4, 3, 5, 10, 60);
    for up in [UpAxis::X, UpAxis::Y, UpAxis::Z] {
        avatar.up = up;
        for world in [UpAxis::X, UpAxis::Y, UpAxis::Z] {
            let state = avatar.placed(&avatar.standing(world));
            for (frame, joint) in state.frames.iter().zip(&avatar.skeleton.joints) {
                let height = frame.position.dot(world.direction());
                assert_eq!(height, joint.dot(up.direction()));
                assert_eq!(frame.position.length_squared(), joint.length_squared());
                assert_eq!(frame.rotation * up.direction(), world.direction());
            }
        }
    }
    avatar.up = UpAxis::Z;
    assert_eq!(
        avatar.placed(&avatar.standing(UpAxis::Z)),
        avatar.rest_state()
    );
    Ok(())
}

#[test]
fn a_placement_moves_bones_rigidly_and_leaves_bodies() -> Result<()> {
    let ball = RigidBody::new("ball", Shape::Sphere { radius: 0.1 }, 1000.0)?;
    let place = Frame {
        position: DVec3::X,
        ..Frame::IDENTITY
    };
    let avatar = random_avatar(4, 3, 5, 10, 60).with_bodies([ball.at(place)])?;
    let turn = DVec3::new(0.3, -0.8, 1.2);
    let placement = Frame {
        rotation: rotation_exp(turn),
        position: DVec3::new(1.0, 2.0, 3.0),
    };
    let state = avatar.placed(&placement);
    assert_eq!(state.frames[3], place);
    for (frame, joint) in state.frames[..3].iter().zip(&avatar.skeleton.joints) {
        let wanted = DQuat::from_scaled_axis(turn) * *joint + placement.position;
        assert!(frame.position.distance(wanted) < 1e-15);
        assert_eq!(frame.rotation, placement.rotation);
    }
    Ok(())
}
