//! Small thin spots of a layer, such as a nipple on its breast, are as deep as what lies around them.

use super::bone_axes::extent;
use glam::DVec3;
use std::cmp::{Ordering, Reverse};
use std::collections::BinaryHeap;
use supple::internal::math::Rows;
use supple::model::Surface;

/// Thin spots of up to twice this size are as deep as what lies around them; relative to the skin's extent.
const SPOT: f64 = 0.008;

/// Vertices within that reach at most, on the average: finer skins have their wrinkles, and would cost too much.
const DISC: f64 = 400.0;

/// A closing of the depth: the least over a disc of the greatest over a disc, which leaves what is thin over a
/// finger's length as it is. `around` are the neighbours of each vertex.
pub(super) fn close_thin_spots(skin: &Surface, around: &Rows<u32>, depth: &mut Vec<f64>) {
    *depth = closed(skin, around, SPOT * extent(skin), depth);
}

/// The closing of `values` by discs of radius `reach`, or smaller ones where those would hold too many vertices.
pub(crate) fn closed(skin: &Surface, around: &Rows<u32>, reach: f64, values: &[f64]) -> Vec<f64> {
    let area: f64 = skin.vertex_areas().iter().sum();
    let of_disc = (DISC * area / (std::f64::consts::PI * values.len() as f64)).sqrt();
    let reach = reach.min(of_disc);
    let places = &skin.positions;
    let greatest = first_within(places, around, reach, values, |a, b| b.total_cmp(&a));
    first_within(places, around, reach, &greatest, |a, b| a.total_cmp(&b))
}

/// For each vertex the value that comes first by `order` among those of vertices no farther than `reach` along edges.
///
/// Values spread in their order, each only to where it is nearer than all before it: what lies behind a vertex that an
/// earlier value reached on a shorter way has that value already.
fn first_within(
    places: &[DVec3],
    around: &Rows<u32>,
    reach: f64,
    values: &[f64],
    order: impl Fn(f64, f64) -> Ordering,
) -> Vec<f64> {
    let mut sources: Vec<u32> = (0..values.len() as u32).collect();
    sources.sort_by(|&a, &b| order(values[a as usize], values[b as usize]).then(a.cmp(&b)));
    let mut out = values.to_vec();
    let mut nearest = vec![f64::INFINITY; values.len()];
    let mut open = BinaryHeap::new();
    for source in sources {
        open.push(Reverse((Distance(0.0), source)));
        while let Some(Reverse((Distance(distance), v))) = open.pop() {
            let known = &mut nearest[v as usize];
            if distance >= *known {
                continue;
            }
            if *known == f64::INFINITY {
                out[v as usize] = values[source as usize];
            }
            *known = distance;
            for &u in around.row(v as usize) {
                let there = distance + places[u as usize].distance(places[v as usize]);
                if there <= reach && there < nearest[u as usize] {
                    open.push(Reverse((Distance(there), u)));
                }
            }
        }
    }
    out
}

/// Ordered by size.
#[derive(Clone, Copy, PartialEq)]
struct Distance(f64);

impl Eq for Distance {}

impl Ord for Distance {
    fn cmp(&self, other: &Self) -> Ordering {
        self.0.total_cmp(&other.0)
    }
}

impl PartialOrd for Distance {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::thickness::neighbours;
    use supple::internal::math::Random;

    /// A square of 30 by 30 vertices, 1 m a side, each a little off its place.
    fn square() -> Surface {
        let mut random = Random::new(8);
        let mut at = |i: usize| {
            let [x, y] = [i % 30, i / 30].map(|k| k as f64 + random.uniform(-0.3, 0.3));
            DVec3::new(x, y, 0.0) / 29.0
        };
        let triangles = (0..29 * 29).flat_map(|i| {
            let a = (i % 29 + 30 * (i / 29)) as u32;
            [[a, a + 1, a + 31], [a, a + 31, a + 30]]
        });
        Surface {
            positions: (0..900).map(&mut at).collect(),
            triangles: triangles.collect(),
        }
    }

    #[test]
    fn values_spread_as_far_as_the_reach_along_edges() {
        let skin = square();
        let around = neighbours(&skin);
        let mut random = Random::new(1);
        let values: Vec<f64> = (0..900).map(|_| random.uniform(0.0, 1.0).powi(3)).collect();
        let reach = 0.15;
        let found = first_within(&skin.positions, &around, reach, &values, |a, b| {
            b.total_cmp(&a)
        });
        for v in 0..900 {
            // By relaxation, as long as anything changes.
            let mut distance = vec![f64::INFINITY; 900];
            distance[v] = 0.0;
            let mut changed = true;
            while changed {
                changed = false;
                for u in 0..900 {
                    for &w in around.row(u) {
                        let step = skin.positions[u].distance(skin.positions[w as usize]);
                        if distance[u] + step < distance[w as usize] {
                            (distance[w as usize], changed) = (distance[u] + step, true);
                        }
                    }
                }
            }
            // The way there and back may round differently.
            let within = |most: f64| {
                let near = (0..900).filter(|&u| distance[u] <= most);
                near.map(|u| values[u]).fold(0.0, f64::max)
            };
            let bounds = within(reach * (1.0 - 1e-12))..=within(reach * (1.0 + 1e-12));
            assert!(bounds.contains(&found[v]), "{v}: {} {bounds:?}", found[v]);
        }
    }

    #[test]
    fn a_small_spot_is_filled_and_a_large_one_stays() {
        let skin = square();
        let around = neighbours(&skin);
        let middle = DVec3::new(0.5, 0.5, 0.0);
        let edge = 1.0 / 29.0;
        let dip = |radius: f64| -> Vec<f64> {
            let inside = |p: &DVec3| p.distance(middle) < radius;
            let depth = skin
                .positions
                .iter()
                .map(|p| if inside(p) { 0.1 } else { 1.0 });
            depth.collect()
        };
        assert!(
            closed(&skin, &around, 4.0 * edge, &dip(2.0 * edge))
                .iter()
                .all(|d| *d == 1.0)
        );
        let large = dip(8.0 * edge);
        let kept = closed(&skin, &around, 4.0 * edge, &large);
        assert!(kept.iter().zip(&large).filter(|(k, l)| k == l).count() > 850);
    }
}
