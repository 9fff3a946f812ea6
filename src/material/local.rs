//! The material at one point: how stiff it is there, and which way its axes lie.

use super::Material;
use crate::math::{Mat9, turned};
use glam::{DMat3, DQuat};
use serde::{Deserialize, Serialize};

/// How the tissue at a point differs from the avatar's material.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct LocalTissue {
    /// Factor on the energy, and so on all stresses; positive.
    pub stiffness: f64,
    /// Turns the material's axes into those of the reference shape: x is the skin's normal carried into the
    /// depth, y runs along the bone, z around it.
    pub axes: DQuat,
    /// Stiffness-proportional damping β, s; not negative. A mode of f Hz whose tissue is all of this β has the damping ratio
    /// ζ = π f β.
    pub damping_time: f64,
    /// Share of muscle, 0 (fat, skin) to 1: what tension stiffens.
    pub muscle: f64,
}

impl Default for LocalTissue {
    fn default() -> Self {
        Self {
            stiffness: 1.0,
            axes: DQuat::IDENTITY,
            damping_time: 0.0,
            muscle: 0.0,
        }
    }
}

impl LocalTissue {
    /// Whether the numbers are usable.
    pub fn is_valid(&self) -> bool {
        self.stiffness > 0.0
            && self.stiffness.is_finite()
            && (self.axes.length_squared() - 1.0).abs() < 1e-6
            && self.damping_time >= 0.0
            && self.damping_time.is_finite()
            && (0.0..=1.0).contains(&self.muscle)
    }
}

/// A material at a point. With its axes G and its stiffness s, Ψ(F) = s Ψ_material(Gᵀ F G): materials do not see a
/// turn of the space they move in, so that Gᵀ F G, which stays near I with F, stands for F G.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MaterialPoint<'a> {
    /// The avatar's material, in its own axes.
    pub material: &'a Material,
    /// What the point has of its own.
    pub local: LocalTissue,
}

impl MaterialPoint<'_> {
    /// G, where the material sees it.
    fn axes(&self) -> Option<DMat3> {
        (!self.material.is_isotropic()).then(|| DMat3::from_quat(self.local.axes))
    }

    /// Gᵀ M G.
    fn inward(axes: Option<DMat3>, m: DMat3) -> DMat3 {
        axes.map_or(m, |g| g.transpose() * m * g)
    }

    /// Ψ(F), Pa.
    pub fn energy_density(&self, deformation_gradient: DMat3) -> f64 {
        let f = Self::inward(self.axes(), deformation_gradient);
        self.local.stiffness * self.material.energy_density(f)
    }

    /// Ψ(F + ΔF) − Ψ(F), Pa, as [`Material::energy_difference`].
    pub fn energy_difference(&self, deformation_gradient: DMat3, change: DMat3) -> f64 {
        let axes = self.axes();
        let (f, d) = (
            Self::inward(axes, deformation_gradient),
            Self::inward(axes, change),
        );
        self.local.stiffness * self.material.energy_difference(f, d)
    }

    /// P = ∂Ψ/∂F, Pa.
    pub fn pk1_stress(&self, deformation_gradient: DMat3) -> DMat3 {
        let axes = self.axes();
        let p = (self.material).pk1_stress(Self::inward(axes, deformation_gradient));
        axes.map_or(p, |g| g * p * g.transpose()) * self.local.stiffness
    }

    /// C = ∂P/∂F, Pa.
    pub fn tangent(&self, deformation_gradient: DMat3) -> Mat9 {
        self.outward(deformation_gradient, |f| self.material.tangent(f))
    }

    /// [`MaterialPoint::tangent`] with its negative eigenvalues set to 0, Pa.
    pub fn projected_tangent(&self, deformation_gradient: DMat3) -> Mat9 {
        self.outward(deformation_gradient, |f| self.material.projected_tangent(f))
    }

    fn outward(&self, f: DMat3, tangent: impl Fn(DMat3) -> Mat9) -> Mat9 {
        let axes = self.axes();
        let c = tangent(Self::inward(axes, f));
        let s = self.local.stiffness;
        axes.map_or(c, |g| turned(&c, g))
            .map(|row| row.map(|entry| s * entry))
    }
}
