//! Rigid frames.

use crate::math::{rotation_exp, rotation_log};
use glam::{DMat3, DQuat, DVec3};
use serde::{Deserialize, Serialize};

/// A rigid placement: `x = rotation · X + position`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Frame {
    /// Rotation matrix.
    pub rotation: DMat3,
    /// Origin in world space, m. For a bone this is its joint's place.
    pub position: DVec3,
}

impl Frame {
    /// No rotation, at the origin.
    pub const IDENTITY: Self = Self {
        rotation: DMat3::IDENTITY,
        position: DVec3::ZERO,
    };

    /// World place of the frame's own `point`.
    pub fn transform(&self, point: DVec3) -> DVec3 {
        self.rotation * point + self.position
    }

    /// The frame's own coordinates of the world `point`.
    pub fn inverse_transform(&self, point: DVec3) -> DVec3 {
        self.rotation.transpose() * (point - self.position)
    }

    /// World placement of what stands at `inner` in this frame.
    pub fn compose(&self, inner: &Self) -> Self {
        Self {
            rotation: self.rotation * inner.rotation,
            position: self.transform(inner.position),
        }
    }

    /// Whether it is finite with a proper rotation: RᵀR = I to the rounding of hand-written matrices, and det R > 0.
    pub fn is_rigid(&self) -> bool {
        self.position.is_finite() && is_rotation(&self.rotation)
    }

    /// c + δc and exp(\[δω\]) R, orthonormalised so that long runs do not drift off SO(3).
    pub fn moved(&self, translation: DVec3, rotation_vector: DVec3) -> Self {
        let rotation = rotation_exp(rotation_vector) * self.rotation;
        Self {
            rotation: DMat3::from_quat(DQuat::from_mat3(&rotation).normalize()),
            position: self.position + translation,
        }
    }

    /// `part` of the way to `other`: along a line, turning evenly about one axis. All of the way is `other` itself.
    pub fn between(&self, other: &Self, part: f64) -> Self {
        if part == 1.0 || self == other {
            return *other;
        }
        let (translation, rotation) = self.motion_to(other);
        self.moved(part * translation, part * rotation)
    }

    /// (δc, δω) such that `self.moved(δc, δω)` is `other`.
    pub fn motion_to(&self, other: &Self) -> (DVec3, DVec3) {
        (
            other.position - self.position,
            rotation_log(other.rotation * self.rotation.transpose()),
        )
    }
}

/// Whether RᵀR = I and det R = 1, to the rounding of hand-written matrices.
pub(crate) fn is_rotation(r: &DMat3) -> bool {
    let defect = r.transpose() * *r - DMat3::IDENTITY;
    // Comparisons with NaN are false, so what is not finite fails too.
    defect.to_cols_array().iter().all(|d| d.abs() < 1e-6) && r.determinant() > 0.0
}
