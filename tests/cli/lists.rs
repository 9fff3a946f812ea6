//! What is listed: adapters, figures.

use super::{bad, folder, good};

#[test]
fn adapters_are_listed() {
    let folder = tempfile::tempdir().unwrap();
    let json = good(folder.path(), &["adapters", "--json"]);
    assert!(
        serde_json::from_str::<serde_json::Value>(&json)
            .unwrap()
            .is_array()
    );
    assert!(!good(folder.path(), &["adapters"]).is_empty());
}

#[test]
fn figures_are_listed_and_found_by_name() {
    let folder = folder();
    let listed = good(folder.path(), &["figures", "--list"]);
    for figure in supple_lab::FIGURES {
        assert!(listed.contains(figure.name) && listed.contains(figure.title));
    }
    let unknown = ["figures", "--only", "rigid_sof"];
    bad(
        folder.path(),
        &unknown,
        1,
        &["--only", "rigid_sof", "rigid_soft"],
    );
    // Where there are no scenes, the figure says so, and the page with it.
    let lost = ["figures", "--only", "rigid_soft", "--small"];
    bad(folder.path(), &lost, 1, &["1 of 1 checks fail"]);
    let page = std::fs::read_to_string(folder.path().join("out/figures/index.html")).unwrap();
    assert!(page.contains("finger_press.toml"), "{page}");
}
