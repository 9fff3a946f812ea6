//! The real files, where they are there.

use super::evaluation::{Evaluation, largest_distance, posed};
use std::path::PathBuf;
use supple::load::read_gltf;

const FOLDER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../shared/assets");

/// The GLB files; says so where there is none.
pub fn files() -> Vec<PathBuf> {
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
fn rest_poses_are_the_files_own() {
    for path in files() {
        let character = read_gltf(&path).unwrap();
        let body = character.body(&[]).unwrap();
        println!(
            "{}: {} bones {:?}, {} vertices, {} triangles, closed {}, volume {}, notes {:?}",
            body.name,
            body.skeleton.len(),
            body.skeleton.parents,
            body.skin.positions.len(),
            body.skin.triangles.len(),
            body.skin.is_closed(),
            body.skin.volume(),
            character.notes
        );
        let file = Evaluation::new(&std::fs::read(&path).unwrap());
        let found = posed(&body, &character.rest);
        let distance = largest_distance(&body, &found, &file.skinned(&file.rest()));
        println!("{distance:.1e}");
        assert!(distance < 1e-6, "{}: {distance:.1e} m", path.display());
    }
}
