//! Ranges of joints as recipes and scenes give them.

use glam::{DMat3, DVec3};
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;
use supple::model::{JointRange, Skeleton};
use supple::{Error, Result};

/// The range of one joint: a box (`least_degrees` and `most_degrees`), or a cone (`axis`, `swing_degrees` and
/// `twist_degrees`). Rotations are relative to the parent and from the bind pose.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct JointLimitKey {
    /// Name of the bone.
    pub bone: String,
    /// Least angle about each axis of the box.
    pub least_degrees: Option<DVec3>,
    /// Most angle about each.
    pub most_degrees: Option<DVec3>,
    /// The box's first and second axis in the bind pose; the third is across both. x and y if not given.
    pub axes: Option<[DVec3; 2]>,
    /// The direction that stays in the cone, in the bind pose.
    pub axis: Option<DVec3>,
    /// Most angle between it and where it was.
    pub swing_degrees: Option<f64>,
    /// Least and most twist about it; any if not given.
    pub twist_degrees: Option<[f64; 2]>,
}

impl JointLimitKey {
    /// The range.
    ///
    /// # Errors
    /// [`Error::Invalid`] of a key that is missing, too many or unusable; `field` names the limit.
    pub fn range(&self, field: &str) -> Result<JointRange> {
        let radians = |v: DVec3| v * (PI / 180.0);
        let range = match (
            self.least_degrees,
            self.most_degrees,
            self.axis,
            self.swing_degrees,
        ) {
            (Some(least), Some(most), None, None) if self.twist_degrees.is_none() => {
                let [x, y] = self.axes.unwrap_or([DVec3::X, DVec3::Y]);
                let third = x.cross(y).normalize_or_zero();
                let first = x.normalize_or_zero();
                JointRange::Axes {
                    axes: DMat3::from_cols(first, third.cross(first), third),
                    least: radians(least),
                    most: radians(most),
                }
            }
            (None, None, Some(axis), Some(swing)) if self.axes.is_none() => JointRange::Cone {
                axis: axis.normalize_or_zero(),
                swing: swing.to_radians(),
                twist: self
                    .twist_degrees
                    .unwrap_or([-180.0, 180.0])
                    .map(f64::to_radians),
            },
            _ => {
                let problem = "needs least_degrees and most_degrees (axes if wanted), or axis and \
                               swing_degrees (twist_degrees if wanted)";
                return Err(Error::invalid(field, problem));
            }
        };
        range.validate(field).map(|()| range)
    }
}

/// Gives `skeleton` the ranges of `limits`, in place of those that these bones have.
///
/// # Errors
/// [`Error::Invalid`] naming a limit whose bone is not there or has no parent, or whose range is none.
pub fn set_limits(skeleton: &mut Skeleton, limits: &[JointLimitKey]) -> Result<()> {
    for (i, key) in limits.iter().enumerate() {
        let field = format!("limits[{i}]");
        let range = key.range(&field)?;
        let Some(bone) = skeleton.find(&key.bone) else {
            let bones = skeleton.names.join(", ");
            let problem = format!("no bone is called {:?}; there are {bones}", key.bone);
            return Err(Error::invalid(format!("{field}.bone"), problem));
        };
        if skeleton.parents[bone].is_none() {
            let problem = format!("{:?} has no parent to turn against", key.bone);
            return Err(Error::invalid(format!("{field}.bone"), problem));
        }
        skeleton.limits.retain(|limit| limit.0 as usize != bone);
        skeleton.limits.push((bone as u32, range));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Limb;
    use crate::recipe::Recipe;

    #[test]
    fn ranges_are_read_and_what_is_wrong_is_named() {
        let mut skeleton = Limb::S.body().unwrap().skeleton;
        skeleton.names.push("tip".into());
        skeleton.parents.push(Some(0));
        skeleton.joints.push(DVec3::X);
        let mut set = |text: &str| -> std::result::Result<JointRange, String> {
            let recipe: Recipe = toml::from_str(text).map_err(|e| e.to_string())?;
            recipe.validate().map_err(|e| e.to_string())?;
            set_limits(&mut skeleton, &recipe.limits).map_err(|e| e.to_string())?;
            assert_eq!(skeleton.limits.len(), 1);
            Ok(skeleton.limits[0].1)
        };
        let text = "[[limits]]\nbone = \"tip\"\n";
        let read = set(&format!(
            "{text}least_degrees = [-90.0, 0.0, 0.0]\nmost_degrees = [0.0, 45.0, 0.0]\naxes = [[0.0, 2.0, 0.0], [0.0, 1.0, 1.0]]"
        ));
        let Ok(JointRange::Axes { axes, least, .. }) = read else {
            panic!("{read:?}")
        };
        assert_eq!((axes.x_axis, axes.y_axis), (DVec3::Y, DVec3::Z));
        assert!((least.x + PI / 2.0).abs() < 1e-15);
        let read = set(&format!(
            "{text}axis = [3.0, 0.0, 0.0]\nswing_degrees = 60.0"
        ));
        let Ok(JointRange::Cone { axis, twist, .. }) = read else {
            panic!("{read:?}")
        };
        assert_eq!((axis, twist), (DVec3::X, [-PI, PI]));
        for (keys, message) in [
            ("axis = [1.0, 0.0, 0.0]", "swing_degrees"),
            (
                "axis = [0.0, 0.0, 0.0]\nswing_degrees = 1.0",
                "no direction",
            ),
            (
                "least_degrees = [1.0, 0.0, 0.0]\nmost_degrees = [0.0, 0.0, 0.0]",
                "least ≤ most",
            ),
            ("swing_degree = 1.0", "swing_degree"),
        ] {
            let error = set(&format!("{text}{keys}")).unwrap_err();
            assert!(error.contains(message), "{error}");
        }
        let cone = "axis = [1.0, 0.0, 0.0]\nswing_degrees = 1.0";
        for (bone, message) in [("toe", "no bone"), ("bone", "no parent")] {
            let error = set(&format!("[[limits]]\nbone = \"{bone}\"\n{cone}")).unwrap_err();
            assert!(error.contains(message), "{error}");
        }
    }
}
