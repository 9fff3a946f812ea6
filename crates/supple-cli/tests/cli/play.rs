//! `supple play`: a character shown without a scene.

use super::{bad, folder, good, supple};
use std::path::Path;

/// A recipe that bakes the limb in an instant.
fn recipe(folder: &Path) {
    let text = "mesh = \"limb.txt\"\nbake.handles = [{ count = 12 }]\n";
    std::fs::write(folder.join("limb.toml"), text).unwrap();
}

/// The kinds of an APNG's chunks.
fn chunks(png: &[u8]) -> Vec<&[u8]> {
    let mut at = 8;
    let mut kinds = Vec::new();
    while at + 12 <= png.len() {
        let length = u32::from_be_bytes(png[at..at + 4].try_into().unwrap()) as usize;
        kinds.push(&png[at + 4..at + 8]);
        at += length + 12;
    }
    kinds
}

#[test]
fn a_character_that_nothing_moves_is_shaken() {
    let folder = folder();
    recipe(folder.path());
    let run = [
        "play",
        "limb.toml",
        "--backend",
        "cpu",
        "--seconds",
        "0.4",
        "--json",
    ];
    let told: serde_json::Value = serde_json::from_str(&good(folder.path(), &run)).unwrap();
    assert_eq!(told["showing"]["does"], "shaken");
    assert_eq!(told["steps"], 40);
    assert!(
        told["max_unposed_displacement_mm"].as_f64().unwrap() > 0.05,
        "{told}"
    );
    let results = folder.path().join("out/limb.play");
    let file = |name: &str| std::fs::read(results.join(name)).unwrap();
    let png = file("play.png");
    let pictures = chunks(&png).iter().filter(|kind| **kind == b"fcTL").count();
    assert_eq!(pictures, 9, "20 a second, the first at once");
    assert!(file("avatar.glb").starts_with(b"glTF"));
    let written: serde_json::Value = serde_json::from_slice(&file("report.json")).unwrap();
    assert_eq!(written, told);
}

#[test]
fn flags_that_fit_nothing_are_named() {
    let folder = folder();
    recipe(folder.path());
    let refused = |arguments: &[&str], code: i32, hints: &[&str]| {
        let arguments = [&["play", "limb.toml"], arguments].concat();
        bad(folder.path(), &arguments, code, hints);
    };
    refused(&["--clip", "walk"], 1, &["--clip", "--motion"]);
    refused(&["--map", "hips=pelvis"], 1, &["--map", "--motion"]);
    refused(&["--map", "hips"], 2, &["--map", "="]);
    refused(&["--scale", "0"], 1, &["limb.toml", "scale", "positive"]);
    refused(&["--seconds", "-1"], 2, &["-1"]);
    refused(&["--seconds", "0"], 1, &["seconds", "positive"]);
    refused(&["--motion", "none.bvh"], 1, &["none.bvh"]);
    bad(folder.path(), &["play", "none.glb"], 1, &["none.glb"]);
}

#[test]
fn a_scene_in_which_nothing_happens_says_so() {
    let folder = folder();
    let text = "name = \"idle\"\nsteps = 30\n[avatar]\nmesh = \"limb.txt\"\nbake.handles = [{ count = 12 }]\n";
    std::fs::write(folder.path().join("idle.toml"), text).unwrap();
    let output = supple(
        folder.path(),
        &["simulate", "idle.toml", "--backend", "cpu", "--json"],
    );
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{stderr}");
    assert!(
        stderr.contains("neither pins") && stderr.contains("shaken"),
        "{stderr}"
    );
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(report["steps"], 30);
    assert!(report["max_unposed_displacement_mm"].as_f64().unwrap() > 0.05);
}
