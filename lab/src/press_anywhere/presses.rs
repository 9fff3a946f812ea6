//! Seeded presses: places nobody chose.

use glam::DVec3;
use serde::{Deserialize, Serialize};
use supple::collider::Shape;
use supple::internal::math::Random;
use supple::model::{Avatar, Frame, Surface};
use supple_bake::Softness;

/// Load steps of a press.
const LOAD_STEPS: usize = 10;
/// Softness below which nothing is pressed: automatic handles leave such skin out.
const STIFF: f64 = 0.3;
/// Radii of the sphere, m.
const RADII: [f64; 2] = [0.01, 0.04];
/// Depth of a press relative to the layer's under its place.
const DEPTHS: [f64; 2] = [0.2, 0.5];
/// How far the direction may turn from the normal, rad.
const TURN: f64 = 30.0 * std::f64::consts::PI / 180.0;

/// A sphere that is pushed into the skin.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Press {
    /// The skin vertex that it touches first.
    pub vertex: u32,
    /// Where that lies, m.
    pub place: DVec3,
    /// The skin's outward normal there.
    pub normal: DVec3,
    /// Where the sphere goes; a unit vector.
    pub direction: DVec3,
    /// Of the sphere, m.
    pub radius: f64,
    /// How far it goes, m.
    pub depth: f64,
    /// Depth of the layer under the place, m.
    pub layer: f64,
}

impl Press {
    /// What presses.
    pub fn shape(&self) -> Shape {
        Shape::Sphere {
            radius: self.radius,
        }
    }

    /// Where it stands in each load step.
    pub fn frames(&self) -> Vec<Frame> {
        let at = |k: usize| Frame {
            position: self.place
                + self.radius * self.normal
                + self.depth * k as f64 / LOAD_STEPS as f64 * self.direction,
            ..Frame::IDENTITY
        };
        (1..=LOAD_STEPS).map(at).collect()
    }
}

/// The first `count` presses of `seed` on `avatar`: a place on the soft skin by area, a direction within 30° of its normal, a
/// sphere of 10 to 40 mm, as deep as a fifth to half of the layer.
pub fn presses(avatar: &Avatar, seed: u64, count: usize) -> Vec<Press> {
    let softness = Softness::of_avatar(avatar);
    let vertices = avatar.tissue_vertices();
    let skin = Surface {
        positions: avatar.skin.position[..vertices].to_vec(),
        triangles: (avatar.skin_triangles().iter())
            .filter(|t| t.iter().all(|v| (*v as usize) < vertices))
            .copied()
            .collect(),
    };
    let normals = skin.vertex_normals();
    let soft = |v: usize| softness.softness[v] >= STIFF && normals[v] != DVec3::ZERO;
    let areas: Vec<f64> = (avatar.skin.measure[..vertices].iter().enumerate())
        .map(|(v, area)| if soft(v) { *area } else { 0.0 })
        .collect();
    let whole: f64 = areas.iter().sum();
    let mut random = Random::new(seed);
    let mut draw = |_| {
        let mut left = random.uniform(0.0, whole);
        let chosen = areas.iter().position(|area| {
            left -= area;
            *area > 0.0 && left <= 0.0
        });
        let vertex = chosen.unwrap_or(0);
        let normal = normals[vertex];
        // Even over the cap: cos uniform, and any way around.
        let cosine = random.uniform(TURN.cos(), 1.0);
        let (side, other) = normal.any_orthonormal_pair();
        let around = random.uniform(0.0, std::f64::consts::TAU);
        let across = around.cos() * side + around.sin() * other;
        let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
        let layer = softness.depth[vertex];
        Press {
            vertex: vertex as u32,
            place: skin.positions[vertex],
            normal,
            direction: -(cosine * normal + sine * across),
            radius: random.uniform(RADII[0], RADII[1]),
            depth: layer * random.uniform(DEPTHS[0], DEPTHS[1]),
            layer,
        }
    };
    (0..count).map(&mut draw).collect()
}
