//! An avatar that no scene was written for.

use crate::support::{SMALL, full_space_limb};
use std::path::Path;
use std::sync::Arc;
use supple::collider::Shape;
use supple::glam::{DQuat, DVec3};
use supple::internal::cpu::posed_skin;
use supple::model::{Avatar, UpAxis};
use supple::potential::CpuPotential;
use supple::sim::Simulation;
use supple_files::{MotionClip, MotionFrame, bvh_text};
use supple_scene::{
    AvatarSource, Driver, Scene, SceneRun, Showing, TrackedMotion, parse_scene, run_scene,
};

fn limb(up: UpAxis) -> Arc<Avatar> {
    let mut avatar = full_space_limb(&SMALL, 2, true);
    avatar.up = up;
    Arc::new(avatar)
}

fn scene() -> Scene {
    Scene::of_avatar(
        "a limb",
        AvatarSource::of_sample(supple_samples::Sample::LimbS),
    )
}

fn run(scene: &Scene, avatar: &Arc<Avatar>) -> SceneRun {
    let potential = CpuPotential::new(avatar.clone(), 1).unwrap();
    let mut simulation = Simulation::new(avatar, potential, scene.settings).unwrap();
    run_scene(scene, avatar, &mut simulation, &mut |_| {}).unwrap()
}

/// Height of the ground, and the least height of the skin where the bones are led to.
fn heights(scene: &Scene, avatar: &Arc<Avatar>) -> (f64, f64) {
    let up = scene.up().direction();
    let ground = scene
        .colliders
        .iter()
        .find(|c| *c.shape == Shape::HalfSpace);
    let ground = ground.unwrap().motion.at(0.0);
    assert_eq!(
        (ground.rotation * DVec3::Z).dot(up),
        1.0,
        "its outside is up"
    );
    let potential = CpuPotential::new(avatar.clone(), 1).unwrap();
    let mut simulation = Simulation::new(avatar, potential, scene.settings).unwrap();
    let instance = &mut simulation.instances_mut()[0];
    let mut driver = Driver::new(scene, avatar).unwrap();
    driver.start(avatar, instance);
    let mut low = f64::INFINITY;
    for step in 1..=scene.steps {
        let time = scene.settings.time_step * step as f64;
        driver.drive(time, instance).unwrap();
        let mut state = avatar.rest_state();
        let pins = instance.pins.iter().map(|p| (p.bone, p.frame));
        let targets = instance.targets.iter().map(|t| (t.bone, t.frame));
        for (bone, frame) in pins.chain(targets) {
            state.frames[bone] = frame;
        }
        let skin = posed_skin(avatar, &state).positions;
        low = skin.iter().map(|p| p.dot(up)).fold(low, f64::min);
    }
    (ground.position.dot(up), low)
}

#[test]
fn what_nothing_moves_is_shaken_on_its_ground() {
    for up in [UpAxis::X, UpAxis::Y, UpAxis::Z] {
        let avatar = limb(up);
        let mut scene = scene();
        assert!(scene.is_idle());
        let showing = scene.show(&avatar, None, None).unwrap();
        assert!(!scene.is_idle());
        let Showing::Shaken { seconds } = showing else {
            panic!("{showing:?}")
        };
        assert!((1.0..4.0).contains(&seconds), "{seconds} s");
        let (ground, low) = heights(&scene, &avatar);
        assert!((ground - low).abs() < 1e-12, "{ground} m, {low} m");
    }
    let avatar = limb(UpAxis::Z);
    let mut scene = scene();
    scene.show(&avatar, None, None).unwrap();
    let run = run(&scene, &avatar);
    assert!(
        run.report.max_unposed_displacement_mm > 0.1,
        "{:?}",
        run.report
    );
    assert!(run.report.det_f() > 0.2, "{:?}", run.report);
    let frames = run.recording.states.iter().map(|s| s.frames[0].position);
    let moved = frames
        .clone()
        .map(|p| p.distance(run.recording.states[0].frames[0].position));
    assert!(moved.fold(0.0, f64::max) > 1e-3, "the bones are carried");
    assert_eq!(run.snapshots.len(), scene.output.panels.len());
    let gap = scene.output.panels[1].time - scene.output.panels[0].time;
    assert!((gap - 0.05).abs() < 1e-12, "20 a second");
}

/// Bends the second bone down by and by, and sinks.
fn sinking(avatar: &Avatar, folder: &Path) -> TrackedMotion {
    let character = avatar.character();
    let turn = |k: usize| DQuat::from_rotation_y(0.02 * k as f64);
    let frame = |k: usize| MotionFrame {
        rotations: vec![DQuat::IDENTITY, turn(k)],
        translations: vec![-0.002 * k as f64 * DVec3::Z],
    };
    let clip = MotionClip {
        name: "sinking".into(),
        bones: character.names.clone(),
        parents: character.parents.clone(),
        rest_joints: Some(character.joints.clone()),
        frame_time: 0.05,
        translated: vec![0],
        frames: (0..=30).map(frame).collect(),
        world_up: UpAxis::Z,
        rest_up: UpAxis::Z,
        ..MotionClip::default()
    };
    let path = folder.join("sinking.bvh");
    std::fs::write(&path, bvh_text(&clip)).unwrap();
    TrackedMotion {
        up: Some(UpAxis::Z),
        ..TrackedMotion::of_file(path)
    }
}

#[test]
fn a_clip_is_played_above_a_ground_that_its_lowest_pose_reaches() {
    let folder = tempfile::tempdir().unwrap();
    let avatar = limb(UpAxis::Z);
    let mut scene = scene();
    let motion = sinking(&avatar, folder.path());
    let showing = scene.show(&avatar, Some(motion), None).unwrap();
    assert!(
        matches!(showing, Showing::Follows { seconds, .. } if (seconds - 1.5).abs() < 1e-9),
        "{showing:?}"
    );
    let (ground, low) = heights(&scene, &avatar);
    // Poses are looked at 20 times a second: between two of them the clip sinks less than 4 mm.
    assert!((ground - low).abs() < 4e-3, "{ground} m, {low} m");
    scene.show(&avatar, None, Some(0.0)).unwrap_err();
}

#[test]
fn a_scene_with_anything_in_it_is_not_idle() {
    let text = |keys: &str| {
        let text = format!("name = \"limb\"\nsteps = 9\n[avatar]\nsample = \"limb_s\"\n{keys}");
        parse_scene(&text, Path::new("scene.toml")).unwrap()
    };
    assert!(text("").is_idle());
    assert!(!text("[[pins]]\nbone = \"bone\"\n").is_idle());
    let ball = "[[colliders]]\nname = \"ball\"\nshape = { shape = \"sphere\", radius = 0.03 }\n";
    assert!(!text(ball).is_idle());
}

/// The tissue feels no push where a clip begins at speed.
#[test]
fn a_clip_begins_as_fast_as_it_goes_on() {
    let folder = tempfile::tempdir().unwrap();
    let avatar = limb(UpAxis::Z);
    let mut scene = scene();
    scene.gravity = Some(DVec3::ZERO);
    let motion = sinking(&avatar, folder.path());
    scene.show(&avatar, Some(motion), None).unwrap();
    scene.colliders.clear();
    let pushed = |at_rest: bool| {
        let potential = CpuPotential::new(avatar.clone(), 1).unwrap();
        let mut simulation = Simulation::new(&avatar, potential, scene.settings).unwrap();
        let mut driver = Driver::new(&scene, &avatar).unwrap();
        let instance = &mut simulation.instances_mut()[0];
        driver.start(&avatar, instance);
        if !at_rest {
            driver.launch(&avatar, instance);
        }
        driver.drive(scene.settings.time_step, instance).unwrap();
        simulation.step_blocking().unwrap();
        let handles = &simulation.instances()[0].state.handles;
        handles.iter().map(|u| u.length()).fold(0.0, f64::max)
    };
    let (moving, at_rest) = (pushed(false), pushed(true));
    assert!(moving < 0.2 * at_rest, "{moving} m, {at_rest} m");
}

/// The camera looks down a little, whatever is up.
#[test]
fn it_is_looked_at_from_above() {
    for up in ["x", "y", "z"] {
        let text =
            format!("name = \"a\"\nsteps = 9\nup = \"{up}\"\n[avatar]\nsample = \"limb_s\"\n");
        let mut scene = parse_scene(&text, Path::new("scene.toml")).unwrap();
        scene.show(&limb(UpAxis::Z), None, None).unwrap();
        let down = scene.output.view.dot(scene.up().direction());
        assert_eq!(down, -0.15, "{up}");
    }
}

/// It leans forward by a degree about its soles and comes back to where it began, where it may begin again.
#[test]
fn who_stands_sways_about_the_soles_and_ends_as_it_began() {
    for up in [UpAxis::X, UpAxis::Y, UpAxis::Z] {
        let avatar = limb(up);
        let mut scene = scene();
        let sway = scene.stand(&avatar);
        assert!(!scene.is_idle() && (scene.duration() - sway).abs() < 1e-9);
        let (ground, low) = heights(&scene, &avatar);
        assert!((low - ground).abs() < 0.005, "{low} m above {ground} m");
        let start = avatar.placed(&avatar.standing(scene.up()));
        let mut farthest = 0.0f64;
        for target in &scene.targets {
            let bone = avatar.skeleton.find(&target.bone).unwrap();
            let there = target.motion.at(0.5 * sway);
            // Rigidly: bones keep their distances.
            let place = |k: usize, at: f64| {
                let moved = scene.targets[k].motion.at(at).position;
                start.frames[k].position + moved
            };
            let apart = |at: f64| place(bone, at).distance(place(0, at));
            assert!((apart(0.0) - apart(0.5 * sway)).abs() < 1e-4 * (apart(0.0) + 0.1));
            let turn = there
                .rotation
                .x_axis
                .dot(DVec3::X)
                .acos()
                .max(there.rotation.z_axis.dot(DVec3::Z).acos());
            assert!((0.01..0.04).contains(&turn), "{turn} rad");
            farthest = farthest.max(there.position.length());
            for ends in [0.0, sway] {
                assert_eq!(target.motion.at(ends).position, DVec3::ZERO);
            }
        }
        assert!(farthest > 1e-4, "{farthest} m");
    }
}
