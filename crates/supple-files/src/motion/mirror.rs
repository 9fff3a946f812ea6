//! Left and right exchanged: reflected across x = 0.

use super::pose::{BonePose, BonePoses, PoseHeader};
use crate::motion::motion_clip::{MotionClip, MotionFrame};
use glam::{DQuat, DVec3};
use std::collections::BTreeMap;
use supple_bake::body_parts;

const ACROSS: DVec3 = DVec3::new(-1.0, 1.0, 1.0);

/// The reflected rotation M R M, M = diag(−1, 1, 1).
fn reflected(q: DQuat) -> DQuat {
    DQuat::from_xyzw(q.x, -q.y, -q.z, q.w)
}

/// For each bone the one on the other side; itself where there is none.
fn partners(names: &[String]) -> Vec<usize> {
    let parts = body_parts(names);
    let partner = |(j, name): (usize, &String)| {
        let swapped = swap_words(name);
        let by_name = names.iter().position(|n| *n == swapped);
        let by_part = || {
            let part = parts[j]?;
            let other = super::BodyPart {
                side: Some(part.side?.other()),
                ..part
            };
            parts.iter().position(|p| *p == Some(other))
        };
        by_name.filter(|&k| k != j).or_else(by_part).unwrap_or(j)
    };
    names.iter().enumerate().map(partner).collect()
}

/// `left` for `right` and the other way round, in the three usual spellings.
fn swap_words(name: &str) -> String {
    for (left, right) in [("left", "right"), ("Left", "Right"), ("LEFT", "RIGHT")] {
        if name.contains(left) {
            return name.replacen(left, right, 1);
        }
        if name.contains(right) {
            return name.replacen(right, left, 1);
        }
    }
    name.to_string()
}

/// `clip` with left and right exchanged, across x = 0 of its rest pose and its world.
pub fn mirrored_clip(clip: &MotionClip) -> MotionClip {
    let partner = partners(&clip.bones);
    let mut at = vec![None; clip.bones.len()];
    for (k, bone) in clip.translated.iter().enumerate() {
        at[*bone as usize] = Some(k);
    }
    let mut translated: Vec<u32> = clip
        .translated
        .iter()
        .map(|b| partner[*b as usize] as u32)
        .collect();
    translated.sort_unstable();
    translated.dedup();
    let frame = |f: &MotionFrame| MotionFrame {
        translations: (translated.iter())
            .map(|b| at[partner[*b as usize]].map_or(DVec3::ZERO, |k| ACROSS * f.translations[k]))
            .collect(),
        rotations: partner.iter().map(|&j| reflected(f.rotations[j])).collect(),
    };
    MotionClip {
        rest_joints: (clip.rest_joints.as_ref())
            .map(|rest| partner.iter().map(|&j| ACROSS * rest[j]).collect()),
        frames: clip.frames.iter().map(frame).collect(),
        translated,
        ..clip.clone()
    }
}

/// A pose with left and right exchanged.
pub fn mirrored_poses(poses: &BonePoses) -> BonePoses {
    BonePoses {
        time: poses.time,
        bones: mirrored_bones(&poses.bones),
    }
}

/// A header with left and right exchanged.
pub fn mirrored_header(header: &PoseHeader) -> PoseHeader {
    PoseHeader {
        up: header.up,
        rest: mirrored_bones(&header.rest),
    }
}

fn mirrored_bones(bones: &BTreeMap<String, BonePose>) -> BTreeMap<String, BonePose> {
    let names: Vec<String> = bones.keys().cloned().collect();
    let poses: Vec<&BonePose> = bones.values().collect();
    let mirrored = |j: usize| BonePose {
        rotation: poses[j].rotation.map(reflected),
        position: poses[j].position.map(|p| ACROSS * p),
    };
    let partner = partners(&names);
    names
        .into_iter()
        .zip(partner.into_iter().map(mirrored))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use supple::internal::math::rotation_exp;

    #[test]
    fn twice_is_not_at_all_and_places_are_reflected() {
        let turn = |x: f64| DQuat::from_mat3(&rotation_exp(DVec3::new(x, 0.5, -0.2)));
        let clip = MotionClip {
            name: "wave".into(),
            bones: ["hips", "LeftArm", "RightArm", "LeftHand"]
                .map(Into::into)
                .to_vec(),
            parents: vec![None, Some(0), Some(0), Some(1)],
            rest_joints: Some(vec![DVec3::Y, DVec3::X, -DVec3::X, 2.0 * DVec3::X]),
            frame_time: 0.1,
            translated: vec![0],
            frames: vec![MotionFrame {
                translations: vec![DVec3::new(1.0, 2.0, 3.0)],
                rotations: vec![turn(0.1), turn(0.9), turn(-0.4), turn(0.3)],
            }],
            ..MotionClip::default()
        };
        let mirrored = mirrored_clip(&clip);
        mirrored.validate().unwrap();
        assert_eq!(mirrored_clip(&mirrored), clip);
        let place = |c: &MotionClip, bone: usize| c.world_frames(&c.frames[0])[bone].position;
        assert!((place(&mirrored, 2) - ACROSS * place(&clip, 1)).length() < 1e-12);
        assert!((place(&mirrored, 0) - ACROSS * place(&clip, 0)).length() < 1e-12);
    }
}
