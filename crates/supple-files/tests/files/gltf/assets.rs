//! The real files, where they are there.

use super::evaluation::{Evaluation, largest_distance, posed};
use std::path::PathBuf;
use supple_files::{read_gltf, read_gltf_motions};

const FOLDER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/assets");

/// The GLB files; says so where there is none.
fn files() -> Vec<PathBuf> {
    let Ok(folder) = std::fs::read_dir(FOLDER) else {
        println!("skipped: {FOLDER} is not there");
        return Vec::new();
    };
    let paths = folder.flatten().map(|f| f.path());
    let mut files: Vec<_> = paths
        .filter(|p| p.extension().is_some_and(|e| e == "glb"))
        .collect();
    files.sort();
    files
}

#[test]
fn rest_poses_are_the_files_own_and_skins_are_closed() {
    for path in files() {
        let character = read_gltf(&path).unwrap();
        let body = character.body(&[]).unwrap();
        assert_eq!(character.notes, [""; 0]);
        assert!(body.skin.is_closed() && body.skin.volume() > 0.0);
        let file = Evaluation::new(&std::fs::read(&path).unwrap());
        let found = posed(&body, &character.rest);
        let distance = largest_distance(&body, &found, &file.skinned(&file.rest()));
        println!("{}: {distance:.1e} m", path.display());
        assert!(distance < 1e-6);
    }
}

#[test]
fn bind_poses_are_the_files_own_up_to_its_placement() {
    for path in files() {
        let body = read_gltf(&path).unwrap().body(&[]).unwrap();
        let file = Evaluation::new(&std::fs::read(&path).unwrap());
        // The vertices as they stand in the file, placed as at rest by the bone of largest weight.
        let skin = file.document.skins().next().unwrap();
        let bind = file.bind_matrices(&skin);
        let world = file.rest();
        let root = skin
            .joints()
            .position(|j| Some(j.name().unwrap()) == body.skeleton.names.first().map(|n| &**n));
        let root = root.unwrap();
        let node = skin.joints().nth(root).unwrap().index();
        let placement = world[node] * bind[root];
        let mut expected = file.unskinned();
        for p in expected.iter_mut().flatten() {
            *p = placement.transform_point3(*p);
        }
        let distance =
            largest_distance(&body, &posed(&body, &body.skeleton.bind_pose()), &expected);
        println!("{}: {distance:.1e} m", path.display());
        assert!(distance < 1e-6);
    }
}

#[test]
fn animations_are_the_files_own() {
    let mut clips = 0;
    for path in files() {
        let body = read_gltf(&path).unwrap().body(&[]).unwrap();
        let file = Evaluation::new(&std::fs::read(&path).unwrap());
        for (k, clip) in read_gltf_motions(&path).unwrap().iter().enumerate() {
            clips += 1;
            assert_eq!(clip.bones, body.skeleton.names);
            let mut largest: f64 = 0.0;
            let start = file.first_key(k);
            for f in (0..clip.frames.len()).step_by(7) {
                let time = start + clip.frame_time * f as f64;
                let found = posed(&body, &clip.world_frames(&clip.frames[f]));
                let expected = file.skinned(&file.animated(k, time));
                largest = largest.max(largest_distance(&body, &found, &expected));
            }
            println!("{}: {largest:.1e} m", path.display());
            assert!(largest < 1e-6);
        }
    }
    assert!(clips == 3 || files().is_empty());
}
