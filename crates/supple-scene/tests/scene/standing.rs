//! Where an avatar stands in a scene: up of its file, of the world and of a motion, and the placement.

use crate::support::{SMALL, full_space_limb};
use std::path::Path;
use std::sync::Arc;
use supple::glam::{DMat3, DVec3};
use supple::internal::math::rotation_exp;
use supple::model::{Avatar, Frame, UpAxis};
use supple::potential::CpuPotential;
use supple::sim::Simulation;
use supple_scene::{AvatarSource, Driver, Scene, parse_avatar_source, parse_scene};

fn scene(keys: &str) -> Scene {
    let text = format!("name = \"limb\"\nsteps = 9\n{keys}\n[avatar]\nsample = \"limb_s\"\n");
    parse_scene(&text, Path::new("scene.toml")).unwrap()
}

/// A limb whose file has `up` up, its joints off the origin.
fn limb(up: UpAxis) -> Arc<Avatar> {
    let mut avatar = full_space_limb(&SMALL, 2, true);
    let shift = DVec3::new(0.1, 0.9, 0.05);
    avatar.skeleton.joints.iter_mut().for_each(|j| *j += shift);
    let points = avatar.skin.position.iter_mut();
    let points = points.chain(&mut avatar.cubature.position);
    let points = points.chain(&mut avatar.handles);
    points
        .chain(&mut avatar.layer.mesh.nodes)
        .for_each(|x| *x += shift);
    avatar.up = up;
    Arc::new(avatar)
}

/// Where bones are as `scene` begins, and its gravity.
fn start(scene: &Scene, avatar: &Arc<Avatar>) -> (Vec<Frame>, DVec3) {
    let potential = CpuPotential::new(avatar.clone(), 1).unwrap();
    let mut simulation = Simulation::new(avatar, potential, scene.settings).unwrap();
    let instance = &mut simulation.instances_mut()[0];
    let mut driver = Driver::new(scene, avatar).unwrap();
    driver.start(avatar, instance);
    driver.drive(0.01, instance).unwrap();
    (instance.state.frames.clone(), instance.gravity)
}

#[test]
fn what_stands_along_another_axis_is_stood_up_about_its_files_origin() {
    let avatar = limb(UpAxis::Y);
    let (frames, gravity) = start(&scene(""), &avatar);
    assert_eq!(gravity, DVec3::new(0.0, 0.0, -9.81));
    for (frame, joint) in frames.iter().zip(&avatar.skeleton.joints) {
        assert_eq!(frame.position, DVec3::new(joint.x, -joint.z, joint.y));
        assert_eq!(frame.rotation * DVec3::Y, DVec3::Z);
    }
    let (frames, gravity) = start(&scene("up = \"y\""), &avatar);
    assert_eq!(gravity, DVec3::new(0.0, -9.81, 0.0));
    assert_eq!(frames, avatar.skeleton.bind_pose());
}

#[test]
fn placements_turn_about_the_files_origin_and_then_move() {
    let avatar = limb(UpAxis::Y);
    let text = "placement = { rotation_degrees = [0, 0, 30], position = [1, 2, 3] }";
    let (frames, _) = start(&scene(text), &avatar);
    let turn = rotation_exp(DVec3::Z * 30f64.to_radians());
    for (frame, joint) in frames.iter().zip(&avatar.skeleton.joints) {
        let stood = DVec3::new(joint.x, -joint.z, joint.y);
        let wanted = turn * stood + DVec3::new(1.0, 2.0, 3.0);
        assert!(frame.position.distance(wanted) < 1e-15);
    }
}

#[test]
fn a_world_says_its_up_or_its_gravity_does() {
    let up = |keys: &str| scene(keys).up();
    assert_eq!(up(""), UpAxis::Z);
    assert_eq!(up("gravity = [0, 0, 0]"), UpAxis::Z);
    assert_eq!(up("gravity = [1, -9.7, -1]"), UpAxis::Y);
    assert_eq!(up("gravity = [0, 0, 9.81]"), UpAxis::Z);
    assert_eq!(up("up = \"x\"\ngravity = [0, -9.7, 0]"), UpAxis::X);
    assert_eq!(scene("up = \"x\"").gravity(), DVec3::new(-9.81, 0.0, 0.0));
    // The camera looks a little down, whatever down is.
    for axis in ["x", "y", "z"] {
        let scene = scene(&format!("up = \"{axis}\""));
        assert_eq!(scene.output.view.dot(scene.up().direction()), -0.5);
    }
}

/// Poses that state no axes are away from the bind pose as it stands.
#[test]
fn a_stream_of_no_axes_turns_what_stands() {
    let folder = tempfile::tempdir().unwrap();
    let avatar = limb(UpAxis::Y);
    let root = &avatar.skeleton.names[0];
    let path = folder.path().join("still.jsonl");
    let line =
        format!("{{\"time\": 0, \"bones\": {{\"{root}\": {{\"rotation\": [0, 0, 0, 1]}}}}}}\n");
    std::fs::write(&path, line).unwrap();
    let mut scene = scene("");
    scene.motion = Some(supple_scene::TrackedMotion {
        ease_in: 0.0,
        ..supple_scene::TrackedMotion::of_file(path)
    });
    let (frames, _) = start(&scene, &avatar);
    let stood = UpAxis::Y.rotation_to(UpAxis::Z);
    let off = |m: DMat3| {
        m.to_cols_array()
            .iter()
            .fold(0.0, |a: f64, b| a.max(b.abs()))
    };
    assert!(off(frames[0].rotation - stood) < 1e-15);
    let joint = avatar.skeleton.joints[0];
    assert!(frames[0].position.distance(stood * joint) < 1e-15);
}

#[test]
fn a_recipe_says_what_is_up_in_its_file() {
    let read = |text: &str| parse_avatar_source(text, Path::new("recipe.toml"));
    let up = |text: &str| read(text).unwrap().body().unwrap().0.up;
    assert_eq!(up("sample = \"limb_s\""), UpAxis::Z);
    assert_eq!(up("sample = \"limb_s\"\nup = \"x\""), UpAxis::X);
    let source = read("sample = \"limb_s\"\nup = \"x\"").unwrap();
    assert_eq!(read(&source.to_toml().unwrap()).unwrap(), source);
    let baked = read("file = \"a.supple\"\nup = \"x\"").unwrap_err();
    assert!(baked.to_string().contains("avatar.up"), "{baked}");
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("tri.obj");
    std::fs::write(&path, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    let source: AvatarSource = supple_scene::CharacterSource::new(path).into();
    assert_eq!(source.body().unwrap().0.up, UpAxis::Z);
}
