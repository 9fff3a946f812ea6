//! The soft palmar side of the skin.

use super::anatomy::Digit;
use glam::DVec3;
use supple::internal::math::Rows;
use supple::model::{SkinWeight, Surface};

/// Whether each vertex faces palmarly (seen from its own bones) and lies distal of the wrist's crease.
pub(super) fn palmar(digits: &[Digit; 5], skin: &Surface, weights: &Rows<SkinWeight>) -> Vec<bool> {
    let dorsal = |bone: u32| match bone {
        0 => DVec3::Z,
        _ => digits[(bone as usize - 1) / 3].dorsal.normalize(),
    };
    let facing = |(normal, row): (&DVec3, &[SkinWeight])| -> f64 {
        let up: DVec3 = row.iter().map(|w| w.weight * dorsal(w.bone)).sum();
        -normal.dot(up.normalize_or_zero())
    };
    skin.vertex_normals()
        .iter()
        .zip(weights.iter())
        .zip(&skin.positions)
        .map(|(pair, p)| facing(pair) > 0.35 && p.x > 6.0)
        .collect()
}
