//! A run as a strip of pictures, and as one that moves.

use crate::animation::Animation;
use crate::colour::{Colour, from_srgb};
use crate::colour_scale::ColourScale;
use crate::image::Image;
use crate::raster::{Camera, Mesh, Plane, View, render};
use crate::strip::{Legend, Panel, Strip};
use glam::DVec3;
use supple::collider::Shape;
use supple::model::{Avatar, Surface};
use supple_files::BODY_COLOUR;
use supple_scene::{COLLIDER_COLOUR, Focus, HALF_SPACE_EXTENT, Inset, Scene, Snapshot};

/// Cut tissue.
const FLESH: u32 = 0xd98a7b;
/// Around an inset.
const FRAME: u32 = 0xb8b0a5;

/// Draws the snapshots side by side: the skin coloured by its unposed displacement, and the colliders.
/// All of them share the colour scale, and the camera where they do not ask for their own.
pub fn picture_strip(scene: &Scene, avatar: &Avatar, snapshots: &[Snapshot]) -> Image {
    let Panels {
        panels,
        legend,
        background,
    } = draw_panels(scene, avatar, snapshots, &mut |_| {});
    let strip = Strip {
        panels,
        legend: Some(legend),
        ..Strip::default()
    };
    strip.compose(background)
}

/// The same pictures one after the other, `frame_time` seconds each; `progress` is called with the number drawn so far.
pub fn picture_animation(
    scene: &Scene,
    avatar: &Avatar,
    snapshots: &[Snapshot],
    frame_time: f64,
    progress: &mut dyn FnMut(usize),
) -> Animation {
    let Panels {
        panels,
        legend,
        background,
    } = draw_panels(scene, avatar, snapshots, progress);
    let frame = |panel: Panel| {
        let strip = Strip {
            panels: vec![panel],
            legend: Some(legend.clone()),
            ..Strip::default()
        };
        strip.compose(background)
    };
    Animation {
        frames: panels.into_iter().map(frame).collect(),
        frame_time,
    }
}

/// Snapshots drawn alike.
struct Panels {
    panels: Vec<Panel>,
    legend: Legend,
    background: Colour,
}

fn draw_panels(
    scene: &Scene,
    avatar: &Avatar,
    snapshots: &[Snapshot],
    progress: &mut dyn FnMut(usize),
) -> Panels {
    let output = &scene.output;
    let up = scene.up().direction();
    let displacements = snapshots.iter().flat_map(|s| &s.displacement);
    let largest = displacements.map(|d| d.length()).fold(1e-5, f64::max);
    let scale = ColourScale::up_to(output.legend_mm.unwrap_or(1e3 * largest));
    let scenes: Vec<Vec<Mesh>> = snapshots
        .iter()
        .map(|s| meshes(scene, avatar, s, &scale))
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
            true => (middle(&s.skin) - middle(&snapshots[0].skin)).reject_from(up),
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
    let camera = Camera::framing(&framed, output.view, up, aspect);
    let view = View {
        clip: output.cut.map(|c| Plane {
            point: c.point,
            normal: c.normal,
        }),
        floor: output.floor,
        ..View::new(camera, width, height)
    };
    let view = if output.draft { view.draft() } else { view };
    let panel = |((snapshot, meshes), travel): ((&Snapshot, &Vec<Mesh>), &DVec3)| {
        let direction = snapshot.panel.view.unwrap_or(output.view);
        let going_along = |camera: Camera| Camera {
            eye: camera.eye + *travel,
            target: camera.target + *travel,
            ..camera
        };
        let camera = match (snapshot.panel.focus, snapshot.panel.view) {
            (None, None) => going_along(camera),
            (None, Some(_)) => going_along(Camera::framing(&framed, direction, up, aspect)),
            (Some(Focus { point, radius }), _) => {
                Camera::near(point, radius, direction, up, aspect)
            }
        };
        let view = View {
            camera,
            ..view.clone()
        };
        let mut image = render(meshes, &view);
        if let Some(inset) = snapshot.panel.inset {
            let unposed = unposed_picture(avatar, snapshot, inset, &scale, &view);
            image.inset(&unposed, from_srgb(FRAME));
        }
        Panel {
            image,
            caption: snapshot.panel.caption.clone(),
        }
    };
    Panels {
        panels: (snapshots.iter().zip(&scenes).zip(&travels).enumerate())
            .map(|(k, of)| {
                progress(k);
                panel(of)
            })
            .collect(),
        legend: Legend {
            title: "unposed displacement (mm)".into(),
            scale,
        },
        background: view.background,
    }
}

fn middle(points: &[DVec3]) -> DVec3 {
    points.iter().sum::<DVec3>() / points.len().max(1) as f64
}

/// The reference shape, displaced and coloured as the snapshot's skin is, at a third of `view`'s size.
fn unposed_picture(
    avatar: &Avatar,
    snapshot: &Snapshot,
    inset: Inset,
    scale: &ColourScale,
    view: &View,
) -> Image {
    let rest = avatar.skin.position.iter();
    let positions = rest.zip(&snapshot.displacement).map(|(x, d)| *x + *d);
    let skin = skin_mesh(avatar, positions.collect(), snapshot, scale);
    let [width, height] = [view.width / 3, view.height / 3];
    let aspect = width as f64 / height as f64;
    let up = inset.up.unwrap_or_else(|| avatar.up.direction());
    let camera = Camera::framing(&skin.surface.positions, inset.view, up, aspect);
    let view = View {
        camera,
        width,
        height,
        clip: None,
        ..view.clone()
    };
    render(&[skin], &view)
}

/// The skin at `positions`, coloured by its displacement in mm.
fn skin_mesh(
    avatar: &Avatar,
    positions: Vec<DVec3>,
    snapshot: &Snapshot,
    scale: &ColourScale,
) -> Mesh {
    let surface = Surface {
        positions,
        triangles: avatar.skin_triangles().to_vec(),
    };
    let displacement = snapshot.displacement.iter().map(|d| 1e3 * d.length());
    Mesh::coloured(surface, scale.colours(displacement))
}

fn meshes(scene: &Scene, avatar: &Avatar, snapshot: &Snapshot, scale: &ColourScale) -> Vec<Mesh> {
    let skin = skin_mesh(avatar, snapshot.skin.clone(), snapshot, scale);
    let mut meshes = vec![match scene.output.cut {
        Some(_) => skin.opened(from_srgb(FLESH)),
        None => skin,
    }];
    for (body, frame) in avatar.bodies.iter().zip(&snapshot.bodies) {
        let colour = from_srgb(BODY_COLOUR);
        meshes.push(Mesh::collider(
            &body.shape,
            frame,
            HALF_SPACE_EXTENT,
            colour,
        ));
    }
    if !snapshot.panel.colliders {
        return meshes;
    }
    let colour = from_srgb(COLLIDER_COLOUR);
    for (collider, frame) in scene.colliders.iter().zip(&snapshot.colliders) {
        let shape: &Shape = &collider.shape;
        if scene.output.floor.is_some() && *shape == Shape::HalfSpace {
            continue; // seen by the shadows on it
        }
        meshes.push(Mesh::collider(shape, frame, HALF_SPACE_EXTENT, colour));
    }
    meshes
}
