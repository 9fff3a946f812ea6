//! A motion's preview: figures side by side, no physics.

use super::{Camera, Colour, Image, Mesh, Panel, Strip, View, from_srgb, render};
use glam::{DMat3, DQuat, DVec3};
use supple::collider::Shape;
use supple::model::{Frame, Skeleton, Surface};
use supple_bake::Body;

/// What is drawn of an avatar in a pose.
pub enum Figure<'a> {
    /// Its skin, by linear blend skinning.
    Skin(&'a Body),
    /// A stick for each bone.
    Sticks(&'a Skeleton),
}

const SKIN: u32 = 0xd9b8a0;
const STICK: u32 = 0x8fa3b8;

impl Figure<'_> {
    fn meshes(&self, frames: &[Frame]) -> Vec<Mesh> {
        match self {
            Self::Skin(body) => vec![Mesh::new(skinned(body, frames), from_srgb(SKIN))],
            Self::Sticks(skeleton) => sticks(skeleton, frames, from_srgb(STICK)),
        }
    }
}

/// Draws `figure` in each of the poses, which have captions, seen in direction `view`.
pub fn motion_strip(
    figure: &Figure<'_>,
    poses: &[(String, Vec<Frame>)],
    view: DVec3,
    up: DVec3,
    [width, height]: [usize; 2],
) -> Image {
    let background = View::new(Camera::framing(&[DVec3::ZERO], view, up, 1.0), 1, 1).background;
    let panel = |(caption, frames): &(String, Vec<Frame>)| {
        let meshes = figure.meshes(frames);
        let points: Vec<DVec3> = (meshes.iter())
            .flat_map(|m| m.surface.positions.iter().copied())
            .collect();
        let camera = Camera::framing(&points, view, up, width as f64 / height as f64);
        let view = View {
            supersampling: 2,
            ..View::new(camera, width, height)
        };
        Panel {
            image: render(&meshes, &view),
            caption: caption.clone(),
        }
    };
    let strip = Strip {
        panels: poses.iter().map(panel).collect(),
        ..Strip::default()
    };
    strip.compose(background)
}

/// x = Σ w_j (R_j (X − J_j) + c_j).
fn skinned(body: &Body, frames: &[Frame]) -> Surface {
    let place = |(x, row): (&DVec3, &[supple::model::SkinWeight])| {
        row.iter()
            .map(|w| {
                let j = w.bone as usize;
                w.weight * frames[j].transform(*x - body.skeleton.joints[j])
            })
            .sum()
    };
    Surface {
        positions: (body.skin.positions.iter())
            .zip(body.skinning.iter())
            .map(place)
            .collect(),
        triangles: body.skin.triangles.clone(),
    }
}

/// From each bone's parent to its own joint.
fn sticks(skeleton: &Skeleton, frames: &[Frame], colour: Colour) -> Vec<Mesh> {
    let low = frames
        .iter()
        .fold(DVec3::INFINITY, |a, f| a.min(f.position));
    let high = frames
        .iter()
        .fold(DVec3::NEG_INFINITY, |a, f| a.max(f.position));
    let radius = 0.012 * (high - low).length().max(1e-3);
    let stick = |(j, parent): (usize, &Option<u32>)| {
        let (a, b) = (frames[(*parent)? as usize].position, frames[j].position);
        let rotation = match (b - a).try_normalize() {
            Some(along) => DMat3::from_quat(DQuat::from_rotation_arc(DVec3::Z, along)),
            None => DMat3::IDENTITY,
        };
        let frame = Frame {
            rotation,
            position: 0.5 * (a + b),
        };
        let shape = Shape::Capsule {
            radius,
            half_length: 0.5 * (b - a).length(),
        };
        Some(Mesh::collider(&shape, &frame, 1.0, colour))
    };
    (skeleton.parents.iter().enumerate())
        .filter_map(stick)
        .collect()
}
