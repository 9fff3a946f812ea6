//! Which parts are tissue: what starts, what joins it over which bones, and what a recipe's names change.

use super::fixture::*;
use glam::{DAffine3, DMat4, DQuat, DVec3};
use serde_json::json;
use std::path::Path;
use supple_bake::{Body, Recipe, bake};
use supple_files::{CharacterOptions, PartNames, parse_gltf, read_character};

const CASES: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/cases");

/// Joints of the skin after the bar's three and a shoulder.
const UPPER: u8 = 4;
const LOWER: u8 = 5;
const HAND: [u8; 2] = [6, 7];
const LAMP: [u8; 2] = [8, 9];

/// A bar (the torso) with a chain of bones at its end: a shoulder that moves nothing, an arm on two bones, a larger hand on
/// two further ones; a helmet on one bone that is larger than all; a lamp on two bones of the root, far away; and a core
/// inside the torso.
fn figure() -> Fixture {
    let mut file = bar_file(&BarFile::default());
    let mut chain = |parent: usize, name: &str| {
        let node = file.push("nodes", json!({"name": name, "translation": [0.05, 0, 0]}));
        let children = &mut file.json["nodes"][parent]["children"];
        match children.as_array_mut() {
            Some(children) => children.push(json!(node)),
            None => *children = json!([node]),
        }
        node
    };
    let mut parent = 3;
    let mut joints = vec![1, 2, 3];
    for name in ["shoulder", "upper", "lower", "palm", "fingers"] {
        parent = chain(parent, name);
        joints.push(parent);
    }
    parent = 1;
    for name in ["stand", "shade"] {
        parent = chain(parent, name);
        joints.push(parent);
    }
    let bind = joint_worlds(DAffine3::IDENTITY, &[DQuat::IDENTITY; BONES]);
    let step = DAffine3::from_translation(DVec3::X * 0.05);
    let below = |mut world: DAffine3, count: usize| {
        let next = move |_| {
            world *= step;
            world
        };
        (0..count).map(next).collect::<Vec<_>>()
    };
    let worlds = (bind.iter().copied())
        .chain(below(bind[2], 5))
        .chain(below(bind[0], 2));
    let inverse: Vec<DMat4> = worlds.map(|w| w.inverse().into()).collect();
    let inverse = file.matrices(&inverse);
    file.json["skins"][0] = json!({"joints": joints, "inverseBindMatrices": inverse});

    let at = |x: f64| DVec3::new(x, 0.0, 0.0);
    part(
        &mut file,
        "arm",
        [UPPER, LOWER],
        0.03,
        0.3,
        at(LENGTH + 0.02),
    );
    part(&mut file, "hand", HAND, 0.04, 0.3, at(LENGTH + 0.23));
    part(&mut file, "helmet", [1, 1], 0.3, 1.0, DVec3::Y * 0.7);
    part(&mut file, "lamp", LAMP, 0.04, 0.5, DVec3::Z * 3.0);
    part(&mut file, "core", [0, 1], 0.02, 0.5, at(0.1));
    file
}

/// Adds a bar of a length share, one half on each of two joints.
fn part(file: &mut Fixture, name: &str, on: [u8; 2], radius: f64, length: f64, place: DVec3) {
    let bar = Bar::new(8, radius);
    let positions: Vec<DVec3> = (bar.positions.iter())
        .map(|p| DVec3::new(length * p.x, p.y, p.z) + place)
        .collect();
    let joints: Vec<[u8; 4]> = (bar.along.iter())
        .map(|s| [on[usize::from(*s > 0.5)], 0, 0, 0])
        .collect();
    let weights = vec![[1.0, 0.0, 0.0, 0.0]; joints.len()];
    let attributes = json!({
        "POSITION": file.vectors(&positions),
        "JOINTS_0": file.accessor(BYTE, "VEC4", joints.len(), joints.as_flattened()),
        "WEIGHTS_0": file.floats("VEC4", &weights),
    });
    let corners = bar.triangles.as_flattened();
    let indices = file.shorts("SCALAR", corners.len(), corners);
    let primitive = json!({"attributes": attributes, "indices": indices});
    let mesh = file.push("meshes", json!({"name": name, "primitives": [primitive]}));
    let node = file.push("nodes", json!({"mesh": mesh, "skin": 0}));
    let roots = file.json["scenes"][0]["nodes"].as_array_mut();
    roots.unwrap().push(json!(node));
}

fn body(file: &Fixture, named: &PartNames) -> supple::Result<Body> {
    parse_gltf(&file.glb(), "figure.glb")?.body_of_parts(&[], named)
}

fn names(list: &[&str]) -> Vec<String> {
    list.iter().map(|n| n.to_string()).collect()
}

#[test]
fn tissue_starts_on_several_bones_and_grows_over_neighbouring_ones() {
    let body = body(&figure(), &PartNames::default()).unwrap();
    assert_eq!(body.tissue_parts(), ["bar", "arm", "hand"]);
    let rigid: Vec<_> = (body.attachments.iter())
        .map(|a| (&*a.name, a.follows_tissue))
        .collect();
    assert_eq!(rigid, [("helmet", false), ("lamp", false), ("core", true)]);
}

#[test]
fn a_person_has_no_hair_of_tissue() {
    let mut file = figure();
    // A person's bones are named, and those of the hand are not: it might be a plait.
    let human: Vec<_> = [1, 2, 3, 6, 7]
        .iter()
        .zip(["hips", "spine", "chest", "leftUpperArm", "leftLowerArm"])
        .map(|(node, bone)| json!({"bone": bone, "node": node}))
        .collect();
    file.json["extensions"] = json!({"VRM": {"humanoid": {"humanBones": human}}});
    let body = body(&file, &PartNames::default()).unwrap();
    assert!(!body.skeleton.aliases.is_empty());
    assert_eq!(body.tissue_parts(), ["bar", "arm"]);
}

#[test]
fn a_recipe_names_exceptions() {
    let file = figure();
    let of = |tissue: &[&str], rigid: &[&str]| {
        let (tissue, rigid) = (names(tissue), names(rigid));
        body(&file, &PartNames { tissue, rigid })
    };
    let helmet = of(&["helmet"], &[]).unwrap();
    assert_eq!(helmet.tissue_parts(), ["bar", "arm", "hand", "helmet"]);
    // Without the arm no bone leads to the hand.
    let armless = of(&[], &["arm", "core"]).unwrap();
    assert_eq!(armless.tissue_parts(), ["bar"]);
    let rigid = |name: &str| {
        let found = armless.attachments.iter().find(|a| a.name == name);
        !found.unwrap().follows_tissue
    };
    assert!(rigid("arm") && rigid("core"));
    for (tissue, rigid, field, says) in [
        (
            &["head"][..],
            &[][..],
            "tissue[0]",
            "arm, bar, core, hand, helmet, lamp",
        ),
        (&["bar"], &["arm", "bar"], "rigid[1]", "both"),
        (
            &[],
            &["bar", "arm", "hand", "helmet", "lamp", "core"],
            "rigid",
            "every part",
        ),
    ] {
        let error = of(tissue, rigid).unwrap_err().to_string();
        assert!(
            error.starts_with(&format!("{field}: ")) && error.contains(says),
            "{error}"
        );
    }
}

#[test]
fn errors_of_a_bake_name_what_was_chosen() {
    let mut body = body(&figure(), &PartNames::default()).unwrap();
    body.skin.positions[0].x = f64::NAN;
    let error = bake(&body, &Recipe::default(), &mut |_| ()).unwrap_err();
    assert!(
        error.to_string().ends_with("(tissue is bar, arm, hand)"),
        "{error}"
    );
    // The recipe's own faults have nothing to do with it.
    let recipe = Recipe {
        density: -1.0,
        ..Recipe::default()
    };
    let error = bake(&body, &recipe, &mut |_| ()).unwrap_err();
    assert!(!error.to_string().contains("tissue is"), "{error}");
}

#[test]
fn segmented_figures_have_soft_limbs() {
    for name in ["segmented_figure.glb", "segmented_big_head.glb"] {
        let path = Path::new(CASES).join(name);
        if !path.exists() {
            println!("skipped: {} is not there", path.display());
            continue;
        }
        let file = read_character(&path, &CharacterOptions::default()).unwrap();
        let limbs = ["arm.L", "arm.R", "leg.L", "leg.R"];
        assert_eq!(file.body.tissue_parts(), [&["torso"][..], &limbs].concat());
        assert_eq!(file.notes, ["tissue is torso, arm.L, arm.R, leg.L, leg.R"]);
        let (avatar, _) = bake(&file.body, &Recipe::default(), &mut |_| ()).unwrap();
        for limb in limbs {
            let of_limb =
                |bone: u32| avatar.skeleton.names[bone as usize].ends_with(&format!("_{limb}"));
            let mass: f64 = (avatar
                .cubature
                .skinning
                .iter()
                .zip(&avatar.cubature.measure))
            .map(|(row, volume)| {
                let share = row.iter().filter(|w| of_limb(w.bone)).map(|w| w.weight);
                avatar.density * volume * share.sum::<f64>()
            })
            .sum();
            println!("{name}: {limb} {mass:.2} kg of tissue");
            assert!(mass > 0.5, "{limb}: {mass} kg");
        }
    }
}
