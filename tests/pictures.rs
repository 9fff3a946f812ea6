//! What the rasteriser draws.

use supple::collider::Shape;
use supple::export::{
    Camera, Legend, Mesh, Panel, Plane, Strip, View, colour_map, from_srgb, render,
};
use supple::glam::{DMat3, DVec3};
use supple::model::{Frame, Surface};

/// A torus about z, coloured by height.
fn torus() -> Mesh {
    let (around, across) = (96u32, 48u32);
    let mut surface = Surface::default();
    for i in 0..around {
        for j in 0..across {
            let u = std::f64::consts::TAU * f64::from(i) / f64::from(around);
            let v = std::f64::consts::TAU * f64::from(j) / f64::from(across);
            let r = 0.06 + 0.025 * v.cos();
            surface
                .positions
                .push(DVec3::new(r * u.cos(), r * u.sin(), 0.025 * v.sin()));
            let at = |i: u32, j: u32| (i % around) * across + j % across;
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i, j + 1), at(i + 1, j + 1)];
            surface.triangles.extend([[a, b, d], [a, d, c]]);
        }
    }
    let colours = surface
        .positions
        .iter()
        .map(|p| colour_map((p.z + 0.025) / 0.05))
        .collect();
    Mesh::coloured(surface, colours)
}

fn sphere(centre: DVec3, radius: f64, colour: u32) -> Mesh {
    let frame = Frame {
        rotation: DMat3::IDENTITY,
        position: centre,
    };
    Mesh::collider(&Shape::Sphere { radius }, &frame, 1.0, from_srgb(colour))
}

fn view(meshes: &[Mesh], width: usize, height: usize) -> View {
    let points: Vec<DVec3> = meshes
        .iter()
        .flat_map(|m| m.surface.positions.clone())
        .collect();
    let direction = DVec3::new(-0.5, 1.0, -0.7);
    let camera = Camera::framing(&points, direction, DVec3::Z, width as f64 / height as f64);
    View {
        floor: Some(-0.025),
        ..View::new(camera, width, height)
    }
}

/// Writes `torus_and_sphere.png` into the directory named by `SUPPLE_PICTURES`, if it is set.
#[test]
fn a_strip_shows_shape_shadow_cut_and_legend() {
    let mut meshes = vec![torus(), sphere(DVec3::Z * 0.0, 0.022, 0xb9c4d0)];
    let whole = view(&meshes, 480, 400);
    meshes[0].cut = Some(from_srgb(0xd98a7b));
    meshes.push(sphere(DVec3::new(0.0, -0.06, 0.0), 0.012, 0xf3ead2).opened(from_srgb(0xe9d9b0)));
    let plane = Plane {
        point: DVec3::new(0.0, -0.055, 0.0),
        normal: -DVec3::Y,
    };
    let opened = View {
        clip: Some(plane),
        ..whole.clone()
    };
    let strip = Strip {
        panels: vec![
            Panel {
                image: render(&meshes, &whole),
                caption: "whole".into(),
            },
            Panel {
                image: render(&meshes, &opened),
                caption: "cut open (µm, ν = 0.4)".into(),
            },
        ],
        legend: Some(Legend {
            title: "height (mm)".into(),
            maximum: 50.0,
        }),
    };
    let sheet = strip.compose(whole.background);
    if let Some(directory) = std::env::var_os("SUPPLE_PICTURES") {
        sheet
            .write_png(&std::path::Path::new(&directory).join("torus_and_sphere.png"))
            .unwrap();
    }
    let image = &strip.panels[0].image;
    let luminance = |x: usize, y: usize| {
        image.pixels[y * 480 + x]
            .iter()
            .map(|c| u32::from(*c))
            .sum::<u32>()
    };
    assert!(luminance(3, 3) > 700, "the background is light");
    assert_ne!(
        strip.panels[0].image, strip.panels[1].image,
        "the cut opens the torus"
    );
    let again = render(&meshes, &whole);
    assert_eq!(again, strip.panels[0].image, "same input, same picture");
}
