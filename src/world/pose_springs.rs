//! The springs and dampers of a character's joints that nothing else drives.

use super::contents::GRAVITY;
use crate::model::Avatar;
use glam::DVec3;
use std::sync::Arc;

/// How a joint keeps the bind pose of what hangs on it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PoseSpring {
    /// N·m/rad: the weight of what hangs on it, on the longest lever that it has, turns it by [`SAG`] at most.
    pub stiffness: f64,
    /// N·m·s: no swing of that spring.
    pub damping: f64,
    /// N·m·s, of a joint that nothing holds.
    pub relaxed_damping: f64,
}

/// rad.
const SAG: f64 = 0.001;

/// ζ of a relaxed person's shank that swings as a pendulum: the peaks of a pendulum test fall from 0.94 to 0.60, 0.38 and
/// 0.26 rad, one in 1.1 s (J Clin Med Res Sports Med Doping Stud, doi 10.4172/2161-0673.S6-001, figure 1).
const RELAXED_DAMPING_RATIO: f64 = 0.07;

/// What hangs on a joint, about the file's origin.
#[derive(Clone, Copy, Default)]
struct Matter {
    /// kg.
    mass: f64,
    /// ∫ ρ X dV, kg m.
    first: DVec3,
    /// ∫ ρ |X|² dV, kg m².
    second: f64,
}

impl Matter {
    fn add(&mut self, other: Self) {
        self.mass += other.mass;
        self.first += other.first;
        self.second += other.second;
    }

    fn spring(&self, joint: DVec3) -> PoseSpring {
        let moment = GRAVITY * (self.first - self.mass * joint).length();
        let second = self.second - 2.0 * joint.dot(self.first) + self.mass * joint.length_squared();
        // The mean over all axes.
        let inertia = 2.0 / 3.0 * second.max(0.0);
        let critical = |stiffness: f64| 2.0 * (stiffness * inertia).sqrt();
        PoseSpring {
            stiffness: moment / SAG,
            damping: critical(moment / SAG),
            relaxed_damping: RELAXED_DAMPING_RATIO * critical(moment),
        }
    }
}

/// The springs of all joints. What hangs on a joint is its own bone's matter and its descendants'.
pub(super) fn pose_springs(avatar: &Avatar) -> Arc<[PoseSpring]> {
    let skeleton = &avatar.skeleton;
    let mut matter = vec![Matter::default(); skeleton.len()];
    for ((bone, &joint), matter) in avatar
        .bone_masses
        .iter()
        .zip(&skeleton.joints)
        .zip(&mut matter)
    {
        let ((mass, first), second) = (bone.moments(), bone.second());
        let trace = second.x_axis.x + second.y_axis.y + second.z_axis.z;
        *matter = Matter {
            mass,
            first: first + mass * joint,
            second: trace + 2.0 * joint.dot(first) + mass * joint.length_squared(),
        };
    }
    let cubature = &avatar.cubature;
    for i in 0..cubature.len() {
        let x = cubature.position[i];
        for weight in cubature.skinning.row(i) {
            let mass = avatar.density * cubature.measure[i] * weight.weight;
            matter[weight.bone as usize].add(Matter {
                mass,
                first: mass * x,
                second: mass * x.length_squared(),
            });
        }
    }
    for j in (0..avatar.bones()).rev() {
        if let Some(parent) = skeleton.parents[j] {
            let of_child = matter[j];
            matter[parent as usize].add(of_child);
        }
    }
    let springs = matter.iter().zip(&skeleton.joints);
    springs
        .map(|(matter, joint)| matter.spring(*joint))
        .collect()
}
