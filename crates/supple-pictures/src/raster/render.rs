//! Meshes to a picture.

use super::camera::{Camera, Lens};
use super::depth::{CUT, Sample, rasterise};
use super::light::Dome;
use super::mesh::{Mesh, Plane};
use crate::colour::{Colour, from_srgb, mix, to_srgb};
use crate::image::Image;
use glam::DVec3;
use supple::internal::math::par_map;

/// How a picture is taken.
#[derive(Clone, Debug)]
pub struct View {
    /// From where.
    pub camera: Camera,
    /// Pixels in a row.
    pub width: usize,
    /// Number of rows.
    pub height: usize,
    /// Samples along each side of a pixel; 2 or 4 share the lamps evenly.
    pub supersampling: usize,
    /// Behind everything.
    pub background: Colour,
    /// Height along the camera's up of a floor that is only seen by the shadows on it, m.
    pub floor: Option<f64>,
    /// Opens the meshes that have a cut colour.
    pub clip: Option<Plane>,
    /// Lamps around the scene, each with a shadow map: time for smooth shadows. A multiple of 4.
    pub lamps: usize,
}

impl View {
    /// The usual background, sRGB.
    pub const BACKGROUND: u32 = 0xf4f2ee;

    /// A picture of the given size on a light background, without floor or cut.
    pub fn new(camera: Camera, width: usize, height: usize) -> Self {
        Self {
            camera,
            width,
            height,
            supersampling: 4,
            background: from_srgb(Self::BACKGROUND),
            floor: None,
            clip: None,
            lamps: 224,
        }
    }

    /// The same picture quickly: few samples, few lamps; more where a floor shows their shadows one by one.
    pub fn draft(self) -> Self {
        Self {
            supersampling: 2,
            lamps: if self.floor.is_some() { 96 } else { 16 },
            ..self
        }
    }
}

/// Draws `meshes`. Same input, same picture.
pub fn render(meshes: &[Mesh], view: &View) -> Image {
    let samples = view.supersampling.clamp(1, 8);
    let lens = Lens::new(&view.camera, view.width * samples, view.height * samples);
    let (centre, radius) = bounding_ball(meshes);
    let up = view.camera.up.normalize_or(DVec3::Z);
    let axes = view.camera.axes();
    let studio = Studio {
        meshes,
        view,
        dome: Dome::new(
            view.lamps.max(4),
            meshes,
            view.clip.as_ref(),
            centre,
            radius,
            axes,
            up,
        ),
        lens,
        up,
        centre,
        radius,
    };
    // A band of pixel rows at a time keeps the samples of the whole picture out of memory.
    const BAND: usize = 8;
    let bands = par_map(view.height.div_ceil(BAND), |band| {
        let rows = band * BAND..((band + 1) * BAND).min(view.height);
        let width = view.width * samples;
        let sampled = rows.start * samples..rows.end * samples;
        let hits = rasterise(meshes, &studio.lens, view.clip.as_ref(), width, sampled);
        let mut pixels = Vec::with_capacity(rows.len() * view.width);
        for y in 0..rows.len() {
            for x in 0..view.width {
                let mut sum = [0.0; 3];
                for sub in 0..samples * samples {
                    let (sx, sy) = (x * samples + sub % samples, y * samples + sub / samples);
                    let colour =
                        studio.shade(&hits[sy * width + sx], sx, rows.start * samples + sy);
                    (0..3).for_each(|k| sum[k] += colour[k]);
                }
                pixels.push(to_srgb(sum.map(|c| c / (samples * samples) as f32)));
            }
        }
        pixels
    });
    Image {
        width: view.width,
        height: view.height,
        pixels: bands.concat(),
    }
}

/// Everything that shading a sample needs.
struct Studio<'a> {
    meshes: &'a [Mesh],
    view: &'a View,
    dome: Dome,
    lens: Lens,
    up: DVec3,
    centre: DVec3,
    radius: f64,
}

impl Studio<'_> {
    /// Colour of the sample at (`x`, `y`) of the supersampled picture.
    fn shade(&self, hit: &Sample, x: usize, y: usize) -> Colour {
        // Neighbours in a 2×2 square of samples use different lamps.
        let turn = 2 * (y % 2) + x % 2;
        let (origin, direction) = self.lens.ray(x as f64 + 0.5, y as f64 + 0.5);
        if hit.nearness == f64::NEG_INFINITY {
            return self.shade_floor(origin, direction, turn);
        }
        let mesh = &self.meshes[hit.mesh as usize];
        if let (CUT, Some(plane), Some(colour)) = (hit.triangle, &self.view.clip, mesh.cut) {
            let normal = plane.normal.normalize_or(DVec3::Z);
            let point = origin - direction * (plane.distance(origin) / direction.dot(normal));
            let (light, _) = self.dome.irradiance(point, normal, turn);
            return colour.map(|c| c * (0.45 + 0.55 * light as f32));
        }
        let corners = mesh.surface.triangles[hit.triangle as usize].map(|v| v as usize);
        let weights = [1.0 - hit.u - hit.v, hit.u, hit.v];
        let blend = |values: &[DVec3]| -> DVec3 {
            (0..3)
                .map(|k| f64::from(weights[k]) * values[corners[k]])
                .sum()
        };
        let point = blend(&mesh.surface.positions);
        let normal = blend(&mesh.normals).normalize_or(-direction);
        let albedo: Colour = std::array::from_fn(|k| {
            (0..3)
                .map(|c| weights[c] * mesh.colours[corners[c]][k])
                .sum()
        });
        let (light, open) = self.dome.irradiance(point, normal, turn);
        // Light bounced once between surfaces of the same colour fills the occluded part a little.
        let bounced = 0.25 * (open - light).max(0.0) as f32;
        let halfway = (self.dome.key - direction).normalize_or(normal);
        let lit = if open > 0.0 { light / open } else { 0.0 };
        let gloss = 0.07 * (lit * normal.dot(halfway).max(0.0).powi(40)) as f32;
        albedo.map(|a| 0.92 * a * (light as f32 + bounced * a) + gloss)
    }

    /// The background, darkened where the floor is in shadow.
    fn shade_floor(&self, origin: DVec3, direction: DVec3, turn: usize) -> Colour {
        let background = self.view.background;
        let Some(level) = self.view.floor else {
            return background;
        };
        let descent = direction.dot(self.up);
        let distance = (level - origin.dot(self.up)) / descent;
        if !(distance > 0.0 && distance.is_finite()) {
            return background;
        }
        let point = origin + direction * distance;
        let (light, open) = self.dome.irradiance(point, self.up, turn);
        // Shadow maps end at the bounding ball; fade before that.
        let away = (point - self.centre).length() / self.radius;
        let fade = (3.0 - 3.0 * away).clamp(0.0, 1.0);
        let share = 1.0 - fade * (1.0 - light / open.max(1e-9));
        mix([0.0; 3], background, share as f32)
    }
}

/// A ball around all vertices, with a little room for the shadows beside them.
fn bounding_ball(meshes: &[Mesh]) -> (DVec3, f64) {
    let points = || meshes.iter().flat_map(|m| &m.surface.positions);
    let (low, high) = points().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(l, h), p| {
        (l.min(*p), h.max(*p))
    });
    if !(low.is_finite() && high.is_finite()) {
        return (DVec3::ZERO, 1.0);
    }
    let centre = 0.5 * (low + high);
    let radius = points().map(|p| (*p - centre).length()).fold(0.0, f64::max);
    (centre, 1.6 * radius.max(1e-6))
}
