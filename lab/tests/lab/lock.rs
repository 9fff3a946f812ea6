//! What the lock file may hold: nothing that asks for a newer compiler than we say, licences that deny.toml allows, and
//! crates.io's packages only. `cargo deny` says more; this needs no program of its own.

use serde_json::Value;
use std::process::Command;

/// The workspace's packages and all that they depend on.
fn packages() -> Vec<Value> {
    let output = Command::new(env!("CARGO"))
        .args(["metadata", "--format-version", "1", "--locked"])
        .current_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/.."))
        .output()
        .unwrap();
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let metadata: Value = serde_json::from_slice(&output.stdout).unwrap();
    metadata["packages"].as_array().unwrap().clone()
}

fn name(package: &Value) -> String {
    format!(
        "{} {}",
        package["name"].as_str().unwrap(),
        package["version"].as_str().unwrap()
    )
}

/// Major and minor of a version of Rust.
fn version(text: &str) -> [u32; 2] {
    let mut numbers = text.split('.').map(|n| n.parse().unwrap());
    [numbers.next().unwrap(), numbers.next().unwrap_or(0)]
}

#[test]
fn no_package_asks_for_a_newer_compiler_than_we_say() {
    let packages = packages();
    let asked = |p: &Value| p["rust_version"].as_str().map(version);
    let own = packages
        .iter()
        .find(|p| p["name"] == "supple")
        .and_then(asked)
        .unwrap();
    let newer: Vec<String> = (packages.iter())
        .filter(|p| asked(p).is_some_and(|v| v > own))
        .map(name)
        .collect();
    assert!(
        newer.is_empty(),
        "rust-version is {own:?}, but {newer:?} ask for more"
    );
}

#[test]
fn packages_come_from_one_registry_under_licences_that_are_allowed() {
    let deny = include_str!("../../../deny.toml");
    let allowed = |licence: &str| deny.contains(&format!("\"{licence}\""));
    for package in packages() {
        let source = package["source"].as_str().unwrap_or("crates.io");
        assert!(
            source.contains("crates.io"),
            "{} is from {source}",
            name(&package)
        );
        let licence = package["license"].as_str().unwrap_or_default();
        // One of several is enough; each of those joined by AND is needed.
        let offers = licence.replace(['(', ')'], "");
        let mut offers = offers.split(" OR ").flat_map(|o| o.split('/'));
        let fine = offers.any(|offer| offer.split(" AND ").all(|l| allowed(l.trim())));
        // (A OR B) AND C: what stands before AND was one of several.
        let joined = licence.split(" AND ").all(|part| {
            let part = part.replace(['(', ')'], "");
            part.split(" OR ").any(|l| allowed(l.trim()))
        });
        assert!(fine || joined, "{}: {licence:?}", name(&package));
    }
}
