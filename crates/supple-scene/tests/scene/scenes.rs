//! Scene files: what they say is what is read, and what they must not say is refused by name.

use std::path::Path;
use supple::collider::Shape;
use supple::glam::DVec3;
use supple::sim::SolverMode;
use supple_samples::Sample;
use supple_scene::{Scene, parse_scene, read_scene};

const FOLDER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../assets/scenes");

#[test]
fn every_committed_scene_is_valid() {
    let mut count = 0;
    for entry in std::fs::read_dir(FOLDER).unwrap() {
        let path = entry.unwrap().path();
        let scene = read_scene(&path).unwrap();
        assert_eq!(path.file_stem().unwrap(), scene.name.as_str());
        let times = scene.output.panels.iter().map(|p| p.time);
        assert!(
            times.clone().count() >= 3,
            "{}: rest, press, release",
            scene.name
        );
        assert!(times.clone().any(|t| t == scene.measure.full_press) || scene.name == "hand_press");
        count += 1;
    }
    assert!(count >= 3);
}

#[test]
fn the_bone_press_is_the_benchmark() {
    let scene = read_scene(Path::new(FOLDER).join("bone_press_s.toml")).unwrap();
    assert_eq!(scene.avatar.sample(), Some(Sample::LimbS));
    assert_eq!((scene.steps, scene.settings.time_step), (250, 0.01));
    assert_eq!(scene.settings.solver, SolverMode::BUDGETED);
    assert_eq!(scene.gravity(), DVec3::new(0.0, 0.0, -9.81));
    let ball = &scene.colliders[0];
    assert_eq!(*ball.shape, Shape::Sphere { radius: 0.03 });
    assert_eq!((ball.stiffness, ball.margin), (Some(1e8), 0.0));
    let z = |t: f64| ball.motion.at(t).position.z;
    assert_eq!((z(0.0), z(1.2), z(2.5)), (0.075, 0.058, 0.098));
    assert!((z(0.5) - 0.0665).abs() < 1e-15, "half way down");
    assert_eq!(scene.step_at(1.0), 100);
}

fn good() -> String {
    std::fs::read_to_string(Path::new(FOLDER).join("bone_press_s.toml")).unwrap()
}

fn parse(text: &str) -> Result<Scene, supple::Error> {
    parse_scene(text, Path::new("scene.toml"))
}

#[test]
fn what_is_wrong_is_named() {
    let cases = [
        (
            "steps = 250",
            "steps = 250\nsteeps = 3",
            "line 4: unknown field `steeps`",
        ),
        ("steps = 250", "steps = 0", "steps: must be 1"),
        ("steps = 250", "steps = many", "line 3: "),
        (
            "time_step = 0.01",
            "time_step = nan",
            "settings.time_step: is not a finite",
        ),
        (
            "time_step = 0.01",
            "time_step = -0.01",
            "settings.time_step: ",
        ),
        (
            "1.0, 0.100",
            "1.0, inf",
            "colliders[0].motion.x[0][1]: is not a finite",
        ),
        (
            "1.0, 0.100",
            "1.6, 0.100",
            "colliders[0].motion.x: the keys' times must rise",
        ),
        ("radius = 0.03", "radius = -0.03", "colliders[0].shape"),
        ("radius = 0.03", "radius = 0.03, colour = 3", "colour"),
        ("shape = \"sphere\"", "shape = \"cone\"", "cone"),
        (
            "time_step = 0.01",
            "time_step = 0.01\nsolver = { mode = \"magic\" }",
            "magic",
        ),
        ("sample = \"limb_s\"", "", "needs exactly one of"),
        (
            "sample = \"limb_s\"",
            "sample = \"limb_s\"\nfile = \"a.supple\"",
            "has file, sample",
        ),
        (
            "full_press = 1.0",
            "full_press = 9.0",
            "measure.full_press: must lie within",
        ),
        (
            "name = \"bone_press_s\"",
            "name = \"../x\"",
            "name: names a folder",
        ),
        ("stiffness = 1e8", "stiffness = 0", "colliders[0].stiffness"),
    ];
    for (from, to, expected) in cases {
        let text = good();
        assert!(text.contains(from), "{from}");
        let error = parse(&text.replacen(from, to, 1)).unwrap_err().to_string();
        assert!(error.starts_with("scene.toml: "), "{error}");
        assert!(error.contains(expected), "{to}: {error}");
    }
}

#[test]
fn a_scene_survives_serialisation() {
    let scene = parse(&good()).unwrap();
    let text = toml::to_string(&scene).unwrap();
    assert_eq!(parse(&text).unwrap(), scene);
}

#[test]
fn a_scene_needs_a_name_steps_and_an_avatar_only() {
    let text = "name = \"short\"\nsteps = 50\n[avatar]\nsample = \"finger\"\n";
    let scene = parse_scene(text, Path::new("short.toml")).unwrap();
    assert_eq!(scene.measure.full_press, scene.duration());
    let times: Vec<f64> = scene.output.panels.iter().map(|p| p.time).collect();
    assert_eq!(times, [0.0, scene.duration()]);
}

#[test]
fn text_alone_has_no_meshes() {
    let ball = "shape = \"sphere\", radius = 0.03";
    let text = good().replacen(ball, "shape = \"mesh\", file = \"cubes.obj\"", 1);
    let error = parse(&text).unwrap_err().to_string();
    for hint in [
        "scene.toml",
        "colliders[0].shape",
        "cubes.obj",
        "read_scene",
    ] {
        assert!(error.contains(hint), "{error:?} lacks {hint:?}");
    }
    let body =
        "\n[[bodies]]\nname = \"cubes\"\nshape = { shape = \"mesh\", file = \"cubes.obj\" }\n";
    let error = parse(&(good() + body)).unwrap_err().to_string();
    for hint in ["scene.toml", "bodies[0]", "cubes.obj", "read_scene"] {
        assert!(error.contains(hint), "{error:?} lacks {hint:?}");
    }
}

/// A mesh lies beside the scene; its objects are one solid, and what is wrong with it is named.
#[test]
fn a_scene_reads_its_mesh() {
    let folder = tempfile::tempdir().unwrap();
    let cubes = |open: bool| {
        let mut text = String::new();
        for (k, x) in [-0.05, 0.05].into_iter().enumerate() {
            text += &format!("o cube{k}\n");
            for corner in 0..8 {
                let side = |bit: i32| 0.02 * f64::from(2 * (corner >> bit & 1) - 1);
                text += &format!("v {} {} {}\n", x + side(0), side(1), side(2));
            }
            let faces = [
                "1 3 4 2", "5 6 8 7", "1 2 6 5", "3 7 8 4", "1 5 7 3", "2 4 8 6",
            ];
            for face in &faces[usize::from(open)..] {
                let corners = face.split(' ').map(|c| c.parse::<usize>().unwrap() + 8 * k);
                let corners: Vec<String> = corners.map(|c| c.to_string()).collect();
                text += &format!("f {}\n", corners.join(" "));
            }
        }
        text
    };
    let mesh = folder.path().join("cubes.obj");
    std::fs::write(&mesh, cubes(false)).unwrap();
    let path = folder.path().join("bone_press_s.toml");
    let ball = "shape = \"sphere\", radius = 0.03";
    assert!(good().contains(ball));
    let text = good().replacen(ball, "shape = \"mesh\", file = \"cubes.obj\"", 1);
    std::fs::write(&path, text).unwrap();
    let scene = read_scene(&path).unwrap();
    let shape = &scene.colliders[0].shape;
    shape.validate().unwrap();
    let distance = |x: f64, z: f64| shape.signed_distance(DVec3::new(x, 0.0, z)).distance;
    for x in [-0.05, 0.05] {
        // Above a face the interpolated distance is exact, but for f32.
        assert!((distance(x, 0.025) - 0.005).abs() < 1e-8);
        assert!((distance(x, 0.017) + 0.003).abs() < 1e-8);
    }
    assert!(
        (distance(0.0, 0.0) - 0.03).abs() < 5e-3,
        "between the cubes"
    );
    std::fs::write(&mesh, cubes(true)).unwrap();
    let error = read_scene(&path).unwrap_err().to_string();
    assert!(error.contains("cubes.obj"), "{error}");
    std::fs::remove_file(&mesh).unwrap();
    let error = read_scene(&path).unwrap_err().to_string();
    assert!(error.contains("cubes.obj"), "{error}");
}
