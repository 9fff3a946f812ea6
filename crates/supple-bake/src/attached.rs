//! What hangs on the skin: vertices that are drawn with it and follow its tissue.
//!
//! An attached vertex keeps its own skin weights. Its basis is that of the nearest point of the skin (among
//! the triangles around the nearest skin vertex), in full up to a distance of 2 % of the body's largest
//! extent, fading to nothing at 6 %: lashes and sleeves move with the tissue, the hem of a coat less.
//! Its area is 0: it touches nothing.

use super::AttachmentReport;
use crate::basis::rows_through;
use crate::body::{Attachment, Body};
use crate::math::NearestPoint;
use glam::DVec3;
use supple::internal::math::{Rows, par_map};
use supple::model::{PointSet, PoseBlend, SkinWeight, Surface};

/// Distances relative to the largest extent of the skin: up to the first all, from the second on nothing.
const FADE: [f64; 2] = [0.02, 0.06];

impl AttachmentReport {
    /// Of the attachments of `body`, whose vertices follow the skin vertices of `attached`.
    pub(crate) fn of(body: &Body, attached: &Rows<(u32, f64)>) -> Vec<Self> {
        let mut first = 0;
        let mut report = |a: &Attachment| {
            let vertices = a.surface.positions.len();
            let rows = (first..first + vertices).map(|v| attached.row(v));
            first += vertices;
            Self {
                name: a.name.clone(),
                vertices,
                follows_tissue: a.follows_tissue,
                following: rows.filter(|row| !row.is_empty()).count(),
            }
        };
        body.attachments.iter().map(&mut report).collect()
    }
}

/// Skin vertices (index, share) that each attached vertex follows, attachment after attachment. The
/// shares sum to 1 at the skin and to less away from it.
pub(crate) fn followed(body: &Body) -> Rows<(u32, f64)> {
    let skin = &body.skin;
    let nearest = NearestPoint::new(&skin.positions);
    let (low, high) = skin.bounds();
    let fade = FADE.map(|share| share * (high - low).max_element());
    let around = skin.triangles_around();
    // A point of a triangle is no farther from one of its corners than its longest edge.
    let reach = fade[1] + longest_edge(skin);
    let mut rows = Rows::default();
    for attachment in &body.attachments {
        let positions = &attachment.surface.positions;
        if !attachment.follows_tissue {
            positions.iter().for_each(|_| rows.push([]));
            continue;
        }
        let found = par_map(positions.len(), |v| {
            let Some((near, _)) = nearest.nearest_within(positions[v], reach) else {
                return Vec::new();
            };
            let triangles = around.row(near as usize);
            nearest_shares(skin, near, triangles, positions[v], fade)
        });
        found.into_iter().for_each(|row| rows.push(row));
    }
    rows
}

/// m; 0 where there is no triangle.
fn longest_edge(skin: &Surface) -> f64 {
    let edges = (0..skin.triangles.len()).flat_map(|t| {
        let [a, b, c] = skin.corners(t);
        [a.distance(b), b.distance(c), c.distance(a)]
    });
    edges.fold(0.0, f64::max)
}

/// The skin's points and triangles with the attachments' after them.
pub(crate) fn with_attachments(
    body: &Body,
    skin: PointSet,
    attached: &Rows<(u32, f64)>,
) -> (PointSet, Vec<[u32; 3]>) {
    let mut triangles = body.skin.triangles.clone();
    if body.attachments.is_empty() {
        return (skin, triangles);
    }
    let blend = |features: usize| {
        let mut columns = Vec::new();
        for k in 0..features {
            let of_skin = skin.len();
            columns.extend_from_slice(&skin.pose_blend.columns[k * of_skin..][..of_skin]);
            for a in &body.attachments {
                let own = a.surface.positions.len();
                match a.pose_blend.columns.get(k * own..(k + 1) * own) {
                    Some(column) => columns.extend_from_slice(column),
                    None => columns.extend(std::iter::repeat_n([0.0; 3], own)),
                }
            }
        }
        PoseBlend { features, columns }
    };
    let pose_blend = blend(skin.pose_blend.features);
    let mut out = PointSet { pose_blend, ..skin };
    let basis = rows_through(attached, &out.basis);
    for a in &body.attachments {
        let first = out.len() as u32;
        out.position.extend(&a.surface.positions);
        out.measure.resize(out.position.len(), 0.0);
        let rows = a.skinning.iter();
        rows.for_each(|row: &[SkinWeight]| out.skinning.push(row.iter().copied()));
        let shifted = a.surface.triangles.iter().map(|t| t.map(|v| v + first));
        triangles.extend(shifted);
    }
    basis
        .iter()
        .for_each(|row| out.basis.push(row.iter().copied()));
    (out, triangles)
}

/// Barycentric coordinates of the point of `triangles` that is nearest to `p`, faded with its distance.
fn nearest_shares(
    skin: &Surface,
    vertex: u32,
    triangles: &[u32],
    p: DVec3,
    fade: [f64; 2],
) -> Vec<(u32, f64)> {
    let mut best = (
        p.distance(skin.positions[vertex as usize]),
        vec![(vertex, 1.0)],
    );
    for &t in triangles {
        let shares = nearest_in_triangle(skin.corners(t as usize), p);
        let corners = skin.triangles[t as usize].into_iter().zip(shares);
        let place = |(v, share): (u32, f64)| share * skin.positions[v as usize];
        let distance = p.distance(corners.clone().map(place).sum());
        if distance < best.0 {
            best = (
                distance,
                corners.filter(|(_, share)| *share > 0.0).collect(),
            );
        }
    }
    let u = ((fade[1] - best.0) / (fade[1] - fade[0]).max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
    let part = u * u * (3.0 - 2.0 * u);
    let shares = best.1.into_iter().map(|(v, share)| (v, part * share));
    shares.filter(|(_, share)| *share > 0.0).collect()
}

/// Barycentric coordinates of the point of a triangle nearest to `p`: by its Voronoi regions (Ericson,
/// Real-Time Collision Detection, 2005, §5.1.5).
fn nearest_in_triangle([a, b, c]: [DVec3; 3], p: DVec3) -> [f64; 3] {
    let (ab, ac) = (b - a, c - a);
    let [d1, d2] = [ab, ac].map(|e| e.dot(p - a));
    let [d3, d4] = [ab, ac].map(|e| e.dot(p - b));
    let [d5, d6] = [ab, ac].map(|e| e.dot(p - c));
    let (va, vb, vc) = (d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2);
    if d1 <= 0.0 && d2 <= 0.0 {
        [1.0, 0.0, 0.0]
    } else if d3 >= 0.0 && d4 <= d3 {
        [0.0, 1.0, 0.0]
    } else if d6 >= 0.0 && d5 <= d6 {
        [0.0, 0.0, 1.0]
    } else if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        let v = d1 / (d1 - d3);
        [1.0 - v, v, 0.0]
    } else if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        let w = d2 / (d2 - d6);
        [1.0 - w, 0.0, w]
    } else if va <= 0.0 && d4 >= d3 && d5 >= d6 {
        let w = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        [0.0, 1.0 - w, w]
    } else {
        let sum = va + vb + vc;
        [va / sum, vb / sum, vc / sum]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Limb;
    use supple::internal::math::Random;

    #[test]
    fn what_is_followed_is_that_of_a_full_search_near_and_far() {
        let mut body = Limb::S.body().unwrap();
        let mut random = Random::new(7);
        let (low, high) = body.skin.bounds();
        let size = (high - low).max_element();
        let positions: Vec<DVec3> = (0..600)
            .map(|i| (if i < 500 { 0.3 } else { 40.0 }) * size * random.vector(1.0))
            .collect();
        let whole = SkinWeight {
            bone: 0,
            weight: 1.0,
        };
        let attachment = |follows_tissue| Attachment {
            skinning: positions.iter().map(|_| [whole]).collect(),
            surface: Surface {
                positions: positions.clone(),
                triangles: Vec::new(),
            },
            follows_tissue,
            ..Attachment::default()
        };
        body.attachments = vec![attachment(true), attachment(false)];
        let found = followed(&body);
        let around = body.skin.triangles_around();
        let nearest = NearestPoint::new(&body.skin.positions);
        let mut following = 0;
        for (v, &p) in positions.iter().enumerate() {
            let (near, _) = nearest.nearest(p).unwrap();
            let triangles = around.row(near as usize);
            let fade = FADE.map(|share| share * size);
            assert_eq!(
                found.row(v),
                nearest_shares(&body.skin, near, triangles, p, fade)
            );
            following += usize::from(!found.row(v).is_empty());
            assert!(found.row(positions.len() + v).is_empty());
        }
        assert!((30..500).contains(&following), "{following}");
    }

    #[test]
    fn no_point_of_the_triangle_is_nearer() {
        let mut random = Random::new(31);
        for _ in 0..300 {
            let corners = [0; 3].map(|_| random.vector(1.0));
            let p = random.vector(2.0);
            let at = |[x, y, z]: [f64; 3]| x * corners[0] + y * corners[1] + z * corners[2];
            let found = nearest_in_triangle(corners, p);
            assert!(found.iter().all(|s| *s >= -1e-12));
            assert!((found.iter().sum::<f64>() - 1.0).abs() < 1e-12);
            let distance = p.distance(at(found));
            for i in 0..=20 {
                for j in 0..=20 - i {
                    let [x, y] = [i, j].map(|k| f64::from(k) / 20.0);
                    assert!(distance <= p.distance(at([x, y, 1.0 - x - y])) + 1e-12);
                }
            }
        }
    }
}
