//! How far a layer sways at each of its nodes, and rows of a basis that keep it.
//!
//! A layer on a bone that is shaken sideways moves as a membrane over its depth does: p solves
//!
//! ```text
//! −Δp + p/ℓ² = 1,    p = 0 on bone,    ∂p/∂n = 0 on the skin
//! ```
//!
//! with ℓ far beyond any depth, so that what hangs on no bone has a profile too. Columns of a basis with their handles on
//! the skin have another profile between it and the bone, in a plane layer a straight line, and truncation cuts that off
//! above the bone. Both stiffen the sway. A row times
//!
//! ```text
//! s(X) = q(X) / Σ_h U_h(X) p(X_h),    q(X) = ½ p(X) + ½ Σ_h Ũ_h(X) p(X_h)
//! ```
//!
//! with U the truncated and Ũ the whole columns carries handles that move by p(X_h) d as q(X) d, at no cost to a step. In a
//! plane layer under its own weight q keeps 94 % of p's compliance (the straight line 75 %), and is half as much
//! steeper at the bone: a press follows the straight line, and p alone would turn its deepest tets first.

use crate::basis::{Constraints, gather};
use crate::body::LayerMesh;
use crate::cubature::Tissue;
use crate::math::{SparseFactor, SparseSymmetric};
use supple::Result;

/// ℓ relative to the cube root of the tissue's volume.
const FAR: f64 = 100.0;

/// s and 1/s at most: where a far handle's last value is all that is left of a row, it must not be blown up. 8 keeps no
/// more of a limb's sway, and is less even on a body of few handles.
const MOST: f64 = 4.0;

/// What rows of a layer's basis are to carry.
#[derive(Clone, Debug)]
pub(crate) struct SwayProfile {
    /// q at each node.
    at_nodes: Vec<f64>,
    /// p at each handle.
    at_handles: Vec<f64>,
}

impl SwayProfile {
    /// Of `layer` with handles that `constraints` place and their whole `columns`.
    ///
    /// # Errors
    /// [`supple::Error::Solve`] where the layer's Laplacian is not definite.
    pub fn new(layer: &LayerMesh, constraints: &Constraints, columns: &[Vec<f64>]) -> Result<Self> {
        let mut at_nodes = profile(layer)?;
        let at_handles = gather(constraints, &at_nodes);
        for (n, q) in at_nodes.iter_mut().enumerate() {
            let whole = columns.iter().zip(&at_handles).map(|(u, p)| u[n] * p);
            *q = 0.5 * (*q + whole.sum::<f64>());
        }
        Ok(Self {
            at_nodes,
            at_handles,
        })
    }

    /// s of a node with this truncated row of (handle, U).
    pub fn scale(&self, node: usize, row: &[(u32, f64)]) -> f64 {
        let carried = row.iter().map(|&(h, u)| u * self.at_handles[h as usize]);
        let (carried, wanted) = (carried.sum::<f64>(), self.at_nodes[node]);
        match carried > 0.0 && wanted > 0.0 {
            true => (wanted / carried).clamp(1.0 / MOST, MOST),
            false => 1.0,
        }
    }
}

/// p at each node of `layer`, scaled to a largest value of 1.
fn profile(layer: &LayerMesh) -> Result<Vec<f64>> {
    let mesh = &layer.mesh;
    let tissue = Tissue {
        mesh,
        fraction: &layer.tissue_fraction,
    };
    let volumes = tissue.tet_volumes();
    let far = FAR * volumes.iter().sum::<f64>().cbrt();
    let mut free = 0u32;
    let column = |bone: &Option<u32>| {
        bone.is_none().then(|| {
            free += 1;
            free - 1
        })
    };
    let columns: Vec<Option<u32>> = layer.bone_of_node.iter().map(column).collect();
    let mut entries = Vec::new();
    for (t, (tet, volume)) in mesh.tets.iter().zip(&volumes).enumerate() {
        let own = tet.map(|n| columns[n as usize]);
        let gradients = mesh.barycentric_gradients(t);
        for (row, a) in own.iter().zip(gradients) {
            for (column, b) in own.iter().zip(gradients) {
                if let (Some(r), Some(c)) = (*row, *column)
                    && r >= c
                {
                    entries.push((r, c, volume * a.dot(b)));
                }
            }
        }
    }
    let mut load = vec![0.0; free as usize];
    for (column, volume) in columns.iter().zip(tissue.nodal_volumes()) {
        if let Some(c) = column {
            entries.push((*c, *c, volume / (far * far)));
            load[*c as usize] = volume;
        }
    }
    let matrix = SparseSymmetric::from_entries(free as usize, &entries);
    let p = SparseFactor::new(&matrix, "sway of the layer")?.solve(&load);
    let most = p.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
    let at_node = |column: &Option<u32>| column.map_or(0.0, |c| p[c as usize] / most);
    Ok(columns.iter().map(at_node).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{HandleRegion, Limb, Recipe, RestSystem, Truncation, bake, full_compliance};
    use glam::DVec3;

    fn limb() -> LayerMesh {
        Limb::S.body().unwrap().layer
    }

    #[test]
    fn a_tube_sways_as_a_ring_between_a_bone_and_a_free_skin() {
        // −(r p')'/r = 1, p(a) = 0, p'(b) = 0: p = (a² − r²)/4 + b²/2 ln(r/a).
        let layer = limb();
        let p = profile(&layer).unwrap();
        let limb = Limb::S;
        let (a, b) = (limb.inner_radius, limb.outer_radius);
        let exact = |r: f64| 0.25 * (a * a - r * r) + 0.5 * b * b * (r / a).ln();
        let mut most = 0.0f64;
        for (x, p) in layer.mesh.nodes.iter().zip(&p) {
            most = most.max((p - exact(x.y.hypot(x.z)) / exact(b)).abs());
        }
        // Four layers of tets over a polygon.
        assert!(most < 0.03, "{most}");
    }

    #[test]
    fn rows_that_are_scaled_carry_the_sway() {
        let layer = limb();
        let skin: Vec<u32> = (0..layer.mesh.nodes.len() as u32).step_by(7).collect();
        let free: Vec<u32> = (skin.into_iter())
            .filter(|n| layer.bone_of_node[*n as usize].is_none())
            .collect();
        let constraints: Constraints = free.iter().map(|&n| [(n, 1.0)]).collect();
        let columns = vec![vec![0.5 / free.len() as f64; layer.mesh.nodes.len()]; free.len()];
        let sway = SwayProfile::new(&layer, &constraints, &columns).unwrap();
        let row: Vec<(u32, f64)> = vec![(0, 0.3), (1, 0.25), (2, 0.1)];
        let mut checked = 0;
        for (node, p) in sway.at_nodes.iter().enumerate() {
            let scale = sway.scale(node, &row);
            let carried: f64 = row
                .iter()
                .map(|&(h, u)| scale * u * sway.at_handles[h as usize])
                .sum();
            if scale > 1.0 / MOST && scale < MOST && *p > 0.0 {
                assert!((carried - p).abs() < 1e-12, "{carried} for {p}");
                checked += 1;
            }
        }
        assert!(checked > 500);
        assert_eq!(sway.scale(0, &[]), 1.0);
    }

    #[test]
    fn a_limb_sways_as_far_as_its_full_space() {
        let body = Limb::S.body().unwrap();
        let share = |keep_sway| {
            let recipe = Recipe {
                handles: vec![HandleRegion {
                    count: Some(82),
                    ..HandleRegion::default()
                }],
                truncation: Truncation {
                    keep_sway,
                    ..Truncation::default()
                },
                ..Recipe::default()
            };
            let avatar = bake(&body, &recipe, &mut |_| {}).unwrap().0;
            let full: f64 = full_compliance(&avatar).unwrap().iter().sum();
            let system = RestSystem::of(&avatar);
            let reduced = [DVec3::X, DVec3::Y, DVec3::Z].map(|d| system.compliance(d).unwrap());
            reduced.iter().sum::<f64>() / full
        };
        let (kept, cut, default) = (share(Some(true)), share(Some(false)), share(None));
        println!("{kept} of the full space, {cut} without");
        assert_eq!(kept, default);
        assert!((0.8..1.0).contains(&kept) && cut < 0.5);
    }
}
