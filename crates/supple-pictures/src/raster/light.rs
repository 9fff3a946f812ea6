//! A studio: a dome of lamps, each with a shadow map, so that ambient occlusion, soft shadows and the
//! key light are one sum.

use super::camera::{Camera, Lens, Projection};
use super::depth::for_each_pixel;
use super::mesh::{Mesh, Plane};
use glam::{DMat3, DVec3};
use supple::internal::math::par_map;

/// Samples of a pixel that share the lamps among them.
const INTERLEAVE: usize = 4;
/// Samples along a side of a shadow map.
const RESOLUTION: usize = 768;

/// A lamp infinitely far away.
struct Lamp {
    /// Towards it.
    direction: DVec3,
    /// Its share of the light that a surface facing it would get.
    strength: f64,
    lens: Lens,
    /// [`Lens::project`]'s third value of the nearest surface.
    nearest: Vec<f32>,
}

/// The lamps of a scene.
pub(super) struct Dome {
    lamps: Vec<Lamp>,
    /// World size of a shadow map's sample, m.
    texel: f64,
    /// Where the key light comes from.
    pub key: DVec3,
}

impl Dome {
    /// Lights `meshes` (all of them inside a ball about `centre`) by so many lamps for a camera with the given axes.
    pub fn new(
        count: usize,
        meshes: &[Mesh],
        clip: Option<&Plane>,
        centre: DVec3,
        radius: f64,
        camera: DMat3,
        up: DVec3,
    ) -> Self {
        // Photographers' places: the key light above the camera and to its left, the fill light to its
        // right and lower.
        let (right, above, back) = (camera.x_axis, camera.y_axis, camera.z_axis);
        let key = (0.9 * above - 0.8 * right + 0.7 * back).normalize_or(up);
        let fill = (back + 0.9 * right - 0.2 * above).normalize_or(up);
        let basis = {
            let x = up.any_orthonormal_vector();
            DMat3::from_cols(x, up.cross(x), up)
        };
        let golden = std::f64::consts::PI * (3.0 - 5f64.sqrt());
        let lamps = par_map(count, |i| {
            // Fibonacci points on the whole sphere: a light floor shines back.
            let z = 1.0 - (i as f64 + 0.5) * 2.0 / count as f64;
            let (sin, cos) = (golden * i as f64).sin_cos();
            let r = (1.0 - z * z).max(0.0).sqrt();
            let direction = basis * DVec3::new(r * cos, r * sin, z);
            let lobe =
                |towards: DVec3, sharpness: f64| (sharpness * (direction.dot(towards) - 1.0)).exp();
            let strength = 0.26 + 0.14 * z + 4.4 * lobe(key, 14.0) + 0.5 * lobe(fill, 4.0);
            let lens = Lens::new(
                &Camera {
                    eye: centre + direction * (2.0 * radius),
                    target: centre,
                    up: direction.any_orthonormal_vector(),
                    projection: Projection::Orthographic(2.0 * radius),
                },
                RESOLUTION,
                RESOLUTION,
            );
            let nearest = shadow_map(meshes, &lens, clip);
            Lamp {
                direction,
                strength: strength.max(0.0),
                lens,
                nearest,
            }
        });
        let mut dome = Self {
            lamps,
            texel: 2.0 * radius / RESOLUTION as f64,
            key,
        };
        // A surface in the open that faces the key light gets 1.
        let open: f64 = dome
            .lamps
            .iter()
            .map(|l| l.strength * l.direction.dot(key).max(0.0))
            .sum();
        dome.lamps.iter_mut().for_each(|l| l.strength /= open);
        dome
    }

    /// Light that reaches a surface at `point` with unit `normal`, and what would in the open.
    ///
    /// Only every [`INTERLEAVE`]th lamp counts, from number `sample` on: the samples of a pixel take
    /// turns, and their mean is that of all lamps.
    pub fn irradiance(&self, point: DVec3, normal: DVec3, sample: usize) -> (f64, f64) {
        let lifted = point + normal * (1.5 * self.texel);
        let (mut reached, mut open) = (0.0, 0.0);
        for lamp in self
            .lamps
            .iter()
            .skip(sample % INTERLEAVE)
            .step_by(INTERLEAVE)
        {
            let cosine = normal.dot(lamp.direction);
            if cosine > 0.0 {
                let light = INTERLEAVE as f64 * lamp.strength * cosine;
                open += light;
                reached += light * lamp.visible(lifted, self.texel);
            }
        }
        (reached, open)
    }
}

impl Lamp {
    /// 0 in shadow, 1 in light, in between at the four nearest samples' edges.
    fn visible(&self, point: DVec3, bias: f64) -> f64 {
        let Some([x, y, nearness]) = self.lens.project(point) else {
            return 1.0;
        };
        let (x, y) = (x - 0.5, y - 0.5);
        let (left, top) = (x.floor(), y.floor());
        let limit = (RESOLUTION - 1) as f64;
        if !(left >= 0.0 && top >= 0.0 && left < limit && top < limit) {
            return 1.0;
        }
        let (s, t) = (x - left, y - top);
        let at = top as usize * RESOLUTION + left as usize;
        let lit = |k: usize| f64::from(u8::from(nearness + bias >= f64::from(self.nearest[k])));
        (lit(at) * (1.0 - s) + lit(at + 1) * s) * (1.0 - t)
            + (lit(at + RESOLUTION) * (1.0 - s) + lit(at + RESOLUTION + 1) * s) * t
    }
}

/// The nearest surface seen from a lamp.
fn shadow_map(meshes: &[Mesh], lens: &Lens, clip: Option<&Plane>) -> Vec<f32> {
    let mut nearest = vec![f32::NEG_INFINITY; RESOLUTION * RESOLUTION];
    for mesh in meshes {
        let clip = clip.filter(|_| mesh.cut.is_some());
        for t in 0..mesh.surface.triangles.len() {
            let corners = mesh.surface.corners(t);
            let hidden = |p: DVec3| clip.is_some_and(|plane| plane.distance(p) > 0.0);
            if corners.into_iter().any(hidden) {
                continue;
            }
            let [Some(a), Some(b), Some(c)] = corners.map(|p| lens.project(p)) else {
                continue;
            };
            let area = (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]);
            for_each_pixel([a, b, c], area, RESOLUTION, &(0..RESOLUTION), |at, w| {
                let depth = (w[0] * a[2] + w[1] * b[2] + w[2] * c[2]) as f32;
                nearest[at] = nearest[at].max(depth);
            });
        }
    }
    nearest
}
