//! Inertia of rigid bones.

use super::term::{FrameHessian, FrameTerm, add_block};
use crate::math::skew;
use crate::model::{BoneMass, Frame, InertialTarget};
use glam::{DMat3, DVec3};

/// E = 1/(2h̃²) tr((A − Â) S (A − Â)ᵀ), A = \[R | c\] (3×4), Â = Σ c_k Aⁿ⁻ᵏ.
///
/// S = ∫ρ y yᵀ dV, y = (X − J, 1): exactly Σ m/(2h̃²) |x − x̂|² over the bone's own matter. Its
/// Gauss–Newton Hessian is the rigid body's mass matrix over h̃².
#[derive(Clone, Copy, Debug)]
pub struct BoneInertia {
    bone: usize,
    /// S in blocks: ∫ρ yyᵀ, ∫ρ y and the mass.
    second: DMat3,
    first: DVec3,
    mass: f64,
    /// 1/h̃².
    inverse_square_step: f64,
    /// Aⁿ, and Â − Aⁿ in place of Â, so that increments are all that is ever subtracted.
    current: Frame,
    inertial: (DMat3, DVec3),
}

impl BoneInertia {
    /// The term of `bone` in a step from `current`.
    pub fn new(bone: usize, mass: &BoneMass, target: &InertialTarget<'_>, current: &Frame) -> Self {
        let (second, (total, first)) = (mass.second(), mass.moments());
        Self {
            bone,
            second,
            first,
            mass: total,
            inverse_square_step: 1.0 / (target.step * target.step),
            current: *current,
            inertial: target.frame(bone, current),
        }
    }

    /// A − Â = (A − Aⁿ) − (Â − Aⁿ).
    fn deviation(&self, frame: &Frame) -> (DMat3, DVec3) {
        (
            frame.rotation - self.current.rotation - self.inertial.0,
            frame.position - self.current.position - self.inertial.1,
        )
    }

    /// D S in its first three columns and its last one.
    fn weighted(&self, (rotation, position): (DMat3, DVec3)) -> (DMat3, DVec3) {
        let outer = DMat3::from_cols(
            position * self.first.x,
            position * self.first.y,
            position * self.first.z,
        );
        (
            rotation * self.second + outer,
            rotation * self.first + position * self.mass,
        )
    }
}

impl FrameTerm for BoneInertia {
    fn difference(&self, base: &[Frame], frames: &[Frame]) -> f64 {
        let (base, frame) = (&base[self.bone], &frames[self.bone]);
        let (r, c) = self.deviation(frame);
        let (r0, c0) = self.deviation(base);
        // tr(D S Dᵀ) − tr(D₀ S D₀ᵀ) = ⟨A − A₀, (D + D₀) S⟩
        let (wr, wc) = self.weighted((r + r0, c + c0));
        let step = frame.rotation - base.rotation;
        let columns = (0..3).map(|k| step.col(k).dot(wr.col(k))).sum::<f64>();
        0.5 * self.inverse_square_step * (columns + (frame.position - base.position).dot(wc))
    }

    fn add_derivatives(
        &self,
        frames: &[Frame],
        gradient: &mut [f64],
        hessian: &mut FrameHessian<'_>,
    ) {
        let frame = &frames[self.bone];
        let (translation, rotation) = (2 * self.bone, 2 * self.bone + 1);
        let scale = self.inverse_square_step;
        let (wr, wc) = self.weighted(self.deviation(frame));
        add_block(gradient, translation, scale * wc);
        // ∫ρ (R y) × (D y) is the axial vector of N − Nᵀ with N = (D S)₃ Rᵀ.
        let n = wr * frame.rotation.transpose();
        let torque = DVec3::new(
            n.y_axis.z - n.z_axis.y,
            n.z_axis.x - n.x_axis.z,
            n.x_axis.y - n.y_axis.x,
        );
        add_block(gradient, rotation, scale * torque);

        let first = frame.rotation * self.first;
        let second = frame.rotation * self.second * frame.rotation.transpose();
        let trace = second.x_axis.x + second.y_axis.y + second.z_axis.z;
        hessian.add(
            translation,
            translation,
            DMat3::IDENTITY * (scale * self.mass),
        );
        hessian.add(rotation, translation, skew(first) * scale);
        hessian.add(
            rotation,
            rotation,
            (DMat3::from_diagonal(DVec3::splat(trace)) - second) * scale,
        );
    }

    fn add_geometric(&self, frames: &[Frame], hessian: &mut FrameHessian<'_>) {
        // ⟨D S, [ω]×² R⟩ = ωᵀ (sym N − tr(N) I) ω with N = (D S)₃ Rᵀ.
        let frame = &frames[self.bone];
        let (wr, _) = self.weighted(self.deviation(frame));
        let n = wr * frame.rotation.transpose();
        let trace = n.x_axis.x + n.y_axis.y + n.z_axis.z;
        let rotation = 2 * self.bone + 1;
        let curvature = (n + n.transpose()) * 0.5 - DMat3::from_diagonal(DVec3::splat(trace));
        hessian.add(rotation, rotation, curvature * self.inverse_square_step);
    }
}
