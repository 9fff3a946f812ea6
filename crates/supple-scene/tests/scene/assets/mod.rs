//! Any character, baked with no recipe: a static pose is the file's own skinning, and a shake moves the tissue
//! visibly and inverts nothing. Real files where they are there, bodies of the crate's own making anywhere.

#[path = "../../../../supple-files/tests/files/gltf/evaluation.rs"]
#[allow(dead_code, reason = "the loader's tests use all of it")]
mod evaluation;
mod own_skinning;
mod shake;

use shake::{Shake, shake};
use std::path::{Path, PathBuf};
use std::time::Instant;
use supple::material::Material;
use supple::model::Avatar;
use supple_bake::{BakeReport, Body, Recipe, bake};
use supple_samples::Sample;
use supple_scene::{AvatarSource, avatar_source_of};

const FOLDER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/assets");

/// The file called `name`; `None`, said aloud, where it is not there.
fn asset(name: &str) -> Option<PathBuf> {
    let path = Path::new(FOLDER).join(name);
    if path.exists() {
        return Some(path);
    }
    println!(
        "skipped: {} is not there; generated bodies cover the same",
        path.display()
    );
    None
}

/// Bakes with no choice made, and checks what any bake must hold.
fn baked(body: &Body) -> (Avatar, BakeReport) {
    let start = Instant::now();
    let (avatar, report) = bake(body, &Recipe::default(), &mut |_| {}).unwrap();
    println!(
        "{}: baked in {:.1} s; {} handles, {} points, {} tets, {}",
        avatar.name,
        start.elapsed().as_secs_f64(),
        avatar.handles.len(),
        avatar.cubature.len(),
        report.mesh.quality.tets,
        avatar.material,
    );
    assert_eq!(report.mesh.quality.inverted, 0);
    let cubature = &report.cubature;
    assert!((cubature.weight_sum / cubature.volume - 1.0).abs() < 1e-12);
    (avatar, report)
}

/// Peak displacement of the tissue between 1 and 60 mm, of people's own tissue up to the 110 mm of a run, and no tet inverted,
/// whether the whole skeleton is moved or hangs on its root.
fn shakes_well(avatar: &Avatar) {
    let most = match avatar.material {
        Material::FungNeoHookean(_) => 110.0,
        // A toy's limbs that hang limp.
        _ => 60.0,
    };
    for how in [Shake::Skeleton, Shake::RootAlone] {
        let start = Instant::now();
        let shaken = shake(avatar, how);
        println!(
            "{}: {how:?} shaken: {:.2} mm at most, min det F {:.3}, joints within {:.2} mm; {:.1} s",
            avatar.name,
            shaken.peak_mm,
            shaken.min_det_f,
            shaken.joint_gap_mm,
            start.elapsed().as_secs_f64()
        );
        let name = &avatar.name;
        assert!(
            (1.0..=most).contains(&shaken.peak_mm),
            "{name}: {how:?} {shaken:?}"
        );
        assert!(shaken.min_det_f > 0.0, "{name}: {how:?} {shaken:?}");
    }
}

fn file_is_soft(name: &str) {
    let Some(path) = asset(name) else { return };
    let (body, recipe) = avatar_source_of(&path).unwrap().body().unwrap();
    assert_eq!(recipe, Recipe::default());
    let (avatar, _) = baked(&body);
    let distance = own_skinning::largest_distance(&path, &avatar);
    println!("{name}: a static pose misses the file's own by {distance:.1e} m");
    assert!(distance < 1e-6, "{name}: {distance:.1e} m");
    shakes_well(&avatar);
}

#[test]
fn a_hand_of_webxr() {
    file_is_soft("webxr-generic-hand-left.glb");
}

#[test]
fn a_toy_man() {
    file_is_soft("khronos-CesiumMan.glb");
}

#[test]
fn a_bar_of_some_units() {
    file_is_soft("khronos-RiggedSimple.glb");
}

#[test]
fn a_person_in_gltf() {
    file_is_soft("makehuman-female-cmu-02_01.glb");
}

#[test]
fn a_person_in_smpls_layout() {
    file_is_soft("makehuman-female-game_engine-smpl-layout.npz");
}

#[test]
fn no_file_of_the_folder_is_left_out() {
    let Ok(entries) = std::fs::read_dir(FOLDER) else {
        println!("skipped: {FOLDER} is not there");
        return;
    };
    let source = include_str!("mod.rs");
    for path in entries.map(|e| e.unwrap().path()) {
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        if avatar_source_of(&path).is_ok() {
            assert!(
                source.contains(&format!("\"{name}\"")),
                "{name} has no test"
            );
        }
    }
}

#[test]
fn generated_bodies() {
    for sample in [Sample::Body, Sample::Hand, Sample::Finger] {
        let (mut body, _) = AvatarSource::of_sample(sample).body().unwrap();
        // As a file without bones or layer would bring it.
        body.bone_surfaces.clear();
        body.layer = Default::default();
        let (avatar, _) = baked(&body);
        shakes_well(&avatar);
    }
}
