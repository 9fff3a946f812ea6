//! The f64 evaluation as a whole: batches, determinism, errors, the drawn skin, the smallest det F.

mod batches;
mod errors;
mod invariance;
mod offsets;

use std::sync::Arc;
use supple::collider::{Collider, Shape};
use supple::glam::{DMat3, DVec3};
use supple::internal::random_avatar;
use supple::model::{Avatar, Frame, InertialTarget, State};
use supple::potential::{StepStart, TissueFactors};

fn avatar() -> Arc<Avatar> {
    Arc::new(random_avatar(7, 4, 12, 90, 300))
}

fn floor(height: f64) -> Collider {
    let frame = Frame {
        rotation: DMat3::IDENTITY,
        position: DVec3::Z * height,
    };
    Collider {
        margin: 1e-3,
        ..Collider::new(Shape::HalfSpace, frame)
    }
}

fn start<'a>(previous: &'a State, current: &'a State, colliders: &'a [Collider]) -> StepStart<'a> {
    StepStart {
        time_step: 0.01,
        inertia: InertialTarget::backward_euler(previous, 0.01),
        current,
        colliders,
        tissue_gravity: DVec3::ZERO,
        slip_speed: 1e-3,
        geometric_contact: false,
        factors: TissueFactors::default(),
        pose_offsets: &[],
        prescribed: &[],
    }
}
