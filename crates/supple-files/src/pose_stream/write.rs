//! Poses as JSON lines, as [`crate::pose_stream::read::PoseParser`] reads them.

use crate::motion::{BonePose, BonePoses, MotionClip, PoseHeader};
use serde_json::{Map, Value, json};
use std::collections::BTreeMap;
use supple::{Error, Result};

/// The line that comes before all poses.
pub fn pose_header_line(header: &PoseHeader) -> String {
    let mut line = Map::new();
    if let Some(up) = header.up {
        line.insert("up".into(), json!(up));
    }
    if !header.rest.is_empty() {
        line.insert("rest".into(), bones(&header.rest));
    }
    Value::Object(line).to_string() + "\n"
}

/// The line of one pose.
pub fn pose_line(poses: &BonePoses) -> String {
    json!({"time": poses.time, "bones": bones(&poses.bones)}).to_string() + "\n"
}

fn bones(bones: &BTreeMap<String, BonePose>) -> Value {
    let bone = |pose: &BonePose| {
        let mut value = Map::new();
        if let Some(q) = pose.rotation {
            value.insert("rotation".into(), json!(q.to_array()));
        }
        if let Some(p) = pose.position {
            value.insert("position".into(), json!(p.to_array()));
        }
        Value::Object(value)
    };
    let bones = bones.iter().map(|(name, pose)| (name.clone(), bone(pose)));
    Value::Object(bones.collect())
}

/// A clip as a stream of poses: what comes before them, and a pose for each frame.
///
/// # Errors
/// [`Error::Invalid`] of a clip whose rest pose and world have different axes up, or whose rest pose is not
/// known: a stream has no way to say so.
pub fn clip_as_poses(clip: &MotionClip) -> Result<(PoseHeader, Vec<BonePoses>)> {
    clip.validate()?;
    let Some(rest) = clip
        .rest_joints
        .as_ref()
        .filter(|_| clip.rest_up == clip.world_up)
    else {
        let problem = "a stream needs a rest pose, with the same axis up as the clip's world";
        return Err(Error::invalid("motion", problem));
    };
    let place = |p: &glam::DVec3| BonePose {
        rotation: None,
        position: Some(*p),
    };
    let header = PoseHeader {
        up: Some(clip.world_up),
        rest: clip
            .bones
            .iter()
            .cloned()
            .zip(rest.iter().map(place))
            .collect(),
    };
    let pose = |(k, frame): (usize, &crate::motion::MotionFrame)| {
        let rotations = clip.world_rotations(frame);
        let frames = clip.world_frames(frame);
        let bones = rotations
            .into_iter()
            .zip(frames)
            .map(|(rotation, frame)| BonePose {
                rotation: Some(rotation),
                position: Some(frame.position),
            });
        BonePoses {
            time: clip.frame_time * k as f64,
            bones: clip.bones.iter().cloned().zip(bones).collect(),
        }
    };
    Ok((header, clip.frames.iter().enumerate().map(pose).collect()))
}
