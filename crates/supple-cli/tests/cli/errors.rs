//! Exit codes and messages.

use super::{SCENE, bad, folder};

#[test]
fn what_is_wrong_is_said() {
    let folder = folder();
    let path = folder.path();
    let changed = |name: &str, from: &str, to: &str| {
        assert!(SCENE.contains(from));
        std::fs::write(path.join(name), SCENE.replacen(from, to, 1)).unwrap();
    };
    changed("key.toml", "steps = 12", "steps = 12\nstpes = 1");
    bad(
        path,
        &["simulate", "key.toml"],
        1,
        &["key.toml", "line 4", "stpes"],
    );
    changed("nan.toml", "[0.02, 0.0705]", "[0.02, nan]");
    bad(
        path,
        &["simulate", "nan.toml"],
        1,
        &["nan.toml", "colliders[0].motion.z[0][1]", "finite"],
    );
    changed("mesh.toml", "limb.txt", "nowhere.txt");
    bad(path, &["simulate", "mesh.toml"], 1, &["nowhere.txt"]);
    changed("bone.toml", "bone = \"bone\"", "bone = \"elbow\"");
    let cpu = ["simulate", "bone.toml", "--backend", "cpu"];
    bad(path, &cpu, 1, &["pins[0].bone", "elbow", "there are bone"]);
    bad(path, &["simulate", "nowhere.toml"], 1, &["nowhere.toml"]);
    bad(
        path,
        &["inspect", "tiny.toml"],
        1,
        &["tiny.toml", "not a baked avatar"],
    );
    changed(
        "foreign.toml",
        "mesh = \"limb.txt\"\nbake.handles = [{ count = 12 }]\nbake.material.stable_neo_hookean = { youngs_modulus = 30e3, poissons_ratio = 0.4 }",
        "file = \"limb.txt\"",
    );
    bad(
        path,
        &["simulate", "foreign.toml"],
        1,
        &["limb.txt", "not a baked avatar"],
    );
    std::fs::write(path.join("cut.txt"), "8 5 1").unwrap();
    bad(path, &["bake", "cut.txt"], 1, &["cut.txt", "line 1"]);
    std::fs::write(path.join("mesh.fbx"), "Kaydara").unwrap();
    bad(
        path,
        &["bake", "mesh.fbx"],
        1,
        &["mesh.fbx", ".glb", ".npz"],
    );
    bad(
        path,
        &["simulate", "tiny.toml", "--backend", "abacus"],
        2,
        &["abacus", "cpu"],
    );
    bad(path, &["frobnicate"], 2, &["frobnicate"]);
}
