//! Scenes whose bones follow a motion: what a run makes of it.

use crate::support::{SMALL, full_space_limb};
use std::path::Path;
use std::sync::Arc;
use supple::glam::{DMat3, DQuat, DVec3};
use supple::internal::math::{rotation_exp, rotation_log};
use supple::model::Avatar;
use supple::potential::CpuPotential;
use supple::sim::Simulation;
use supple_scene::{Driver, Scene, parse_scene, run_scene};

/// A scene of 0.6 s on a limb, with the keys `motion` in its `[motion]` table.
fn scene(motion: &str) -> Scene {
    let text = format!(
        "name = \"limb\"\nsteps = 60\ngravity = [0.0, 0.0, 0.0]\n[avatar]\nsample = \"limb_s\"\n\
         [measure]\nsettled = 0.1\nfull_press = 0.6\n[motion]\n{motion}"
    );
    parse_scene(&text, Path::new("scene.toml")).unwrap()
}

/// Targets that turn the second bone of the limb up and move the first, as JSON lines.
fn stream(avatar: &Avatar, folder: &Path, frames: usize) -> String {
    let (root, bone) = (&avatar.skeleton.names[0], &avatar.skeleton.names[1]);
    let lines = (0..frames).map(|k| {
        let time = 0.05 * k as f64;
        let turn = DQuat::from_rotation_y(-0.5 * time / 0.6);
        format!(
            "{{\"time\": {}, \"bones\": {{\"{root}\": {{\"position\": [0.02, 0, {}], \"rotation\": [0, 0, 0, 1]}}, \
             \"{bone}\": {{\"rotation\": [{}, {}, {}, {}]}}}}}}\n",
            7.0 + time,
            0.05 * time,
            turn.x,
            turn.y,
            turn.z,
            turn.w
        )
    });
    let path = folder.join("targets.jsonl");
    std::fs::write(&path, lines.collect::<String>()).unwrap();
    format!("file = {:?}\n", path.to_str().unwrap())
}

fn run(scene: &Scene, avatar: &Arc<Avatar>) -> supple::Result<supple_scene::SceneRun> {
    let reference = CpuPotential::new(avatar.clone(), 1)?;
    let mut simulation = Simulation::new(avatar, reference, scene.settings)?;
    run_scene(scene, avatar, &mut simulation, &mut |_| {})
}

fn limb() -> Arc<Avatar> {
    Arc::new(full_space_limb(&SMALL, 2, true))
}

#[test]
fn bones_follow_a_stream_and_nothing_leaps() {
    let folder = tempfile::tempdir().unwrap();
    let avatar = limb();
    let file = stream(&avatar, folder.path(), 13);
    let scene = scene(&format!("{file}ease_in = 0.2"));
    let run = run(&scene, &avatar).unwrap();
    assert_eq!(run.bone_map.unwrap().pairs, [(0, 0), (1, 1)]);
    let recorded = &run.recording;
    let end = recorded.states.last().unwrap();
    let wanted = rotation_exp(-0.5 * DVec3::Y);
    let turned = rotation_log(end.frames[1].rotation * wanted.transpose()).length();
    assert!(turned < 0.01, "{turned} rad");
    assert!((end.frames[0].position - DVec3::new(0.02, 0.0, 0.03)).length() < 1e-3);
    // The stream begins 2 cm away: eased in, that takes 0.15 m/s at most.
    for pair in recorded.states.windows(2) {
        let leap = (pair[1].frames[1].position - pair[0].frames[1].position).length();
        let turn =
            rotation_log(pair[1].frames[1].rotation * pair[0].frames[1].rotation.transpose());
        assert!(leap < 0.004 && turn.length() < 0.05, "{leap} m, {turn}");
    }
}

#[test]
fn a_root_may_be_pinned_held_or_left_alone() {
    let folder = tempfile::tempdir().unwrap();
    let avatar = limb();
    // The root starts in the stream's first pose.
    let file = stream(&avatar, folder.path(), 13) + "ease_in = 0.0\n";
    let place = |root: &str| {
        let run = run(&scene(&format!("{file}root = \"{root}\"")), &avatar).unwrap();
        run.recording.states.last().unwrap().frames[0].position
    };
    assert!((place("pin") - DVec3::new(0.02, 0.0, 0.03)).length() < 1e-12);
    assert!((place("hold") - 0.02 * DVec3::X).length() < 1e-4);
    assert!(
        (place("free") - 0.02 * DVec3::X).length() > 1e-4,
        "nothing keeps it where it was"
    );
}

#[test]
fn the_scene_s_own_pins_and_targets_go_first() {
    let folder = tempfile::tempdir().unwrap();
    let avatar = limb();
    let mut scene = scene(&stream(&avatar, folder.path(), 13));
    scene.pins.push(supple_scene::Pinned {
        bone: avatar.skeleton.names[1].clone(),
        motion: Default::default(),
    });
    let run = run(&scene, &avatar).unwrap();
    let end = run.recording.states.last().unwrap();
    assert_eq!(end.frames[1].rotation, DMat3::IDENTITY);
}

#[test]
fn what_is_wrong_is_said_before_the_first_step() {
    let folder = tempfile::tempdir().unwrap();
    let avatar = limb();
    let good = stream(&avatar, folder.path(), 2);
    let refused = |keys: &str, hint: &str| {
        let error = Driver::new(&scene(keys), &avatar)
            .err()
            .expect(keys)
            .to_string();
        assert!(error.contains(hint), "{error}");
    };
    refused("file = \"nowhere.bvh\"", "nowhere.bvh");
    refused("file = \"walk.mpg\"", ".bvh");
    refused(
        "file = \"../../assets/motions/walk.bvh\"",
        "could be mapped",
    );
    refused(&format!("{good}map = {{ nobody = \"x\" }}"), "nobody");
    refused(&format!("{good}loop = true"), "loop");
    let invalid = |keys: &str, hint: &str| {
        let text = format!(
            "name = \"limb\"\nsteps = 60\n[avatar]\nsample = \"limb_s\"\n[measure]\nsettled = 0.1\n\
             full_press = 0.6\n[motion]\n{keys}"
        );
        let error = parse_scene(&text, Path::new("scene.toml"))
            .unwrap_err()
            .to_string();
        assert!(error.contains(hint), "{error}");
    };
    invalid("speed = 1.0", "motion.file");
    invalid("file = \"a.bvh\"\nspeed = 0.0", "motion.speed");
    invalid("file = \"a.bvh\"\nunit = \"furlong\"", "motion.unit");
    invalid("file = \"a.bvh\"\nease_in = -1.0", "motion.ease_in");
    invalid("file = \"a.bvh\"\nspede = 1.0", "unknown field");
}
