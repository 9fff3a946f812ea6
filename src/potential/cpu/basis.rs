//! What a handle does at a point.

use crate::math::Mat9;
use crate::model::BasisEntry;
use glam::{DMat3, DVec3};

/// The share N of one handle in the unposed displacement of one point, T = x̄ + Σ N_h φ_h, and its gradient:
/// F = I + Σ_h (∂N_h/∂X) φ_h. The biharmonic basis has N = U I; other bases (modes, elastic
/// extensions) fill all of N.
pub trait Basis: Copy + Send + Sync {
    /// Handle index.
    fn handle(&self) -> usize;

    /// N, without unit.
    fn value(&self) -> DMat3;

    /// ∂N/∂X_l for l = x, y, z, 1/m: `gradient()[l] φ` is column l of the handle's part of F.
    fn gradient(&self) -> [DMat3; 3];

    /// The same, as a point holds it that both kinds move.
    fn mixed(&self) -> Mixed {
        Mixed::Block(GeneralBasis {
            handle: self.handle() as u32,
            value: self.value(),
            gradient: self.gradient(),
        })
    }

    /// N φ.
    fn displacement(&self, phi: DVec3) -> DVec3 {
        self.value() * phi
    }

    /// Nᵀ f.
    fn pull_back(&self, force: DVec3) -> DVec3 {
        self.value().transpose() * force
    }

    /// M N.
    fn after(&self, m: DMat3) -> DMat3 {
        m * self.value()
    }

    /// (∂N/∂X) φ: the handle's part of F.
    fn deformation(&self, phi: DVec3) -> DMat3 {
        let [x, y, z] = self.gradient();
        DMat3::from_cols(x * phi, y * phi, z * phi)
    }

    /// (∂N/∂X)ᵀ : P, the force of the stress P on the handle.
    fn stress_force(&self, stress: DMat3) -> DVec3 {
        let g = self.gradient();
        (0..3).map(|l| g[l].transpose() * stress.col(l)).sum()
    }

    /// (∂N/∂X)ᵀ : C for a symmetric C: the force on the handle is Σ_l `[l]` ΔF_l over the columns of ΔF.
    fn stiffness(&self, c: &Mat9) -> [DMat3; 3] {
        let g = self.gradient();
        std::array::from_fn(|l| (0..3).map(|m| g[m].transpose() * block(c, m, l)).sum())
    }

    /// S : ∂N/∂X with S the [`Basis::stiffness`] of another handle.
    fn contract(&self, stiffness: &[DMat3; 3]) -> DMat3 {
        let g = self.gradient();
        (0..3).map(|l| stiffness[l] * g[l]).sum()
    }

    /// Nᵀ_own M, N/m, by which every block (own, other) of a point starts.
    fn before(&self, m: DMat3) -> DMat3 {
        self.value().transpose() * m
    }

    /// A point's block (own, this) by columns: `metric` N + S : ∂N/∂X with `metric` the other's [`Basis::before`] and S its
    /// [`Basis::stiffness`].
    #[inline]
    fn block(&self, metric: DMat3, stiffness: &[DMat3; 3]) -> [f64; 9] {
        (metric * self.value() + self.contract(stiffness)).to_cols_array()
    }
}

/// Block (l, m) of C: how column l of the stress follows column m of F.
fn block(c: &Mat9, l: usize, m: usize) -> DMat3 {
    let column = |k| DVec3::from_array(std::array::from_fn(|i| c[3 * l + i][3 * m + k]));
    DMat3::from_cols(column(0), column(1), column(2))
}

/// The plain scalar case: N = U I, ∂N/∂X = I ⊗ ∇U.
impl Basis for BasisEntry {
    fn handle(&self) -> usize {
        self.handle as usize
    }

    fn mixed(&self) -> Mixed {
        Mixed::Scalar(*self)
    }

    fn value(&self) -> DMat3 {
        DMat3::from_diagonal(DVec3::splat(self.value))
    }

    fn gradient(&self) -> [DMat3; 3] {
        self.gradient
            .to_array()
            .map(|g| DMat3::from_diagonal(DVec3::splat(g)))
    }

    #[inline]
    fn displacement(&self, phi: DVec3) -> DVec3 {
        self.value * phi
    }

    #[inline]
    fn pull_back(&self, force: DVec3) -> DVec3 {
        self.value * force
    }

    #[inline]
    fn after(&self, m: DMat3) -> DMat3 {
        m * self.value
    }

    #[inline]
    fn deformation(&self, phi: DVec3) -> DMat3 {
        let g = self.gradient;
        DMat3::from_cols(phi * g.x, phi * g.y, phi * g.z)
    }

    #[inline]
    fn stress_force(&self, stress: DMat3) -> DVec3 {
        stress * self.gradient
    }

    #[inline]
    fn stiffness(&self, c: &Mat9) -> [DMat3; 3] {
        let g = self.gradient.to_array();
        // C is symmetric: its rows are read as columns, which are contiguous.
        std::array::from_fn(|l| {
            let column = |k: usize| {
                let row = &c[3 * l + k];
                DVec3::from_array(std::array::from_fn(|i| {
                    g[0] * row[i] + g[1] * row[3 + i] + g[2] * row[6 + i]
                }))
            };
            DMat3::from_cols(column(0), column(1), column(2))
        })
    }

    #[inline]
    fn before(&self, m: DMat3) -> DMat3 {
        m * self.value
    }

    /// Nine equal sums: they go into vector registers.
    #[inline]
    fn block(&self, metric: DMat3, stiffness: &[DMat3; 3]) -> [f64; 9] {
        let (u, g) = (self.value, self.gradient);
        let m = metric.to_cols_array();
        let [x, y, z] = [0, 1, 2].map(|l| stiffness[l].to_cols_array());
        std::array::from_fn(|k| u * m[k] + g.x * x[k] + g.y * y[k] + g.z * z[k])
    }

    #[inline]
    fn contract(&self, stiffness: &[DMat3; 3]) -> DMat3 {
        let g = self.gradient;
        stiffness[0] * g.x + stiffness[1] * g.y + stiffness[2] * g.z
    }
}

/// A basis function with nothing special about it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GeneralBasis {
    /// Handle index.
    pub handle: u32,
    /// N.
    pub value: DMat3,
    /// ∂N/∂X_l, 1/m.
    pub gradient: [DMat3; 3],
}

impl Basis for GeneralBasis {
    fn handle(&self) -> usize {
        self.handle as usize
    }

    fn value(&self) -> DMat3 {
        self.value
    }

    fn gradient(&self) -> [DMat3; 3] {
        self.gradient
    }
}

impl From<&BasisEntry> for GeneralBasis {
    fn from(entry: &BasisEntry) -> Self {
        Self {
            handle: entry.handle,
            value: entry.value(),
            gradient: Basis::gradient(entry),
        }
    }
}

/// A number or a block: coarse handles beside fine ones.
#[derive(Clone, Copy, Debug, PartialEq)]
#[expect(
    clippy::large_enum_variant,
    reason = "rows of points are walked in order: a box would be a jump for each"
)]
pub enum Mixed {
    /// N = U I.
    Scalar(BasisEntry),
    /// All of N.
    Block(GeneralBasis),
}

/// Calls a method of whichever it is.
macro_rules! either {
    ($self:ident, $one:ident => $call:expr) => {
        match $self {
            Mixed::Scalar($one) => $call,
            Mixed::Block($one) => $call,
        }
    };
}

impl Basis for Mixed {
    #[inline]
    fn handle(&self) -> usize {
        either!(self, n => n.handle())
    }

    fn value(&self) -> DMat3 {
        either!(self, n => n.value())
    }

    fn gradient(&self) -> [DMat3; 3] {
        either!(self, n => Basis::gradient(n))
    }

    fn mixed(&self) -> Mixed {
        *self
    }

    #[inline]
    fn displacement(&self, phi: DVec3) -> DVec3 {
        either!(self, n => n.displacement(phi))
    }

    #[inline]
    fn pull_back(&self, force: DVec3) -> DVec3 {
        either!(self, n => n.pull_back(force))
    }

    #[inline]
    fn after(&self, m: DMat3) -> DMat3 {
        either!(self, n => n.after(m))
    }

    #[inline]
    fn deformation(&self, phi: DVec3) -> DMat3 {
        either!(self, n => n.deformation(phi))
    }

    #[inline]
    fn stress_force(&self, stress: DMat3) -> DVec3 {
        either!(self, n => n.stress_force(stress))
    }

    #[inline]
    fn stiffness(&self, c: &Mat9) -> [DMat3; 3] {
        either!(self, n => n.stiffness(c))
    }

    #[inline]
    fn contract(&self, stiffness: &[DMat3; 3]) -> DMat3 {
        either!(self, n => n.contract(stiffness))
    }

    #[inline]
    fn before(&self, m: DMat3) -> DMat3 {
        either!(self, n => n.before(m))
    }

    #[inline]
    fn block(&self, metric: DMat3, stiffness: &[DMat3; 3]) -> [f64; 9] {
        either!(self, n => n.block(metric, stiffness))
    }
}
