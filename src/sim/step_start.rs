//! What the skeleton's and the tissue's energies are told at the start of a step.

use super::instance::Instance;
use super::settings::Settings;
use crate::potential::StepStart;
use crate::skeleton::SkeletonStart;
use glam::DVec3;

/// What the skeleton's next step of an instance starts from.
pub(super) fn skeleton_start<'a>(settings: &Settings, instance: &'a Instance) -> SkeletonStart<'a> {
    SkeletonStart {
        time_step: settings.time_step,
        previous: &instance.previous.frames,
        current: &instance.state.frames,
        joint_stiffness: settings.joint_stiffness,
        bending: &instance.bending,
        limits: &instance.limits,
        targets: &instance.targets,
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
        previous: &instance.previous,
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
