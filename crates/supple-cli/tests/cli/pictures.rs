//! What the rasteriser draws.

use supple::collider::Shape;
use supple::glam::{DMat3, DVec3};
use supple::model::{Frame, Surface};
use supple_pictures::{
    Camera, ColourScale, Legend, Mesh, Panel, Plane, Projection, Strip, View, colour_map,
    from_srgb, render,
};

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
            scale: ColourScale::up_to(50.0),
        }),
        ..Strip::default()
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

/// An orthographic picture of a ball, 100 pixels across, 0.1 m high.
fn ball_view() -> (Mesh, View) {
    let camera = Camera {
        eye: DVec3::new(0.0, -1.0, 0.6),
        target: DVec3::ZERO,
        up: DVec3::Z,
        projection: Projection::Orthographic(0.1),
    };
    let ball = sphere(DVec3::ZERO, 0.02, 0xb03030);
    (ball, View::new(camera, 100, 100))
}

#[test]
fn a_ball_covers_its_disc() {
    let (ball, view) = ball_view();
    let image = render(&[ball], &view);
    let red = |p: &&[u8; 3]| i32::from(p[0]) > i32::from(p[1]) + 30;
    let covered = image.pixels.iter().filter(red).count() as f64;
    let expected = std::f64::consts::PI * 20.0f64.powi(2);
    assert!(
        (covered / expected - 1.0).abs() < 0.05,
        "{covered} of {expected}"
    );
    let luminance = |x: usize, y: usize| {
        let p = image.pixels[y * 100 + x];
        p.iter().map(|c| i32::from(*c)).sum::<i32>()
    };
    assert!(
        luminance(44, 42) > luminance(58, 62) + 60,
        "light from the upper left"
    );
}

#[test]
fn a_floor_shows_shadow_and_nothing_else() {
    let (ball, view) = ball_view();
    let plain = render(std::slice::from_ref(&ball), &view);
    let floor = Some(-0.021);
    let shadowed = render(&[ball], &View { floor, ..view });
    let darker = |(a, b): (&[u8; 3], &[u8; 3])| i32::from(a[1]) - i32::from(b[1]);
    let change: Vec<i32> = plain
        .pixels
        .iter()
        .zip(&shadowed.pixels)
        .map(darker)
        .collect();
    assert!(change.iter().all(|d| *d >= -1), "a floor never brightens");
    assert!(
        change.iter().any(|d| *d > 25),
        "the ball stands in its shadow"
    );
    assert!(
        change.iter().filter(|d| **d == 0).count() > 2000,
        "far away there is none"
    );
}

#[test]
fn a_cut_shows_the_inside_in_its_own_colour() {
    let (ball, view) = ball_view();
    let plane = Plane {
        point: DVec3::new(0.0, -0.01, 0.0),
        normal: -DVec3::Y,
    };
    let view = View {
        clip: Some(plane),
        ..view
    };
    let blue = |meshes: &[Mesh]| {
        let image = render(meshes, &view);
        let blue = |p: &&[u8; 3]| i32::from(p[2]) > i32::from(p[0]) + 30;
        image.pixels.iter().filter(blue).count() as f64
    };
    assert_eq!(
        blue(std::slice::from_ref(&ball)),
        0.0,
        "what has no cut colour stays whole"
    );
    // The disc of radius √(20² − 10²) mm, seen at an angle.
    let slant = (DVec3::new(0.0, 1.0, -0.6).normalize()).y;
    let expected = std::f64::consts::PI * (400.0 - 100.0) * slant;
    let found = blue(&[ball.opened(from_srgb(0x3060d0))]);
    assert!(
        (found / expected - 1.0).abs() < 0.06,
        "{found} of {expected}"
    );
}
