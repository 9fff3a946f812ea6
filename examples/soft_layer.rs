//! Meshes the soft layer of a character file, tells what was found, and draws it: the skin coloured by the
//! depth of the layer (dark is thin), and the tets behind a plane, cut open.
//!
//! `cargo run --release --example soft_layer -- CHARACTER PICTURE.png [x|y|z [0..1]]`

use std::path::Path;
use supple::glam::DVec3;
use supple::model::{Surface, TetMesh};
use supple_bake::{Body, Mesher, Softness};
use supple_files::{CharacterOptions, read_character};
use supple_pictures::{Camera, Mesh, Plane, View, colour_map, from_srgb, render};

fn main() -> supple::Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [file, picture, rest @ ..] = arguments.as_slice() else {
        println!("soft_layer CHARACTER PICTURE.png [x|y|z [0..1]]");
        return Ok(());
    };
    let mut body = read_character(file, &CharacterOptions::default())?.body;
    let start = std::time::Instant::now();
    let report = Mesher::Auto.mesh(&mut body)?;
    println!(
        "{}: {}, {:.2} s",
        body.name,
        report.mesher,
        start.elapsed().as_secs_f64()
    );
    println!("skin: {}", report.skin);
    println!("layer: {}", report.quality);
    let litres = [report.skin_volume, report.tissue_volume, report.core_volume].map(|v| 1e3 * v);
    println!("volumes of skin, tissue and core: {litres:.3?} l");
    println!("thickness: {:.2?} mm", report.thickness.map(|t| 1e3 * t));
    println!(
        "bare vertices: {}, derived bones: {}",
        report.bare_vertices, report.derived_bones
    );

    let axis = match rest.first().map(String::as_str) {
        Some("x") => DVec3::X,
        Some("y") => DVec3::Y,
        _ => DVec3::Z,
    };
    let at = rest
        .get(1)
        .and_then(|text| text.parse().ok())
        .unwrap_or(0.5);
    render(&[depths(&body)], &view(&body, DVec3::NEG_Z))
        .write_png(Path::new(&picture.replace(".png", "_depth.png")))?;
    let positions = || body.skin.positions.iter().copied();
    let low = positions().fold(DVec3::INFINITY, DVec3::min);
    let high = positions().fold(DVec3::NEG_INFINITY, DVec3::max);
    let plane = Plane {
        point: low.lerp(high, at),
        normal: axis,
    };
    // Looking down on the cut, a little from the side.
    let direction = -axis + 0.15 * DVec3::new(0.3, -0.5, 0.4);
    render(&[behind(&body, &plane)], &view(&body, direction)).write_png(Path::new(picture))
}

fn view(body: &Body, direction: DVec3) -> View {
    let up = if direction.y.abs() > 0.8 {
        DVec3::NEG_Z
    } else {
        DVec3::Y
    };
    let camera = Camera::framing(&body.skin.positions, direction, up, 1.0);
    View::new(camera, 1100, 1100)
}

/// The skin, dark where its layer is thin.
fn depths(body: &Body) -> Mesh {
    let softness = Softness::of(body);
    let colours = softness.softness.iter().map(|&s| colour_map(s)).collect();
    Mesh::coloured(body.skin.clone(), colours)
}

/// The tets behind `plane`, faceted: the inner surface dark, what was cut light.
fn behind(body: &Body, plane: &Plane) -> Mesh {
    let layer = &body.layer;
    let kept = |t: &usize| plane.distance(layer.mesh.centroid(*t)) <= 0.0;
    let part = TetMesh {
        nodes: layer.mesh.nodes.clone(),
        tets: (0..layer.mesh.tets.len())
            .filter(kept)
            .map(|t| layer.mesh.tets[t])
            .collect(),
    };
    let mut surface = Surface::default();
    let mut colours = Vec::new();
    for triangle in part.boundary_triangles() {
        let held = triangle
            .iter()
            .all(|&n| layer.bone_of_node[n as usize].is_some());
        let first = surface.positions.len() as u32;
        for n in triangle {
            surface.positions.push(part.nodes[n as usize]);
            colours.push(from_srgb(if held { 0x8a4f3d } else { 0xe8b79b }));
        }
        surface.triangles.push([first, first + 1, first + 2]);
    }
    Mesh::coloured(surface, colours)
}
