//! One pose in a JSON or JavaScript file; such as WebXR's hands, as emulators keep them:
//! `{jointTransforms: {wrist: {offsetMatrix: [16 numbers]}, …}}`.
//!
//! WebXR's matrices turn a joint's own axes (−z along the bone) to the world's, and nothing says how those
//! axes lie at rest; so only the joints' places are taken from them. Files with `bones` hold what a line of
//! a pose stream does.

use super::js_literal::first_object;
use crate::file;
use crate::motion::{BonePose, BonePoses, PoseHeader};
use crate::pose_stream::{bone_pose, numbers};
use glam::DVec3;
use serde_json::Value;
use std::path::Path;
use supple::model::UpAxis;
use supple::{Error, Result};

/// Reads the pose at `path`.
///
/// # Errors
/// [`Error::Io`]; [`Error::Format`] with line or key.
pub fn read_pose(path: impl AsRef<Path>) -> Result<(PoseHeader, BonePoses)> {
    let path = path.as_ref();
    parse_pose(&file::read_text(path)?, path)
}

/// Reads a pose from `text`; `path` names it in errors. See [`read_pose`].
pub fn parse_pose(text: &str, path: &Path) -> Result<(PoseHeader, BonePoses)> {
    let broken = |field: String, problem: String| Error::format(path, field, problem);
    let object =
        first_object(text).map_err(|(line, problem)| broken(format!("line {line}"), problem))?;
    let mut header = PoseHeader::default();
    let bones = |key: &str| object.get(key).and_then(Value::as_object);
    let mut poses = BonePoses::default();
    if let Some(joints) = bones("jointTransforms") {
        header.up = Some(UpAxis::Y);
        for (name, joint) in joints {
            let matrix = joint.get("offsetMatrix").and_then(numbers::<16>);
            let matrix = matrix.ok_or_else(|| {
                let field = format!("jointTransforms.{name}.offsetMatrix");
                broken(field, "16 numbers expected".into())
            })?;
            let position = Some(DVec3::new(matrix[12], matrix[13], matrix[14]));
            poses.bones.insert(
                name.clone(),
                BonePose {
                    rotation: None,
                    position,
                },
            );
        }
    } else if let Some(bones) = bones("bones") {
        for (name, value) in bones {
            let pose = bone_pose(value, 1.0);
            let pose = pose.map_err(|problem| broken(format!("bones.{name}"), problem))?;
            poses.bones.insert(name.clone(), pose);
        }
    }
    if poses.bones.is_empty() {
        let problem = "holds neither jointTransforms (WebXR's hand) nor bones";
        return Err(broken("pose".into(), problem.into()));
    }
    Ok((header, poses))
}
