//! A bar of tissue that is pulled, its sides free.

use glam::{DMat3, DVec3};
use supple::internal::math::Mat9;
use supple::material::{Material, Orthotropic};

/// Stretches of a bar pulled to `stretch` along `axis` whose sides bear nothing: Newton on the two side stretches,
/// from those that keep the volume.
pub(super) fn stretches(material: &Material, axis: usize, stretch: f64) -> DVec3 {
    let (j, k) = ((axis + 1) % 3, (axis + 2) % 3);
    let mut s = DVec3::splat(1.0 / stretch.sqrt());
    s[axis] = stretch;
    for _ in 0..100 {
        let f = DMat3::from_diagonal(s);
        let (p, c): (DMat3, Mat9) = (material.pk1_stress(f), material.projected_tangent(f));
        // Entry (i, i) of a matrix is number 4 i of its flattening.
        let at = |row: usize, column: usize| c[4 * row][4 * column];
        let (pj, pk) = (p.col(j)[j], p.col(k)[k]);
        let determinant = at(j, j) * at(k, k) - at(j, k) * at(k, j);
        let step_j = (at(k, k) * pj - at(j, k) * pk) / determinant;
        let step_k = (at(j, j) * pk - at(k, j) * pj) / determinant;
        s[j] -= step_j.clamp(-0.1, 0.1);
        s[k] -= step_k.clamp(-0.1, 0.1);
        if step_j.abs().max(step_k.abs()) < 1e-14 {
            break;
        }
    }
    s
}

/// The nominal stress along `axis` then, Pa.
pub(super) fn stress(material: &Material, axis: usize, stretch: f64) -> f64 {
    let s = stretches(material, axis, stretch);
    material.pk1_stress(DMat3::from_diagonal(s)).col(axis)[axis]
}

/// The same of incompressible tissue with fibres along `axis` alone, in closed form: sides are 1/√s, so that the ground
/// pulls with μ (s − 1/s²), and the fibres with s E (k + c a e^min(a E², Q_max)), E = (s² − 1)/2.
pub(super) fn incompressible_stress(m: &Orthotropic, axis: usize, stretch: f64) -> f64 {
    let (k, a) = (m.fibre_moduli[axis], m.saturation_rates[axis]);
    let mu = m.youngs_modulus / 3.0;
    let e = 0.5 * (stretch * stretch - 1.0);
    let exponent = (a * e * e).min(m.saturation_limit);
    mu * (stretch - 1.0 / (stretch * stretch))
        + stretch * e * (k + m.saturation * a * exponent.exp())
}
