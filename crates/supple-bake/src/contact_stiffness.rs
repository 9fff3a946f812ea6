//! How stiffly the skin is kept out of what it touches: a penalty that follows the tissue under it.

use supple::collider::Collider;
use supple::model::Avatar;

/// k L/E: tissue that is pressed to half its depth, E/2 if it were linear, gives way to 0.5 % of its depth.
const RATIO: f64 = 100.0;

/// k = 100 E/L of each skin vertex of `avatar`, Pa/m, the tissue under the first of which is `depth` (m) deep: E is Young's
/// modulus at rest, with the mean factor of the tets that carry the vertex. The stiffest that is taken where there is no bone to
/// measure from, or no tissue.
pub(crate) fn contact_stiffness(avatar: &Avatar, depth: &[f64]) -> Vec<f64> {
    let layer = &avatar.layer;
    // Factor times volume, and volume, around each node.
    let mut around = vec![(0.0_f64, 0.0_f64); layer.mesh.nodes.len()];
    for (t, tet) in layer.mesh.tets.iter().enumerate() {
        let volume = layer.mesh.volume(t);
        let stiffness = layer.tissue.get(t).map_or(1.0, |tissue| tissue.stiffness);
        for &node in tet {
            let (weighted, total) = &mut around[node as usize];
            *weighted += stiffness * volume;
            *total += volume;
        }
    }
    let of_vertex = |v: usize| {
        let depth = *depth.get(v)?;
        let row = layer.skin_embedding.row(v);
        let (weighted, total) = (row.iter()).fold((0.0, 0.0), |(weighted, total), &(n, share)| {
            let (w, t) = around[n as usize];
            (weighted + share * w, total + share * t)
        });
        let k = RATIO * avatar.material.youngs_modulus() * weighted / (total * depth);
        (k > 0.0 && k.is_finite()).then_some(k)
    };
    let limited = |v| of_vertex(v).map_or(Collider::STIFFEST, |k| k.min(Collider::STIFFEST));
    (0..avatar.skin.len()).map(limited).collect()
}
