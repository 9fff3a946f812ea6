//! The springs that keep the bind pose of a character that nothing else drives.

use super::contents::GRAVITY;
use crate::model::Avatar;
use glam::DVec3;
use std::sync::Arc;

/// Stiffness of the springs that keep each joint as it is bound, N·m/rad: the weight of what hangs on it, on the longest
/// lever that it has, turns it by [`SAG`] at most. What hangs on a joint is its own bone's matter and its descendants'.
pub(super) fn pose_stiffness(avatar: &Avatar) -> Arc<[f64]> {
    /// rad.
    const SAG: f64 = 0.001;
    let (skeleton, bones) = (&avatar.skeleton, avatar.bones());
    // Mass and first moment about the file's origin.
    let mut matter = vec![(0.0, DVec3::ZERO); skeleton.len()];
    for (j, mass) in avatar.bone_masses.iter().enumerate() {
        let (total, first) = mass.moments();
        matter[j] = (total, first + total * skeleton.joints[j]);
    }
    let cubature = &avatar.cubature;
    for i in 0..cubature.len() {
        for weight in cubature.skinning.row(i) {
            let mass = avatar.density * cubature.measure[i] * weight.weight;
            let (total, first) = &mut matter[weight.bone as usize];
            *total += mass;
            *first += mass * cubature.position[i];
        }
    }
    for j in (0..bones).rev() {
        if let Some(parent) = skeleton.parents[j] {
            let (mass, first) = matter[j];
            let (total, of_all) = &mut matter[parent as usize];
            *total += mass;
            *of_all += first;
        }
    }
    let stiffness = |(&(mass, first), joint): (&(f64, DVec3), &DVec3)| {
        let lever = (first - mass * *joint).length();
        lever * GRAVITY / SAG
    };
    matter.iter().zip(&skeleton.joints).map(stiffness).collect()
}
