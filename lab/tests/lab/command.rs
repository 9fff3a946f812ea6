//! The command `supple-figures`.

use std::path::Path;
use std::process::{Command, Output};

fn figures(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_supple-figures"))
        .current_dir(folder)
        .args(arguments)
        .output()
        .unwrap()
}

fn says(output: &Output, code: i32, hints: &[&str]) {
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(code), "{stderr}");
    for hint in hints {
        assert!(stderr.contains(hint), "{hint:?} is not in: {stderr}");
    }
}

#[test]
fn figures_are_listed_and_found_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let listed = figures(folder.path(), &["--list"]);
    let listed = String::from_utf8(listed.stdout).unwrap();
    for figure in supple_lab::FIGURES {
        assert!(listed.contains(figure.name) && listed.contains(figure.title));
    }
    let unknown = figures(folder.path(), &["--only", "rigid_sof"]);
    says(&unknown, 1, &["--only", "rigid_sof", "rigid_soft"]);
    // Where there are no scenes, the figure says so, and the page with it.
    let lost = ["--only", "rigid_soft", "--small", "--scenes", "nowhere"];
    says(&figures(folder.path(), &lost), 1, &["1 of 1 checks fail"]);
    let page = std::fs::read_to_string(folder.path().join("out/figures/index.html")).unwrap();
    assert!(page.contains("finger_press.toml"), "{page}");
}

#[test]
fn scenes_are_in_the_program_so_that_any_folder_will_do() {
    let folder = tempfile::tempdir().unwrap();
    says(
        &figures(folder.path(), &["--only", "spin", "--small"]),
        0,
        &[],
    );
    assert!(folder.path().join("out/figures/index.html").exists());
}
