//! The picture strip of a run.

use super::{COLLIDER_COLOUR, HALF_SPACE_EXTENT, Snapshot};
use crate::export::{
    Camera, Image, Legend, Mesh, Panel, Plane, Strip, View, colour_map, from_srgb, render,
};
use crate::load::Scene;
use crate::load::scene::Focus;
use crate::model::{Avatar, Surface};
use glam::DVec3;

/// Cut tissue.
const FLESH: u32 = 0xd98a7b;

/// Draws the snapshots side by side: the skin coloured by its unposed displacement, and the colliders.
/// All of them share the colour scale, and the camera where they do not ask for their own.
pub fn picture_strip(scene: &Scene, avatar: &Avatar, snapshots: &[Snapshot]) -> Image {
    let output = &scene.output;
    let largest = snapshots
        .iter()
        .flat_map(|s| &s.displacement)
        .fold(0.0, |a: f64, b| a.max(*b));
    let maximum = output.legend_mm.map_or(largest.max(1e-5), |mm| 1e-3 * mm);
    let scenes: Vec<Vec<Mesh>> = snapshots
        .iter()
        .map(|s| meshes(scene, avatar, s, maximum))
        .collect();
    let [width, height] = output.panel_size;
    // The skin is always framed; of colliders only those that are not as wide as a floor.
    let bounded = |m: &&Mesh| {
        let centre = m.surface.positions.iter().sum::<DVec3>() / m.surface.positions.len() as f64;
        (m.surface.positions.iter()).all(|p| (*p - centre).length() < HALF_SPACE_EXTENT)
    };
    let travels: Vec<DVec3> = snapshots
        .iter()
        .map(|s| match output.follow {
            // Over the ground: what stands on it does so at one height in all pictures.
            true => (middle(&s.skin) - middle(&snapshots[0].skin)).reject_from(DVec3::Z),
            false => DVec3::ZERO,
        })
        .collect();
    let framed: Vec<DVec3> = (scenes.iter().zip(&travels))
        .flat_map(|(meshes, travel)| {
            let (skin, colliders) = meshes.split_at(meshes.len().min(1));
            let shown = skin.iter().chain(colliders.iter().filter(bounded));
            shown.flat_map(move |m| m.surface.positions.iter().map(move |p| *p - *travel))
        })
        .collect();
    let aspect = width as f64 / height as f64;
    let camera = Camera::framing(&framed, output.view, DVec3::Z, aspect);
    let view = View {
        clip: output.cut.map(|c| Plane {
            point: c.point,
            normal: c.normal,
        }),
        ..View::new(camera, width, height)
    };
    let panel = |((snapshot, meshes), travel): ((&Snapshot, &Vec<Mesh>), &DVec3)| {
        let frame = |points: &[DVec3]| {
            let direction = snapshot.panel.view.unwrap_or(output.view);
            Camera::framing(points, direction, DVec3::Z, aspect)
        };
        let going_along = |camera: Camera| Camera {
            eye: camera.eye + *travel,
            target: camera.target + *travel,
            ..camera
        };
        let camera = match (snapshot.panel.focus, snapshot.panel.view) {
            (None, None) => going_along(camera),
            (None, Some(_)) => going_along(frame(&framed)),
            (Some(Focus { point, radius }), _) => frame(&corners(point, radius)),
        };
        let view = View {
            camera,
            ..view.clone()
        };
        Panel {
            image: render(meshes, &view),
            caption: snapshot.panel.caption.clone(),
        }
    };
    let strip = Strip {
        panels: (snapshots.iter().zip(&scenes).zip(&travels))
            .map(panel)
            .collect(),
        legend: Some(Legend {
            title: "unposed displacement (mm)".into(),
            maximum: 1e3 * maximum,
        }),
        key: Vec::new(),
    };
    strip.compose(view.background)
}

fn middle(points: &[DVec3]) -> DVec3 {
    points.iter().sum::<DVec3>() / points.len().max(1) as f64
}

/// Corners of the cube in a ball.
fn corners(centre: DVec3, radius: f64) -> Vec<DVec3> {
    let corner = |k: usize| {
        let sign = |bit: usize| if k >> bit & 1 == 0 { -radius } else { radius };
        centre + DVec3::new(sign(0), sign(1), sign(2)) / 3f64.sqrt()
    };
    (0..8).map(corner).collect()
}

fn meshes(scene: &Scene, avatar: &Avatar, snapshot: &Snapshot, maximum: f64) -> Vec<Mesh> {
    let skin = Surface {
        positions: snapshot.skin.clone(),
        triangles: avatar.triangles.clone(),
    };
    let colours = snapshot
        .displacement
        .iter()
        .map(|d| colour_map(d / maximum));
    let skin = Mesh::coloured(skin, colours.collect());
    let mut meshes = vec![match scene.output.cut {
        Some(_) => skin.opened(from_srgb(FLESH)),
        None => skin,
    }];
    if !snapshot.panel.colliders {
        return meshes;
    }
    let colour = from_srgb(COLLIDER_COLOUR);
    for (collider, frame) in scene.colliders.iter().zip(&snapshot.colliders) {
        let shape = &collider.shape;
        meshes.push(Mesh::collider(shape, frame, HALF_SPACE_EXTENT, colour));
    }
    meshes
}
