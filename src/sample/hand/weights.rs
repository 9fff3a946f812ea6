//! Skin weights: each vertex starts with the bone of its own digit's segment, and two implicit steps
//! of heat flow along the surface blend them. Heat stays on the surface, so a neighbour finger gets
//! none however near it is.

use super::anatomy::Digit;
use super::shape::HandShape;
use crate::math::{Rows, par_map};
use crate::model::{SkinWeight, Surface};
use glam::DVec3;

/// Bones a vertex may have.
const MOST: usize = 4;
/// Weights below the first are dropped, above the second kept; smooth in between.
const CUTOFF: [f64; 2] = [0.02, 0.08];

/// Where a point lies: digit (if any), bone, and the radius of the blend there (mm).
fn segment(shape: &HandShape, stations: &[[f64; 4]], p: DVec3) -> (usize, f64) {
    let (digit, distance) = shape.nearest_digit(p);
    let sweep = &shape.digits[digit];
    let s = sweep.axes.local(p).x;
    let joints = &stations[digit];
    // The palm belongs to the wrist; the thumb's metacarpal lies in it and takes what is near.
    let own = s > joints[0] && (digit < 4 || distance < shape.palm(p) + 5.0);
    if !own {
        return (0, if digit == 4 { 6.0 } else { 4.5 });
    }
    let k = joints[..3].iter().filter(|&&j| s > j).count() - 1;
    // Wide at the root of the digit, narrow at its far joints.
    let reach = ((s - joints[0]) / (joints[1] - joints[0])).clamp(0.0, 1.0);
    let wide = if digit == 4 { 6.0 } else { 4.5 };
    (1 + 3 * digit + k, wide + (2.6 - wide) * reach)
}

/// The symmetric cotangent operator ∫∇u·∇v with a coefficient, and lumped areas.
struct Diffusion {
    edges: Rows<(u32, f64)>,
    mass: Vec<f64>,
}

impl Diffusion {
    fn new(skin: &Surface, radius: &[f64]) -> Self {
        let mut rows = vec![std::collections::BTreeMap::<u32, f64>::new(); skin.positions.len()];
        for t in &skin.triangles {
            for k in 0..3 {
                let [a, b, c] = [t[k], t[(k + 1) % 3], t[(k + 2) % 3]];
                let [u, v] =
                    [a, b].map(|i| skin.positions[i as usize] - skin.positions[c as usize]);
                // Clamped, so that weights stay between 0 and 1 (maximum principle).
                let cotangent = (u.dot(v) / u.cross(v).length()).clamp(0.05, 5.0);
                let r = 0.5 * (radius[a as usize] + radius[b as usize]);
                *rows[a as usize].entry(b).or_default() += 0.5 * cotangent * r * r;
                *rows[b as usize].entry(a).or_default() += 0.5 * cotangent * r * r;
            }
        }
        Self {
            edges: rows.into_iter().collect(),
            mass: skin.vertex_areas(),
        }
    }

    /// (M + L) x.
    fn apply(&self, x: &[f64]) -> Vec<f64> {
        let row = |(i, edges): (usize, &[(u32, f64)])| {
            self.mass[i] * x[i]
                + edges
                    .iter()
                    .map(|&(j, c)| c * (x[i] - x[j as usize]))
                    .sum::<f64>()
        };
        self.edges.iter().enumerate().map(row).collect()
    }

    /// Solves (M + L) x = M u by conjugate gradients: one implicit step of heat flow.
    fn step(&self, u: &[f64]) -> Vec<f64> {
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
        let diagonal: Vec<f64> = self
            .edges
            .iter()
            .zip(&self.mass)
            .map(|(e, m)| m + e.iter().map(|e| e.1).sum::<f64>())
            .collect();
        let mut x = u.to_vec();
        let mut r: Vec<f64> = self
            .apply(&x)
            .iter()
            .zip(u.iter().zip(&self.mass))
            .map(|(a, (u, m))| m * u - a)
            .collect();
        let precondition =
            |r: &[f64]| -> Vec<f64> { r.iter().zip(&diagonal).map(|(r, d)| r / d).collect() };
        let mut z = precondition(&r);
        let mut p = z.clone();
        let mut rz = dot(&r, &z);
        let start = rz;
        for _ in 0..400 {
            if rz <= 1e-24 * start || rz == 0.0 {
                break;
            }
            let q = self.apply(&p);
            let alpha = rz / dot(&p, &q);
            for i in 0..x.len() {
                x[i] += alpha * p[i];
                r[i] -= alpha * q[i];
            }
            z = precondition(&r);
            let next = dot(&r, &z);
            for i in 0..p.len() {
                p[i] = z[i] + next / rz * p[i];
            }
            rz = next;
        }
        x
    }
}

fn smoothstep(t: f64) -> f64 {
    let t = t.clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// At most four bones for each vertex, with Σ w = 1.
pub(super) fn weights(shape: &HandShape, digits: &[Digit; 5], skin: &Surface) -> Rows<SkinWeight> {
    let stations: Vec<[f64; 4]> = digits
        .iter()
        .map(|d| d.local_joints().map(|j| j.x))
        .collect();
    let (bone, radius): (Vec<usize>, Vec<f64>) = skin
        .positions
        .iter()
        .map(|&p| segment(shape, &stations, p))
        .unzip();
    let diffusion = Diffusion::new(skin, &radius);
    let columns: Vec<Vec<f64>> = par_map(16, |j| {
        let start: Vec<f64> = bone.iter().map(|&b| f64::from(u8::from(b == j))).collect();
        diffusion.step(&diffusion.step(&start))
    });
    (0..skin.positions.len())
        .map(|v| {
            let mut row: Vec<(u32, f64)> = columns
                .iter()
                .enumerate()
                .map(|(j, c)| (j as u32, c[v]))
                .map(|(j, w)| (j, w * smoothstep((w - CUTOFF[0]) / (CUTOFF[1] - CUTOFF[0]))))
                .filter(|&(_, w)| w > 0.0)
                .collect();
            row.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
            row.truncate(MOST);
            let sum: f64 = row.iter().map(|r| r.1).sum();
            row.sort_by_key(|r| r.0);
            row.into_iter()
                .map(|(bone, w)| SkinWeight {
                    bone,
                    weight: w / sum,
                })
                .collect::<Vec<_>>()
        })
        .collect()
}
