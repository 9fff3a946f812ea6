//! A finger of three bones: a closed tapered skin with knuckles and pads, meshed as a prism shell.

use glam::DVec3;
use std::f64::consts::{FRAC_PI_2, TAU};
use supple::Result;
use supple::internal::math::Rows;
use supple::model::{JointList, PoseBlend, Skeleton, SkinWeight, Surface, UpAxis};
use supple_bake::mesh::ShellOptions;
use supple_bake::{Body, Mesher};

/// Length along the centre line, m.
const LENGTH: f64 = 0.088;

/// Where the three joints lie along the centre line, m: the base, and the two knuckles.
const JOINTS: [f64; 3] = [0.004, 0.042, 0.067];

/// How far the finger bends at each joint at rest, rad.
const REST_BEND: [f64; 3] = [0.0, 0.14, 0.08];

/// Half the length over which two bones blend, m.
const BLEND: f64 = 0.008;

/// How finely a finger is made.
#[derive(Clone, Debug, PartialEq)]
pub struct Finger {
    /// Aimed length of the skin's edges, m.
    pub edge_length: f64,
    /// The soft layer.
    pub shell: ShellOptions,
}

impl Default for Finger {
    /// About 750 vertices and two layers.
    fn default() -> Self {
        Self {
            edge_length: 0.0028,
            shell: ShellOptions {
                thickness: Some(0.005),
                layers: Some(2),
                ..ShellOptions::default()
            },
        }
    }
}

impl Finger {
    /// The finger: it lies along +x, its pads look to −z, its base joint is the root.
    ///
    /// # Errors
    /// [`supple::Error::Invalid`] where the edge length is not between 1 and 6 mm, or as
    /// [`Mesher::mesh`].
    pub fn body(&self) -> Result<Body> {
        if !(0.001..=0.006).contains(&self.edge_length) {
            return Err(supple::Error::invalid(
                "edge_length",
                "must be 0.001 to 0.006 m",
            ));
        }
        let axis = CentreLine::new();
        let (skin, arc) = finger_skin(&axis, self.edge_length);
        let skinning: Rows<SkinWeight> = arc.iter().map(|&s| bone_weights(s)).collect();
        let skeleton = Skeleton {
            aliases: Vec::new(),
            limits: Vec::new(),
            names: ["proximal", "middle", "distal"].map(String::from).into(),
            parents: vec![None, Some(0), Some(1)],
            joints: JOINTS.map(|s| axis.at(s).0).into(),
        };
        let mut body = Body {
            name: "finger".into(),
            joints: JointList::of_bones(&skeleton),
            springs: Default::default(),
            up: UpAxis::Z,
            skeleton,
            skin,
            skinning,
            pose_blend: PoseBlend::default(),
            bone_surfaces: Vec::new(),
            layer: Default::default(),
            painted: Default::default(),
            attachments: Vec::new(),
            render_meshes: Vec::new(),
            appearance: Default::default(),
        };
        Mesher::PrismShell(self.shell.clone()).mesh(&mut body)?;
        body.validate()?;
        Ok(body)
    }
}

/// 0 before −1, 1 after 1, smooth between.
fn smooth_step(u: f64) -> f64 {
    let u = (0.5 * (u + 1.0)).clamp(0.0, 1.0);
    u * u * (3.0 - 2.0 * u)
}

/// Weights of the bones at arc length `s`; a bone takes over from its parent around its joint.
fn bone_weights(s: f64) -> Vec<SkinWeight> {
    let middle = smooth_step((s - JOINTS[1]) / BLEND);
    let distal = smooth_step((s - JOINTS[2]) / BLEND);
    [
        (0, 1.0 - middle),
        (1, middle * (1.0 - distal)),
        (2, middle * distal),
    ]
    .into_iter()
    .filter(|&(_, weight)| weight > 0.0)
    .map(|(bone, weight)| SkinWeight { bone, weight })
    .collect()
}

/// The gently bent curve through the finger, tabulated.
struct CentreLine {
    points: Vec<DVec3>,
    step: f64,
}

impl CentreLine {
    fn new() -> Self {
        let count = 400;
        let step = LENGTH / count as f64;
        let mut points = vec![DVec3::ZERO];
        for i in 0..count {
            let (sine, cosine) = bend((i as f64 + 0.5) * step).sin_cos();
            points.push(points[i] + step * DVec3::new(cosine, 0.0, -sine));
        }
        Self { points, step }
    }

    /// The point at arc length `s` and the dorsal direction there.
    fn at(&self, s: f64) -> (DVec3, DVec3) {
        let u = s / self.step;
        let i = (u.max(0.0) as usize).min(self.points.len() - 2);
        let point = self.points[i].lerp(self.points[i + 1], u - i as f64);
        let (sine, cosine) = bend(s).sin_cos();
        (point, DVec3::new(sine, 0.0, cosine))
    }
}

/// Angle of the centre line below the x axis at arc length `s`, rad.
fn bend(s: f64) -> f64 {
    (0..3)
        .map(|j| REST_BEND[j] * smooth_step((s - JOINTS[j]) / 0.01))
        .sum()
}

/// A bump of height 1 at `centre`.
fn bump(s: f64, centre: f64, width: f64) -> f64 {
    (-((s - centre) / width).powi(2)).exp()
}

/// Half width, height above and depth below the centre line at arc length `s`, m: a taper, wider at
/// the knuckles, with creases between three pads.
fn cross_section(s: f64) -> [f64; 3] {
    let taper = 1.0 - 0.2 * s / LENGTH;
    let knuckles = bump(s, JOINTS[1], 0.006) + 0.7 * bump(s, JOINTS[2], 0.0045);
    let pads = bump(s, 0.022, 0.010) + bump(s, 0.055, 0.006) + 1.2 * bump(s, 0.077, 0.007);
    // The back flattens towards the nail.
    let nail = smooth_step((s - 0.079) / 0.008);
    [
        0.0092 * taper + 0.0007 * knuckles + 0.0003 * pads,
        0.0084 * taper + 0.0011 * knuckles - 0.0012 * nail,
        0.0078 * taper + 0.0012 * pads,
    ]
}

/// Arc length and radial scale along the outline, from the middle of the closed base to the tip.
fn outline(u: f64) -> (f64, f64) {
    // Superellipse quarters: a rounded flat base, a rounder tip.
    let cap = |angle: f64, power: f64| {
        let (sine, cosine) = angle.sin_cos();
        (
            cosine.max(0.0).powf(2.0 / power),
            sine.max(0.0).powf(2.0 / power),
        )
    };
    let (base, tip) = (0.006, 0.010);
    if u < 1.0 {
        let (along, radial) = cap(u * FRAC_PI_2, 2.6);
        (base * (1.0 - along), radial)
    } else if u < 2.0 {
        (base + (LENGTH - base - tip) * (u - 1.0), 1.0)
    } else {
        let (along, radial) = cap((3.0 - u) * FRAC_PI_2, 2.3);
        (LENGTH - tip * (1.0 - along), radial)
    }
}

/// The skin, and the arc length of each vertex: rings at equal distances along the outline, each
/// with as many vertices as its length asks for.
fn finger_skin(axis: &CentreLine, edge_length: f64) -> (Surface, Vec<f64>) {
    let place = |s: f64, scale: f64, angle: f64| {
        let (centre, up) = axis.at(s);
        let [width, above, below] = cross_section(s);
        let (sine, cosine) = angle.sin_cos();
        let height = if sine > 0.0 { above } else { below };
        centre + scale * (width * cosine * DVec3::Y + height * sine * up)
    };
    // Distance along the outline, measured at the side.
    let samples: Vec<(f64, f64)> = (0..=3000).map(|i| outline(i as f64 / 1000.0)).collect();
    let mut distance = vec![0.0];
    for pair in samples.windows(2) {
        let [a, b] = [pair[0], pair[1]].map(|(s, scale)| place(s, scale, 0.0));
        distance.push(distance[distance.len() - 1] + (b - a).length());
    }
    let total = distance[distance.len() - 1];
    // Rows of equilateral triangles are 0.87 edges apart.
    let rings = (total / (0.87 * edge_length)).round() as usize;

    let mut skin = Surface::default();
    let mut arc = Vec::new();
    let mut previous: Vec<u32> = Vec::new();
    for r in 0..=rings {
        let wanted = total * r as f64 / rings as f64;
        let i = distance
            .partition_point(|&d| d < wanted)
            .min(samples.len() - 1);
        let (s, scale) = samples[i];
        let around: f64 = (0..32)
            .map(|k| TAU * k as f64 / 32.0)
            .map(|a| (place(s, scale, a + TAU / 32.0) - place(s, scale, a)).length())
            .sum();
        let count = match r {
            0 => 1,
            _ if r == rings => 1,
            _ => ((around / edge_length).round() as usize).max(5),
        };
        let ring: Vec<u32> = (0..count)
            .map(|k| {
                // Every other row is shifted by half an edge.
                let angle = TAU * (k as f64 + 0.5 * (r % 2) as f64) / count as f64;
                skin.positions
                    .push(place(s, if count == 1 { 0.0 } else { scale }, angle));
                arc.push(s);
                skin.positions.len() as u32 - 1
            })
            .collect();
        stitch(&previous, &ring, r % 2, &mut skin.triangles);
        previous = ring;
    }
    (skin, arc)
}

/// Triangles between two rings around x, `left` at smaller x; `shifted` says which of them (0 left,
/// 1 right) is turned by half an edge. The next corner is always the one that comes first around.
fn stitch(left: &[u32], right: &[u32], shifted: usize, triangles: &mut Vec<[u32; 3]>) {
    if left.is_empty() {
        return;
    }
    let turn = |i: usize, count: usize, half: bool| {
        (i as f64 + if half { 0.5 } else { 0.0 }) / count as f64
    };
    // A ring of one vertex, a pole, takes no steps.
    let steps = |ring: &[u32]| if ring.len() == 1 { 0 } else { ring.len() };
    let (mut i, mut j) = (0, 0);
    while i < steps(left) || j < steps(right) {
        let next_left = turn(i + 1, left.len(), shifted == 0);
        let next_right = turn(j + 1, right.len(), shifted == 1);
        let (a, b) = (left[i % left.len()], right[j % right.len()]);
        if j >= steps(right) || (i < steps(left) && next_left < next_right) {
            i += 1;
            triangles.push([a, left[i % left.len()], b]);
        } else {
            j += 1;
            triangles.push([a, right[j % right.len()], b]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use supple_bake::mesh::MeshQuality;

    #[test]
    fn a_closed_skin_of_finger_size_with_smooth_weights() {
        let body = Finger::default().body().unwrap();
        let skin = &body.skin;
        assert!(skin.is_closed());
        assert!(
            (600..=1000).contains(&skin.positions.len()),
            "{}",
            skin.positions.len()
        );
        // An index finger: some 15 to 20 cm³.
        assert!((12e-6..22e-6).contains(&skin.volume()), "{}", skin.volume());
        let longest = skin.triangles.iter().enumerate().map(|(t, _)| {
            let [a, b, c] = skin.corners(t);
            (b - a).length().max((c - b).length()).max((a - c).length())
        });
        assert!(longest.fold(0.0, f64::max) < 2.2 * Finger::default().edge_length);
        for (row, t) in body.skinning.iter().zip(0..) {
            let sum: f64 = row.iter().map(|w| w.weight).sum();
            assert!((sum - 1.0).abs() < 1e-12, "vertex {t}");
        }
        // No seam: a weight changes by no more than its slope allows along an edge.
        let weight = |v: u32, bone: u32| {
            (body
                .skinning
                .row(v as usize)
                .iter()
                .find(|w| w.bone == bone))
            .map_or(0.0, |w| w.weight)
        };
        for &[a, b, c] in &skin.triangles {
            for (u, v) in [(a, b), (b, c), (c, a)] {
                let length = (skin.positions[u as usize] - skin.positions[v as usize]).length();
                for bone in 0..3 {
                    let step = (weight(u, bone) - weight(v, bone)).abs();
                    assert!(step <= 2.0 * 0.75 / BLEND * length + 1e-9);
                }
            }
        }
    }

    #[test]
    fn the_shell_is_sound_at_every_size() {
        for edge_length in [0.0015, 0.0028, 0.005] {
            for (thickness, layers) in [(0.003, 1), (0.005, 2), (0.02, 4)] {
                let shell = ShellOptions {
                    thickness: Some(thickness),
                    layers: Some(layers),
                    ..ShellOptions::default()
                };
                let body = Finger { edge_length, shell }.body().unwrap();
                let quality = MeshQuality::of(&body.layer.mesh);
                assert_eq!(quality.inverted, 0, "{quality}");
                assert!(quality.volume < body.skin.volume());
                for bone in 0..3 {
                    assert!(body.layer.bone_of_node.contains(&Some(bone)));
                }
            }
        }
    }

    #[test]
    fn the_same_finger_twice() {
        let [a, b] = [0, 1].map(|_| Finger::default().body().unwrap());
        assert!(a == b);
        assert!(
            Finger {
                edge_length: f64::NAN,
                ..Finger::default()
            }
            .body()
            .is_err()
        );
    }
}
