//! A bone's pose in JSON.

use crate::motion::BonePose;
use glam::{DMat3, DMat4, DQuat, DVec3};
use serde_json::Value;

/// A bone from its JSON object; the error begins with the key at fault.
pub(crate) fn bone_pose(value: &Value, unit: f64) -> Result<BonePose, String> {
    let object = value.as_object().ok_or(": is no object")?;
    let mut pose = BonePose::default();
    for (key, value) in object {
        let wrong = |wanted: &str| format!(".{key}: {wanted} expected");
        match key.as_str() {
            "rotation" => {
                pose.rotation = Some(rotation(value).map_err(|e| format!(".{key}: {e}"))?)
            }
            "position" => {
                let p = numbers::<3>(value).ok_or_else(|| wrong("3 numbers"))?;
                pose.position = Some(unit * DVec3::from_array(p));
            }
            "matrix" => {
                let m = numbers::<16>(value).ok_or_else(|| wrong("16 numbers"))?;
                let m = DMat4::from_cols_array(&m);
                pose.position = Some(unit * m.w_axis.truncate());
                let turn = DMat3::from_mat4(m);
                pose.rotation = Some(quaternion(turn).map_err(|e| format!(".{key}: {e}"))?);
            }
            _ => return Err(format!(".{key}: is none of rotation, position and matrix")),
        }
    }
    if pose == BonePose::default() {
        return Err(": has neither rotation nor position".into());
    }
    Ok(pose)
}

/// So many finite numbers.
pub(crate) fn numbers<const N: usize>(value: &Value) -> Option<[f64; N]> {
    let array = value.as_array()?;
    let numbers: Option<Vec<f64>> = array.iter().map(Value::as_f64).collect();
    let numbers: [f64; N] = numbers?.try_into().ok()?;
    numbers.iter().all(|n| n.is_finite()).then_some(numbers)
}

/// A quaternion x y z w, or three rows.
fn rotation(value: &Value) -> Result<DQuat, String> {
    if let Some(q) = numbers::<4>(value) {
        let q = DQuat::from_array(q);
        return match (q.length() - 1.0).abs() < TOLERANCE {
            true => Ok(q.normalize()),
            false => Err(format!(
                "a quaternion of length {} is no rotation",
                q.length()
            )),
        };
    }
    let rows = value.as_array().map(|rows| rows.iter().map(numbers::<3>));
    match rows
        .and_then(|rows| rows.collect::<Option<Vec<_>>>())
        .as_deref()
    {
        Some([x, y, z]) => {
            quaternion(DMat3::from_cols((*x).into(), (*y).into(), (*z).into()).transpose())
        }
        _ => Err("4 numbers x y z w or 3 rows of 3 expected".into()),
    }
}

/// Rotations may miss their length or right angles by this much: they come in f32 and rounded.
const TOLERANCE: f64 = 1e-2;

fn quaternion(m: DMat3) -> Result<DQuat, String> {
    let defect = m.transpose() * m - DMat3::IDENTITY;
    let right = defect
        .to_cols_array()
        .iter()
        .all(|d| d.abs() < 2.0 * TOLERANCE);
    match right && m.determinant() > 0.0 {
        true => Ok(DQuat::from_mat3(&m).normalize()),
        false => Err(
            "the matrix is no rotation: its columns must be unit vectors at right angles".into(),
        ),
    }
}
