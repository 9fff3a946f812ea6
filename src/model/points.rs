//! Material points and what moves them: cubature points, skin vertices and mesh nodes alike.

use super::Skeleton;
use crate::math::Rows;
use crate::{Error, Result};
use glam::DVec3;
use serde::{Deserialize, Serialize};

/// The share of a bone in a point's motion.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SkinWeight {
    /// Bone index.
    pub bone: u32,
    /// w, with Σ w = 1 over a point.
    pub weight: f64,
}

/// The share of a handle in a point's unposed displacement.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct BasisEntry {
    /// Handle index.
    pub handle: u32,
    /// U, without unit.
    pub value: f64,
    /// ∇U, 1/m; zero where no gradient is needed (skin vertices).
    pub gradient: DVec3,
}

/// Pose blend shapes at a set of points: B_P = Σ feature · column.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PoseBlend {
    /// Number of features: 9 for each bone but a root, or 0 for none.
    pub features: usize,
    /// Column `k` at point `i` is `columns[k * points + i]`, m.
    pub columns: Vec<[f32; 3]>,
}

/// Points of the unposed reference shape.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PointSet {
    /// X, m; the shape blend B_S(β₀) is already in it.
    pub position: Vec<DVec3>,
    /// Cubature weight (m³) of a tissue point, area (m²) of a skin vertex.
    pub measure: Vec<f64>,
    /// Bones of each point.
    pub skinning: Rows<SkinWeight>,
    /// Handles of each point.
    pub basis: Rows<BasisEntry>,
    /// Pose blend shapes.
    pub pose_blend: PoseBlend,
}

impl PointSet {
    /// Number of points.
    pub fn len(&self) -> usize {
        self.position.len()
    }

    /// Whether there is no point.
    pub fn is_empty(&self) -> bool {
        self.position.is_empty()
    }

    /// Checks lengths, indices and finiteness; `field` names the set in errors.
    pub fn validate(&self, field: &str, skeleton: &Skeleton, handles: usize) -> Result<()> {
        let (count, bones) = (self.len(), skeleton.len());
        // Roots have no feature.
        let features = 9 * skeleton.parents.iter().flatten().count();
        if self.measure.len() != count {
            return Err(Error::invalid(
                format!("{field}.measure"),
                format!("{} values, expected {count}", self.measure.len()),
            ));
        }
        self.skinning
            .validate(&format!("{field}.skinning"), count)?;
        self.basis.validate(&format!("{field}.basis"), count)?;
        let blend = &self.pose_blend;
        if blend.features.checked_mul(count) != Some(blend.columns.len()) {
            return Err(Error::invalid(
                format!("{field}.pose_blend"),
                format!(
                    "{} columns for {} features",
                    blend.columns.len(),
                    blend.features
                ),
            ));
        }
        if blend.features != 0 && blend.features != features {
            return Err(Error::invalid(
                format!("{field}.pose_blend.features"),
                format!("{}, expected {features}", blend.features),
            ));
        }
        let finite = self.position.iter().all(|p| p.is_finite())
            && self.measure.iter().all(|m| m.is_finite())
            && self.skinning.entries().iter().all(|w| w.weight.is_finite())
            && self
                .basis
                .entries()
                .iter()
                .all(|u| u.value.is_finite() && u.gradient.is_finite())
            && blend.columns.iter().flatten().all(|c| c.is_finite());
        if !finite {
            return Err(Error::invalid(field, "holds a value that is not finite"));
        }
        if self
            .skinning
            .entries()
            .iter()
            .any(|w| w.bone as usize >= bones)
        {
            return Err(Error::invalid(
                format!("{field}.skinning"),
                "names a bone that is not there",
            ));
        }
        if self
            .skinning
            .iter()
            .any(|row| (row.iter().map(|w| w.weight).sum::<f64>() - 1.0).abs() > 1e-5)
        {
            return Err(Error::invalid(
                format!("{field}.skinning"),
                "weights of a point do not sum to 1",
            ));
        }
        if self
            .basis
            .entries()
            .iter()
            .any(|u| u.handle as usize >= handles)
        {
            return Err(Error::invalid(
                format!("{field}.basis"),
                "names a handle that is not there",
            ));
        }
        let rising = |row: &[BasisEntry]| row.is_sorted_by(|a, b| a.handle < b.handle);
        if !self.basis.iter().all(rising) {
            return Err(Error::invalid(
                format!("{field}.basis"),
                "handles of a point must rise",
            ));
        }
        Ok(())
    }
}
