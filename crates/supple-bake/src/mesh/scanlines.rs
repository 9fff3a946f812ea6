//! Which samples of a regular grid a closed surface holds, by winding numbers along lines.
//!
//! Along a line the winding number changes by one at each crossing, up or down with the side that
//! the triangle turns to it. A solid is where it is positive: parts of a skin that cut each other
//! are one solid, where parity would leave a hole.

use glam::DVec3;
use supple::internal::math::{Rows, par_map};
use supple::model::Surface;

/// Samples at `origin + spacing · (i, j, k)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Grid {
    /// Place of sample (0, 0, 0), m.
    pub origin: DVec3,
    /// Distance of neighbours, m.
    pub spacing: f64,
    /// Samples along x, y, z.
    pub counts: [usize; 3],
}

/// Where a line meets a triangle.
#[derive(Clone, Copy)]
struct Crossing {
    line: u32,
    /// In samples along the line.
    at: f64,
    /// +1 on the way in, −1 on the way out.
    step: i32,
}

impl Grid {
    /// The runs `first..=last` of samples inside `surface` on each line along `axis`. A run never
    /// spans a place outside, however thin. With b and c the axes that follow, the line at
    /// (b, c) has the number b + counts\[b\] c.
    pub fn inside_runs(&self, surface: &Surface, axis: usize) -> Rows<(u32, u32)> {
        let (b, c) = ((axis + 1) % 3, (axis + 2) % 3);
        let lines = self.counts[b] * self.counts[c];
        let mut crossings: Vec<Crossing> = par_map(surface.triangles.len(), |t| {
            self.crossings(surface, t, axis)
        })
        .into_iter()
        .flatten()
        .collect();
        // Inward first where two crossings meet, so that touching parts stay one run.
        crossings.sort_unstable_by(|x, y| {
            (x.line.cmp(&y.line))
                .then(x.at.total_cmp(&y.at))
                .then(y.step.cmp(&x.step))
        });
        let mut next = 0;
        (0..lines as u32)
            .map(|line| {
                let mut runs = Vec::new();
                let (mut winding, mut entered) = (0, 0.0);
                while let Some(crossing) = crossings.get(next).filter(|c| c.line == line) {
                    next += 1;
                    let before = winding;
                    winding += crossing.step;
                    if before <= 0 && winding > 0 {
                        entered = crossing.at;
                    } else if before > 0 && winding <= 0 {
                        let first = entered.ceil().max(0.0);
                        let last = crossing.at.floor().min(self.counts[axis] as f64 - 1.0);
                        if first <= last {
                            runs.push((first as u32, last as u32));
                        }
                    }
                }
                runs
            })
            .collect()
    }

    fn crossings(&self, surface: &Surface, t: usize, axis: usize) -> Vec<Crossing> {
        let (b, c) = ((axis + 1) % 3, (axis + 2) % 3);
        let triangle = surface.triangles[t];
        let corners = surface
            .corners(t)
            .map(|p| ((p - self.origin) / self.spacing).to_array());
        let range = |a: usize| {
            let coordinate = corners.map(|p| p[a]);
            let low = coordinate.iter().copied().fold(f64::INFINITY, f64::min);
            let high = coordinate.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            (low, high)
        };
        let lines = |a: usize| {
            let (low, high) = range(a);
            let end = (high.floor() + 1.0).clamp(0.0, self.counts[a] as f64) as usize;
            (low.ceil().max(0.0) as usize).min(end)..end
        };
        let edge = |i: usize, j: usize| {
            let d: [f64; 3] = std::array::from_fn(|a| corners[j][a] - corners[i][a]);
            d
        };
        let (u, v) = (edge(0, 1), edge(0, 2));
        let normal = [
            u[1] * v[2] - u[2] * v[1],
            u[2] * v[0] - u[0] * v[2],
            u[0] * v[1] - u[1] * v[0],
        ];
        // Whether the point lies left of edge i → j. The sum runs from the smaller vertex to the
        // larger, so that both triangles of an edge get the same bits and one of them the point.
        let left = |i: usize, j: usize, point: [f64; 2]| {
            let flip = triangle[i] > triangle[j];
            let (from, to) = if flip {
                (corners[j], corners[i])
            } else {
                (corners[i], corners[j])
            };
            let side =
                (to[b] - from[b]) * (point[1] - from[c]) - (to[c] - from[c]) * (point[0] - from[b]);
            (side >= 0.0) != flip
        };
        let (low, high) = range(axis);
        let mut found = Vec::new();
        for line_c in lines(c) {
            for line_b in lines(b) {
                let point = [line_b as f64, line_c as f64];
                let sides = [left(0, 1, point), left(1, 2, point), left(2, 0, point)];
                // Counter-clockwise means that the normal looks along the axis: the way out.
                let step = match sides {
                    [true, true, true] => -1,
                    [false, false, false] => 1,
                    _ => continue,
                };
                let rise =
                    normal[b] * (point[0] - corners[0][b]) + normal[c] * (point[1] - corners[0][c]);
                let at = (corners[0][axis] - rise / normal[axis]).clamp(low, high);
                found.push(Crossing {
                    line: (line_b + self.counts[b] * line_c) as u32,
                    at: if at.is_nan() { low } else { at },
                    step,
                });
            }
        }
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A box as twelve triangles.
    fn cuboid(low: DVec3, high: DVec3) -> Surface {
        let corner = |c: usize| {
            DVec3::new(
                if c & 1 > 0 { high.x } else { low.x },
                if c & 2 > 0 { high.y } else { low.y },
                if c & 4 > 0 { high.z } else { low.z },
            )
        };
        let quads = [
            [0, 2, 3, 1],
            [4, 5, 7, 6],
            [0, 1, 5, 4],
            [2, 6, 7, 3],
            [0, 4, 6, 2],
            [1, 3, 7, 5],
        ];
        Surface {
            positions: (0..8).map(corner).collect(),
            triangles: (quads.iter())
                .flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]])
                .collect(),
        }
    }

    fn joined(parts: [Surface; 2]) -> Surface {
        let [mut a, b] = parts;
        let shift = a.positions.len() as u32;
        a.positions.extend(b.positions);
        a.triangles
            .extend(b.triangles.iter().map(|t| t.map(|v| v + shift)));
        a
    }

    fn count(runs: &Rows<(u32, u32)>) -> usize {
        runs.entries()
            .iter()
            .map(|r| (r.1 - r.0 + 1) as usize)
            .sum()
    }

    #[test]
    fn boxes_that_cut_each_other_are_one_solid_and_thin_gaps_split_runs() {
        let grid = Grid {
            origin: DVec3::ZERO,
            spacing: 1.0,
            counts: [12, 10, 11],
        };
        // Samples on edges and corners of the triangles too.
        let one = cuboid(DVec3::new(1.0, 2.0, 2.0), DVec3::new(5.5, 6.0, 5.0));
        assert!(one.is_closed() && one.volume() > 0.0);
        let two = cuboid(DVec3::new(3.5, 2.0, 2.0), DVec3::new(8.5, 6.0, 5.0));
        let apart = cuboid(DVec3::new(5.6, 2.0, 2.0), DVec3::new(8.5, 6.0, 5.0));
        for axis in 0..3 {
            // Half-open: a face through samples counts on one side only.
            let alone = count(&grid.inside_runs(&one, axis));
            assert!((5 * 4 * 3..=5 * 5 * 4).contains(&alone), "{alone}");
            let merged = grid.inside_runs(&joined([one.clone(), two.clone()]), axis);
            assert!((8 * 4 * 3..=8 * 5 * 4).contains(&count(&merged)));
        }
        let runs = |surface: &Surface| grid.inside_runs(surface, 0).entries().to_vec();
        assert!(
            runs(&joined([one.clone(), two]))
                .iter()
                .all(|&r| r == (1, 8))
        );
        let split = runs(&joined([one, apart]));
        assert!(split.contains(&(1, 5)) && split.contains(&(6, 8)));
    }
}
