//! Draws the generated body: at rest, walking, sitting, and four other people of its shape space.
//!
//!     cargo run --release --example sample_body -- assets/pictures/body.png
//!
//! What `ParametricModel` offers in a few lines: shape parameters, local rotations by the bones' names,
//! the skin that comes out.

use supple::Result;
use supple::glam::{DMat3, DVec3};
use supple::internal::math::rotation_exp;
use supple::model::Surface;
use supple_bake::ParametricModel;
use supple_pictures::{Camera, Image, Mesh, Panel, Projection, Strip, View, from_srgb, render};

/// Rotations of left bones about x, y and z (degrees); right ones take the mirror image unless `alternate`,
/// where they take that of the opposite turn about x.
fn pose(model: &ParametricModel, turns: &[(&str, [f64; 3])], alternate: bool) -> Vec<DMat3> {
    let mut pose = vec![DMat3::IDENTITY; model.names.len()];
    for &(name, degrees) in turns {
        let [x, y, z] = degrees.map(f64::to_radians);
        for (bone, rotation) in model.names.iter().zip(&mut pose) {
            if bone.strip_prefix("left_") == Some(name) || bone == name {
                *rotation = rotation_exp(DVec3::new(x, y, z));
            } else if bone.strip_prefix("right_") == Some(name) {
                let x = if alternate { -x } else { x };
                *rotation = rotation_exp(DVec3::new(x, -y, -z));
            }
        }
    }
    pose
}

/// The skin seen from a direction, in a panel `width` pixels wide.
fn panel(skin: Vec<DVec3>, model: &ParametricModel, from: DVec3, width: usize) -> Image {
    let surface = Surface {
        positions: skin,
        triangles: model.triangles.clone(),
    };
    const HEIGHT: usize = 380;
    let target = DVec3::new(0.0, 0.93, 0.0);
    let camera = Camera {
        eye: target + 4.0 * from.normalize(),
        target,
        up: DVec3::Y,
        projection: Projection::Orthographic(2.1),
    };
    let mut view = View::new(camera, width, HEIGHT);
    view.supersampling = 2;
    view.floor = Some(0.0);
    render(&[Mesh::new(surface, from_srgb(0xd8a88a))], &view)
}

fn main() -> Result<()> {
    let path = std::env::args().nth(1).unwrap_or("body.png".into());
    let model = supple_samples::body()?.model;
    let rest = pose(&model, &[], false);
    let down = ("shoulder", [0.0, 0.0, -68.0]);
    let standing = pose(&model, &[down, ("elbow", [0.0, -12.0, 0.0])], false);
    let walking = pose(
        &model,
        &[
            ("hip", [-24.0, 0.0, 0.0]),
            ("knee", [8.0, 0.0, 0.0]),
            ("shoulder", [18.0, 0.0, -68.0]),
            ("elbow", [0.0, -25.0, 0.0]),
        ],
        true,
    );
    let sitting = pose(
        &model,
        &[
            down,
            ("hip", [-88.0, 0.0, 6.0]),
            ("knee", [88.0, 0.0, 0.0]),
            ("elbow", [0.0, -75.0, 0.0]),
        ],
        false,
    );
    let (front, side) = (DVec3::new(0.0, 0.05, 1.0), DVec3::new(0.8, 0.15, 0.75));
    let back = DVec3::new(-0.5, 0.1, -1.0);
    // Stature, weight, leg length, shoulders, breast, belly, muscles, hips, head, arms.
    let people: [[f64; 10]; 4] = [
        [-1.5, 0.3, 0.5, -1.5, 2.0, -0.5, -1.0, 1.5, 0.0, 0.0],
        [1.5, 0.0, 0.5, 1.5, -1.2, -0.8, 2.0, -0.8, 0.0, 0.0],
        [0.0, 2.2, -0.5, 0.5, 0.5, 1.5, -1.0, 0.5, -0.5, 0.0],
        [-0.5, -2.0, 1.0, 0.0, -0.5, 0.0, -1.0, -0.5, 0.8, 0.5],
    ];
    let mut strip = Strip::default();
    let mut add = |caption: &str, betas: &[f64], pose: &[DMat3], from: DVec3, width: usize| {
        let skin = model.evaluate(betas, pose, DVec3::ZERO);
        // The root stays where it is when the legs bend: the feet are put back on the floor.
        let sole = skin.iter().map(|p| p.y).fold(f64::MAX, f64::min);
        let skin = skin.into_iter().map(|p| p - sole * DVec3::Y).collect();
        strip.panels.push(Panel {
            image: panel(skin, &model, from, width),
            caption: caption.into(),
        });
    };
    add("rest", &[], &rest, front, 345);
    add("behind", &[], &standing, back, 165);
    add("walking", &[], &walking, side, 205);
    add("sitting", &[], &sitting, side, 205);
    for betas in &people {
        add("shaped", betas, &standing, side, 155);
    }
    strip.compose(from_srgb(0xf4f2ee)).write_png(path.as_ref())
}
