//! Triangles to samples.

use super::camera::Lens;
use super::mesh::{Mesh, Plane};

/// What a sample of the picture sees.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sample {
    pub mesh: u32,
    /// Triangle, or [`CUT`].
    pub triangle: u32,
    /// Barycentric coordinates of the triangle's second and third corner.
    pub u: f32,
    pub v: f32,
    /// See [`Lens::project`]; −∞ where there is nothing.
    pub nearness: f64,
}

/// In place of a triangle: the sample lies on the clipping plane, inside the mesh.
pub(super) const CUT: u32 = u32::MAX;

impl Sample {
    pub const NOTHING: Self = Self {
        mesh: 0,
        triangle: 0,
        u: 0.0,
        v: 0.0,
        nearness: f64::NEG_INFINITY,
    };
}

/// The nearest surface at every sample of rows `rows` of a picture `width` wide.
pub(super) fn rasterise(
    meshes: &[Mesh],
    lens: &Lens,
    clip: Option<&Plane>,
    width: usize,
    rows: std::ops::Range<usize>,
) -> Vec<Sample> {
    let mut samples = vec![Sample::NOTHING; width * rows.len()];
    let mut winding = Vec::new();
    for (index, mesh) in meshes.iter().enumerate() {
        let clip = clip.filter(|_| mesh.cut.is_some());
        winding.clear();
        if clip.is_some() {
            winding.resize(samples.len(), 0i32);
        }
        let projected: Vec<_> = mesh
            .surface
            .positions
            .iter()
            .map(|p| lens.project(*p))
            .collect();
        for (t, corners) in mesh.surface.triangles.iter().enumerate() {
            let [Some(a), Some(b), Some(c)] = corners.map(|v| projected[v as usize]) else {
                continue;
            };
            let sides = clip
                .map(|plane| corners.map(|v| plane.distance(mesh.surface.positions[v as usize])));
            if sides.is_some_and(|s| s.iter().all(|d| *d > 0.0)) {
                continue;
            }
            // y points down, so that outward faces have a negative area.
            let area = (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]);
            for_each_pixel([a, b, c], area, width, &rows, |at, weights| {
                let w: [f64; 3] =
                    std::array::from_fn(|k| weights[k] * lens.attribute_weight([a, b, c][k][2]));
                let sum = w[0] + w[1] + w[2];
                if let Some(s) = sides {
                    if (w[0] * s[0] + w[1] * s[1] + w[2] * s[2]) / sum > 0.0 {
                        return;
                    }
                    winding[at] += if area > 0.0 { 1 } else { -1 };
                }
                let nearness = weights[0] * a[2] + weights[1] * b[2] + weights[2] * c[2];
                if nearness > samples[at].nearness {
                    samples[at] = Sample {
                        mesh: index as u32,
                        triangle: t as u32,
                        u: (w[1] / sum) as f32,
                        v: (w[2] / sum) as f32,
                        nearness,
                    };
                }
            });
        }
        if let Some(plane) = clip {
            fill_cut(
                &mut samples,
                &winding,
                lens,
                plane,
                index,
                width,
                rows.start,
            );
        }
    }
    samples
}

/// Where a ray leaves the mesh behind the plane more often than it enters, the plane cuts its inside.
fn fill_cut(
    samples: &mut [Sample],
    winding: &[i32],
    lens: &Lens,
    plane: &Plane,
    mesh: usize,
    width: usize,
    first_row: usize,
) {
    for (at, sample) in samples.iter_mut().enumerate() {
        if winding[at] <= 0 {
            continue;
        }
        let (x, y) = (at % width, first_row + at / width);
        let (origin, direction) = lens.ray(x as f64 + 0.5, y as f64 + 0.5);
        let approach = direction.dot(plane.normal.normalize_or(glam::DVec3::Z));
        let point = origin - direction * (plane.distance(origin) / approach);
        let Some([_, _, nearness]) = lens.project(point) else {
            continue;
        };
        // A later mesh that is cut at the same place lies inside the earlier one, as bones do.
        let over = sample.triangle == CUT || nearness > sample.nearness;
        if over && nearness.is_finite() {
            *sample = Sample {
                mesh: mesh as u32,
                triangle: CUT,
                u: 0.0,
                v: 0.0,
                nearness,
            };
        }
    }
}

/// Calls `visit(sample, barycentric weights)` for every sample centre inside a projected triangle.
pub(super) fn for_each_pixel(
    [a, b, c]: [[f64; 3]; 3],
    area: f64,
    width: usize,
    rows: &std::ops::Range<usize>,
    mut visit: impl FnMut(usize, [f64; 3]),
) {
    if area == 0.0 || !area.is_finite() {
        return;
    }
    let (left, right) = (a[0].min(b[0]).min(c[0]), a[0].max(b[0]).max(c[0]));
    let (top, bottom) = (a[1].min(b[1]).min(c[1]), a[1].max(b[1]).max(c[1]));
    let column = |x: f64| x.clamp(0.0, width as f64) as usize;
    let row = |y: f64| y.clamp(rows.start as f64, rows.end as f64) as usize;
    for y in row((top - 0.5).ceil())..row((bottom + 0.5).ceil()) {
        let py = y as f64 + 0.5;
        for x in column((left - 0.5).ceil())..column((right + 0.5).ceil()) {
            let px = x as f64 + 0.5;
            let edge = |p: [f64; 3], q: [f64; 3]| {
                ((q[0] - p[0]) * (py - p[1]) - (px - p[0]) * (q[1] - p[1])) / area
            };
            let weights = [edge(b, c), edge(c, a), edge(a, b)];
            if weights.iter().all(|w| *w >= 0.0) {
                visit((y - rows.start) * width + x, weights);
            }
        }
    }
}
