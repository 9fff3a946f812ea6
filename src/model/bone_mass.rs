//! Mass and second moments of a rigid bone or body.

use super::{Frame, Surface};
use glam::{DMat3, DVec3};
use serde::{Deserialize, Serialize};

/// Second moments of a rigid bone about its joint.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct BoneMass {
    /// S = ∫ ρ y yᵀ dV with y = (X − J, 1): `s[row][column]`, kg m², kg m, kg. `s[3][3]` is the mass.
    pub second_moment: [[f64; 4]; 4],
}

impl BoneMass {
    /// No matter at all.
    pub const NONE: Self = Self {
        second_moment: [[0.0; 4]; 4],
    };

    /// Matter whose principal axes are those of its own frame and whose centre is the frame's origin.
    pub fn centred(mass: f64, second: DVec3) -> Self {
        let mut out = Self::NONE;
        for i in 0..3 {
            out.second_moment[i][i] = second[i];
        }
        out.second_moment[3][3] = mass;
        out
    }

    /// What fills a closed surface, about `joint`. Exact: each triangle spans a signed tet with the
    /// joint, and over a tet (0, a, b, c) of volume V
    /// ∫ y = V s/4, ∫ y yᵀ = V/20 (a aᵀ + b bᵀ + c cᵀ + s sᵀ), s = a + b + c.
    pub fn of_surface(surface: &Surface, joint: DVec3, density: f64) -> Self {
        let mut mass = Self::NONE;
        for t in 0..surface.triangles.len() {
            let [a, b, c] = surface.corners(t).map(|x| x - joint);
            let (s, volume) = (a + b + c, a.dot(b.cross(c)) / 6.0);
            for p in [a, b, c, s] {
                mass.add_point(p, 0.0, density * volume / 20.0);
            }
            let first = density * volume / 4.0 * s;
            for i in 0..3 {
                mass.second_moment[i][3] += first[i];
                mass.second_moment[3][i] += first[i];
            }
            mass.second_moment[3][3] += density * volume;
        }
        mass
    }

    /// S += m (p, w)(p, w)ᵀ.
    pub fn add_point(&mut self, p: DVec3, w: f64, m: f64) {
        let y = p.extend(w).to_array();
        for i in 0..4 {
            for j in 0..4 {
                self.second_moment[i][j] += m * y[i] * y[j];
            }
        }
    }

    /// The mass, kg.
    pub fn mass(&self) -> f64 {
        self.second_moment[3][3]
    }

    /// The mass, kg, and the first moment about the joint, kg m.
    pub fn moments(&self) -> (f64, DVec3) {
        let s = &self.second_moment;
        (s[3][3], DVec3::new(s[0][3], s[1][3], s[2][3]))
    }

    /// ∫ ρ y yᵀ dV with y = X − J, kg m².
    pub fn second(&self) -> DMat3 {
        let s = &self.second_moment;
        let column = |j: usize| DVec3::new(s[0][j], s[1][j], s[2][j]);
        DMat3::from_cols(column(0), column(1), column(2))
    }

    /// Linear momentum of the matter on its way from one frame to the other, kg m/s: m ċ + Ṙ s, s the first moment.
    pub fn momentum(&self, before: &Frame, after: &Frame, time_step: f64) -> DVec3 {
        let (mass, first) = self.moments();
        let (turn, way) = change(before, after);
        (turn * first + mass * way) / time_step
    }

    /// Kinetic energy of the matter on its way from one frame to the other, J: ½ tr(Ȧ S Ȧᵀ) with A = \[R | c\].
    pub fn kinetic_energy(&self, before: &Frame, after: &Frame, time_step: f64) -> f64 {
        let (mass, first) = self.moments();
        let (turn, way) = change(before, after);
        let turned = turn * self.second();
        let turning: f64 = (0..3).map(|k| turned.col(k).dot(turn.col(k))).sum();
        let moving = 2.0 * way.dot(turn * first) + mass * way.length_squared();
        0.5 * (turning + moving) / (time_step * time_step)
    }

    /// The same matter `factor` times as dense.
    pub fn scaled(&self, factor: f64) -> Self {
        Self {
            second_moment: self.second_moment.map(|row| row.map(|s| factor * s)),
        }
    }
}

/// ΔR and Δc.
fn change(before: &Frame, after: &Frame) -> (DMat3, DVec3) {
    (
        after.rotation - before.rotation,
        after.position - before.position,
    )
}
