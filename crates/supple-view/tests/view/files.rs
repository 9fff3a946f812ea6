//! Files that are dropped, and that are written.

use super::{alone, empty, keep, limb};
use supple::model::UpAxis;
use supple_samples::Sample;
use supple_view::{Command, Event, Request};

#[test]
fn what_cannot_be_shown_is_told_and_the_old_character_stays() {
    let _turn = alone();
    let Some(mut view) = limb(false) else { return };
    let folder = tempfile::tempdir().unwrap();
    let cases: [(&str, &[u8], &str); 4] = [
        ("unknown.fbx", b"Kaydara FBX Binary", "known are"),
        ("broken.glb", b"glTF\x02\0\0\0\xff\xff\0\0", "broken.glb"),
        ("empty.npz", b"", "is empty"),
        ("cut.supple", b"SUPPLE\r\n\x04", "cut.supple"),
    ];
    for (name, bytes, says) in cases {
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        view.handle(Event::Dropped(path));
        view.wait();
        let notice = view.app.notice().unwrap();
        assert!(
            notice.wrong && notice.text.contains(name),
            "{}",
            notice.text
        );
        assert!(notice.text.contains(says), "{}", notice.text);
        assert_eq!(view.app.stage().unwrap().character.name, "limb_s");
        view.run(0.05);
    }
    keep(&view.picture().unwrap(), "refused");
    assert!(view.app.stage().unwrap().time > 0.1);
}

#[test]
fn a_glb_of_the_last_seconds_and_a_recipe_are_written() {
    let _turn = alone();
    let Some(mut view) = limb(false) else { return };
    view.run(0.5);
    for command in [Command::WriteGlb, Command::WriteRecipe] {
        view.app.ask(command);
        view.run(0.02);
        let notice = view.app.notice().unwrap();
        assert!(!notice.wrong, "{}", notice.text);
    }
    let folder = super::cache().join("written");
    let written = std::fs::read(folder.join("limb_s.glb")).unwrap();
    let glb = gltf::Gltf::from_slice(&written).unwrap();
    assert_eq!(glb.animations().count(), 1);
    let recipe = supple_scene::read_avatar_source(folder.join("limb_s.toml")).unwrap();
    assert_eq!(recipe.sample(), Some(Sample::LimbS));
}

#[test]
fn a_dropped_motion_is_for_who_is_shown_and_begins_again() {
    let _turn = alone();
    let Some(mut view) = empty(false) else { return };
    view.show(Request::Sample(Sample::Finger)).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("bends.bvh");
    let names = view
        .app
        .stage()
        .unwrap()
        .character
        .avatar
        .skeleton
        .names
        .clone();
    let joint = |kind: &str, name: &str, inner: &str| {
        let channels = "CHANNELS 3 Zrotation Xrotation Yrotation";
        format!("{kind} {name}\n{{\nOFFSET 0 0 3\n{channels}\n{inner}}}\n")
    };
    let end = "End Site\n{\nOFFSET 0 0 3\n}\n".to_owned();
    let tree = names
        .iter()
        .enumerate()
        .rev()
        .fold(end, |inner, (k, name)| {
            joint(if k == 0 { "ROOT" } else { "JOINT" }, name, &inner)
        });
    let angle = |frame: usize| 30.0 * (0.2 * frame as f64).sin();
    let rows = (0..60).map(|k| format!("0 0 0 0 {0} 0 0 {0} 0\n", angle(k)));
    let rows: String = rows.collect();
    let text = format!("HIERARCHY\n{tree}MOTION\nFrames: 60\nFrame Time: 0.0333\n{rows}");
    std::fs::write(&path, text).unwrap();
    view.handle(Event::Dropped(path));
    view.wait();
    assert!(view.app.notice().is_none(), "{:?}", view.app.notice());
    let stage = view.app.stage().unwrap();
    assert_eq!(
        (stage.character.name.as_str(), stage.character.does.as_str()),
        ("finger", "follows bends.bvh")
    );
    let tip = |view: &super::Offscreen| {
        let stage = view.app.stage().unwrap();
        let frames = stage.world.instance(stage.me).unwrap().frames();
        frames[2].rotation.x_axis
    };
    let before = tip(&view);
    view.run(0.3);
    let turned = tip(&view).angle_between(before);
    assert!(turned > 0.2, "{turned} rad");
    view.app.ask(Command::Reset);
    view.run(0.01);
    view.app.pace.paused = true;
    assert!(tip(&view).angle_between(before) < 0.2 * turned);
}

/// A file of the Khronos group's, where it lies beside the project.
#[test]
fn a_dropped_glb_bakes_stands_on_the_ground_and_plays_its_clip() {
    let _turn = alone();
    let path = std::path::Path::new("../../../shared/assets/khronos-RiggedSimple.glb");
    if !path.exists() {
        println!("left out: {} is not there", path.display());
        return;
    }
    let Some(mut view) = empty(false) else { return };
    view.handle(Event::Dropped(path.into()));
    let nobody = view.picture().unwrap();
    view.wait();
    let stage = view.app.stage().unwrap();
    assert_eq!(stage.character.does, "plays its clip");
    let up = UpAxis::Z.direction();
    let lowest = |view: &super::Offscreen| {
        let skin = &view.app.stage().unwrap().shown.positions;
        skin.iter().map(|p| p.dot(up)).fold(f64::INFINITY, f64::min)
    };
    let ground = stage.character.scene.output.floor.unwrap();
    let before = stage.shown.positions.clone();
    view.run(0.5);
    let after = &view.app.stage().unwrap().shown.positions;
    let moved = before
        .iter()
        .zip(after)
        .map(|(a, b)| a.distance(*b))
        .fold(0.0, f64::max);
    assert!(moved > 0.01, "{moved} m");
    assert!(lowest(&view) > ground - 0.01);
    let picture = view.picture().unwrap();
    keep(&picture, "dropped");
    assert!(super::differing(&nobody, &picture) > 3000);
}
