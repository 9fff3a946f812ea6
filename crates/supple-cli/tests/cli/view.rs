//! `supple view` without a window, and where there is none.

use super::{folder, supple};
use std::process::Command;

#[test]
fn a_picture_is_taken_without_a_window() {
    let folder = folder();
    let arguments = [
        "view",
        "tiny.toml",
        "--picture",
        "seen.png",
        "--seconds",
        "0.1",
    ];
    let output = supple(folder.path(), &arguments);
    let told = String::from_utf8_lossy(&output.stderr);
    if told.contains("no adapter") {
        println!("left out: {told}");
        return;
    }
    assert!(output.status.success(), "{told}");
    let picture = std::fs::File::open(folder.path().join("seen.png")).unwrap();
    let picture = png::Decoder::new(std::io::BufReader::new(picture));
    let information = picture.read_info().unwrap().info().size();
    assert_eq!(information, (1180, 760));
}

#[test]
fn what_cannot_be_shown_is_refused_with_file_and_cure() {
    let folder = folder();
    std::fs::write(folder.path().join("a.fbx"), "Kaydara").unwrap();
    for (arguments, says) in [
        (
            &["view", "--scene", "nothing", "--picture", "a.png"][..],
            "hand_press",
        ),
        (
            &["view", "--picture", "a.png", "--seconds", "900"],
            "must be within",
        ),
        (&["view", "a.fbx", "--picture", "a.png"], "a.fbx"),
    ] {
        let output = supple(folder.path(), arguments);
        let told = String::from_utf8_lossy(&output.stderr);
        assert!(!output.status.success());
        assert!(told.contains(says) || told.contains("no adapter"), "{told}");
    }
}

/// Where there is no display, the message says what a window needs.
#[cfg(target_os = "linux")]
#[test]
fn without_a_display_it_says_what_a_window_needs() {
    let folder = folder();
    let output = Command::new(env!("CARGO_BIN_EXE_supple"))
        .args(["view", "tiny.toml"])
        .current_dir(folder.path())
        .env_remove("DISPLAY")
        .env_remove("WAYLAND_DISPLAY")
        .env_remove("WAYLAND_SOCKET")
        .output()
        .unwrap();
    let told = String::from_utf8_lossy(&output.stderr);
    assert!(!output.status.success());
    assert!(told.contains("supple play"), "{told}");
}
