//! What the skeleton's and the tissue's energies are told at the start of a step.

use super::instance::Instance;
use super::settings::Settings;
use crate::model::{InertiaShare, InertialTarget};
use crate::potential::StepStart;
use crate::skeleton::SkeletonStart;
use glam::DVec3;

/// The longest frame that animation comes in, s.
const SLOWEST_FRAME: f64 = 1.0 / 30.0;

/// Where inertia draws to in the next step of an instance.
pub(super) fn target<'a>(settings: &Settings, instance: &'a Instance) -> InertialTarget<'a> {
    let target = (instance.history).target(settings.integrator, settings.time_step);
    // Of a root that springs draw nobody knows where it goes.
    let share = instance.pin_of(0).and_then(|pin| {
        // Steps within a frame have its acceleration all at once, where one frame's even motion goes over into the next one's.
        let h = settings.time_step;
        let longest = settings.largest_acceleration * h * h.max(SLOWEST_FRAME);
        InertiaShare::new(
            &target,
            &instance.state,
            &pin.frame,
            instance.inertia_share,
            longest,
        )
    });
    InertialTarget { share, ..target }
}

/// What the skeleton's next step of an instance starts from.
pub(super) fn skeleton_start<'a>(settings: &Settings, instance: &'a Instance) -> SkeletonStart<'a> {
    SkeletonStart {
        inertia: target(settings, instance),
        current: &instance.state.frames,
        joint_stiffness: settings.joint_stiffness,
        bending: &instance.bending,
        limits: &instance.limits,
        targets: &instance.targets,
        preload: instance.preload,
        gravity: instance.gravity,
        tissue_gravity: instance.factors.gravity,
        pose_offsets: instance.pose_offsets.as_slice(),
    }
}

/// What the tissue's next step of an instance starts from, with `prescribed` frames.
pub(super) fn tissue_start<'a>(
    settings: &Settings,
    captured_under_gravity: bool,
    instance: &'a Instance,
    prescribed: &'a [bool],
) -> StepStart<'a> {
    StepStart {
        time_step: settings.time_step,
        inertia: target(settings, instance),
        current: &instance.state,
        colliders: &instance.colliders,
        slip_speed: settings.slip_speed,
        geometric_contact: settings.geometric_contact,
        factors: instance.factors,
        pose_offsets: instance.pose_offsets.as_slice(),
        prescribed,
        // A captured shape already sags: the tissue's weight is then among the skeleton's terms.
        tissue_gravity: if captured_under_gravity {
            DVec3::ZERO
        } else {
            instance.gravity
        },
    }
}
