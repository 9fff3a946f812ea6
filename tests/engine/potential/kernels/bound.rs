//! The one comparison of f32 results with f64 ones.
//!
//! A sum of products whose longest path from an input to the result has k roundings is computed in f32 to
//! within γ_k Σ|terms| (Higham, Accuracy and Stability of Numerical Algorithms, §3.1), γ_k = k u/(1 − k u),
//! u = 2⁻²⁴. WGSL rounds sums and products correctly, quotients and square roots not ([`QUOTIENT`], [`ROOT`]). Every check states its k, and takes Σ|terms| from the same formula on absolute values.

use supple::glam::{DMat3, DVec3};

/// Unit roundoff of f32.
pub const U: f64 = 1.0 / (1 << 24) as f64;

/// A quotient: WGSL allows it 2.5 ulp, each of which is up to two roundings.
pub const QUOTIENT: usize = 5;
/// A square root: as accurate as 1/inverseSqrt(x), which is a quotient and 2 ulp.
pub const ROOT: usize = 4 + QUOTIENT;
/// |v|: a square and two sums (3 on the longest path), of which the root halves what they are off by, and the root.
pub const LENGTH: usize = 2 + ROOT;

/// What a check says: what differs, and by how much.
pub type Outcome = Result<(), String>;

/// Numbers that a check compares.
#[derive(Default)]
pub struct Comparison {
    got: Vec<f64>,
    want: Vec<f64>,
    bound: Vec<f64>,
}

impl Comparison {
    /// Adds a number whose terms sum to `magnitude` in absolute value, after `roundings` at most.
    pub fn number(&mut self, got: f64, want: f64, magnitude: f64, roundings: usize) {
        let k = roundings as f64 * U;
        self.got.push(got);
        self.want.push(want);
        // Below the smallest normal number f32 may flush to zero.
        let floor = f64::from(f32::MIN_POSITIVE) * roundings as f64;
        self.bound.push(k / (1.0 - k) * magnitude + floor);
    }

    /// Adds a vector.
    pub fn vector(&mut self, got: DVec3, want: DVec3, magnitude: DVec3, roundings: usize) {
        for axis in 0..3 {
            self.number(got[axis], want[axis], magnitude[axis], roundings);
        }
    }

    /// Adds a matrix.
    pub fn matrix(&mut self, got: DMat3, want: DMat3, magnitude: DMat3, roundings: usize) {
        for column in 0..3 {
            self.vector(
                got.col(column),
                want.col(column),
                magnitude.col(column),
                roundings,
            );
        }
    }

    /// Whether every number is within its bound; nothing at all to compare is a failure too.
    pub fn finish(&self, what: &str) -> Outcome {
        if self.want.iter().all(|w| *w == 0.0) {
            return Err(format!("{what}: the twin is zero everywhere"));
        }
        let ratio = |i: usize| (self.got[i] - self.want[i]).abs() / self.bound[i];
        for i in 0..self.got.len() {
            // A NaN is never within.
            if ratio(i) > 1.0 || ratio(i).is_nan() {
                return Err(format!(
                    "{what}: number {i} is {}, the twin says {}, {:.3} of its bound",
                    self.got[i],
                    self.want[i],
                    ratio(i)
                ));
            }
        }
        Ok(())
    }
}

/// |M| by component.
pub fn abs(m: DMat3) -> DMat3 {
    DMat3::from_cols(m.x_axis.abs(), m.y_axis.abs(), m.z_axis.abs())
}

/// a × b with the minus signs made plus: of absolute values, the terms that cancel in a cross product.
pub fn abs_cross(a: DVec3, b: DVec3) -> DVec3 {
    let (a, b) = (a.abs(), b.abs());
    DVec3::new(
        a.y * b.z + a.z * b.y,
        a.z * b.x + a.x * b.z,
        a.x * b.y + a.y * b.x,
    )
}

/// |\[v\]×|.
pub fn abs_skew(v: DVec3) -> DMat3 {
    let v = v.abs();
    DMat3::from_cols(
        DVec3::new(0.0, v.z, v.y),
        DVec3::new(v.z, 0.0, v.x),
        DVec3::new(v.y, v.x, 0.0),
    )
}

/// The cofactor matrix with all signs plus.
pub fn abs_cofactor(m: DMat3) -> DMat3 {
    DMat3::from_cols(
        abs_cross(m.y_axis, m.z_axis),
        abs_cross(m.z_axis, m.x_axis),
        abs_cross(m.x_axis, m.y_axis),
    )
}

/// The determinant with all signs plus.
pub fn abs_determinant(m: DMat3) -> f64 {
    m.x_axis.abs().dot(abs_cross(m.y_axis, m.z_axis))
}

/// Σ|M_ii|.
pub fn abs_trace(m: DMat3) -> f64 {
    m.x_axis.x.abs() + m.y_axis.y.abs() + m.z_axis.z.abs()
}
