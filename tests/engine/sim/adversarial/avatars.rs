//! Who is caught in a storm.

use std::sync::OnceLock;
use supple::collider::Shape;
use supple::glam::{DMat3, DVec3};
use supple::model::{Avatar, Frame, JointRange, RigidBody};
use supple_bake::{CubatureRecipe, HandleRegion, Recipe, bake};
use supple_samples::Finger;

/// A coarse finger: three bones, 16 handles.
pub fn finger() -> &'static Avatar {
    static FINGER: OnceLock<Avatar> = OnceLock::new();
    FINGER.get_or_init(|| {
        let finger = Finger {
            edge_length: 0.004,
            ..Finger::default()
        };
        let recipe = Recipe {
            handles: vec![HandleRegion {
                count: Some(16),
                ..HandleRegion::default()
            }],
            cubature: CubatureRecipe {
                points: Some(120),
                ..CubatureRecipe::default()
            },
            ..Recipe::default()
        };
        bake(&finger.body().unwrap(), &recipe, &mut |_| {})
            .unwrap()
            .0
    })
}

/// The finger with a rough ball of 20 g that comes within its reach, and joints of 30° each way.
pub fn company() -> &'static Avatar {
    static COMPANY: OnceLock<Avatar> = OnceLock::new();
    COMPANY.get_or_init(|| {
        let ball = RigidBody {
            friction: 0.8,
            ..RigidBody::new("ball", Shape::Sphere { radius: BALL }, 1e3).unwrap()
        };
        let mut avatar = finger().clone().with_bodies([ball.of_mass(0.02).at(AWAY)]);
        let limits = &mut avatar.as_mut().unwrap().skeleton.limits;
        let most = DVec3::splat(0.5);
        let hinge = JointRange::Axes {
            axes: DMat3::IDENTITY,
            least: -most,
            most,
        };
        let cone = JointRange::Cone {
            axis: DVec3::X,
            swing: 0.5,
            twist: [-0.5, 0.5],
        };
        limits.extend([(1, hinge), (2, cone)]);
        avatar.unwrap()
    })
}

/// Radius of the ball, m.
pub const BALL: f64 = 0.012;

/// Where the ball touches nothing.
pub const AWAY: Frame = Frame {
    rotation: DMat3::IDENTITY,
    position: DVec3::new(0.0, 0.0, 1.0),
};
