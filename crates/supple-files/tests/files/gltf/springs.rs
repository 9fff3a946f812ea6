//! VRM's spring bones: read of both versions, baked, simulated; broken ones left out.

use super::damaged::somewhere_in;
use super::fixture::*;
use glam::{DAffine3, DMat3, DMat4, DQuat, DVec3};
use serde_json::{Value, json};
use std::sync::Arc;
use supple::internal::math::Random;
use supple::model::{Frame, SpringBones};
use supple::potential::CpuPotential;
use supple::sim::{Pin, Settings, Simulation};
use supple_bake::{Body, Recipe, bake};
use supple_files::{gltf::Character, parse_gltf};

/// Nodes of the hair.
const HAIR: usize = 4;
const STEP: f64 = 0.05;

/// A bar with a closed tress, larger than itself, on a row of nodes of its own above its end: as `extension` tells. Node
/// numbers of the tress begin with the second.
fn haired() -> (Fixture, usize) {
    let mut file = bar_file(&BarFile {
        rings: 25,
        ..BarFile::default()
    });
    let bind = joint_worlds(DAffine3::IDENTITY, &[DQuat::IDENTITY; BONES]);
    let foot = DVec3::new(LENGTH, 0.1, 0.0);
    let first = file.json["nodes"].as_array().unwrap().len();
    let mut worlds = bind.to_vec();
    for k in 0..HAIR {
        let world = DAffine3 {
            translation: foot + DVec3::Y * (STEP * k as f64),
            ..bind[2]
        };
        let local = worlds.last().unwrap().inverse() * world;
        let mut node =
            json!({"name": format!("hair {k}"), "translation": local.translation.to_array()});
        if k + 1 < HAIR {
            node["children"] = json!([first + k + 1]);
        }
        file.push("nodes", node);
        worlds.push(world);
    }
    file.json["nodes"][3]["children"] = json!([first]);
    let joints: Vec<usize> = (1..=BONES).chain(first..first + HAIR).collect();
    let inverse: Vec<DMat4> = worlds.iter().map(|w| w.inverse().into()).collect();
    let inverse = file.matrices(&inverse);
    file.json["skins"][0] = json!({"joints": joints, "inverseBindMatrices": inverse});

    let bar = Bar::new(12, 0.1);
    let up = |p: &DVec3| foot + DVec3::new(-p.y, p.x * STEP * HAIR as f64 / LENGTH, p.z);
    let positions: Vec<DVec3> = bar.positions.iter().map(up).collect();
    let on = |s: &f64| {
        [
            BONES as u8 + ((s * HAIR as f64) as u8).min(HAIR as u8 - 1),
            0,
            0,
            0,
        ]
    };
    let joints: Vec<[u8; 4]> = bar.along.iter().map(on).collect();
    let weights = vec![[1.0, 0.0, 0.0, 0.0]; joints.len()];
    let primitive = bar.primitive_on(&mut file, &positions, &joints, &weights);
    let mesh = file.push(
        "meshes",
        json!({"name": "tress", "primitives": [primitive]}),
    );
    let node = file.push("nodes", json!({"mesh": mesh, "skin": 0}));
    file.json["scenes"][0]["nodes"]
        .as_array_mut()
        .unwrap()
        .push(json!(node));
    (file, first)
}

/// As VRM 1.0 tells it: the last node is a tail only.
fn version_1() -> (Fixture, usize) {
    let (mut file, hair) = haired();
    let joint = |k: usize| {
        json!({
            "node": hair + k, "stiffness": 0.5 + k as f64, "dragForce": 0.25, "gravityPower": 0.5,
            "gravityDir": [0, -1, 0.5], "hitRadius": 0.01,
        })
    };
    let mut joints: Vec<Value> = (0..HAIR - 1).map(joint).collect();
    joints.push(json!({"node": hair + HAIR - 1}));
    file.json["extensions"]["VRMC_vrm"] =
        json!({"specVersion": "1.0", "humanoid": {"humanBones": {"hips": {"node": 1}}}});
    file.json["extensions"]["VRMC_springBone"] = json!({
        "specVersion": "1.0",
        "colliders": [
            {"node": 1, "shape": {}},
            {"node": 3, "shape": {"sphere": {"offset": [0.01, 0.02, 0.03], "radius": 0.04}}},
            {"node": 1, "shape": {"capsule": {"offset": [0, 0, 0], "radius": 0.03, "tail": [0.1, 0, 0]}}},
        ],
        "colliderGroups": [{"name": "arm", "colliders": [1]}, {"colliders": [2, 1, 0]}],
        "springs": [{"name": "tress", "joints": joints, "colliderGroups": [0, 1], "center": 2}],
    });
    (file, hair)
}

/// As VRM 0.x tells it: all nodes below the first turn.
fn version_0() -> (Fixture, usize) {
    let (mut file, hair) = haired();
    file.json["extensions"]["VRM"] = json!({
        "specVersion": "0.0",
        "humanoid": {"humanBones": [{"bone": "hips", "node": 1}]},
        "secondaryAnimation": {
            "boneGroups": [{
                "comment": "", "stiffiness": 0.5, "dragForce": 0.25, "gravityPower": 0.5,
                "gravityDir": {"x": 0, "y": -1, "z": -0.5}, "hitRadius": 0.01, "center": -1,
                "bones": [hair], "colliderGroups": [1],
            }],
            "colliderGroups": [
                {"node": 2, "colliders": [{"offset": {"x": 0, "y": 0, "z": 0}, "radius": 0.05}]},
                {"node": 3, "colliders": [{"offset": {"x": 0.01, "y": 0.02, "z": -0.03}, "radius": 0.04}]},
            ],
        },
    });
    (file, hair)
}

fn read(file: &Fixture) -> Character {
    parse_gltf(&file.glb(), "figure.vrm").unwrap()
}

fn body(file: &Fixture) -> Body {
    read(file).body(&[]).unwrap()
}

fn springs_are_sound(body: &Body) {
    body.springs.validate(&body.skeleton.parents).unwrap();
}

fn names(body: &Body, springs: &SpringBones) -> Vec<String> {
    let name = |bone: u32| body.skeleton.names[bone as usize].clone();
    springs
        .joints
        .iter()
        .map(|joint| name(joint.bone))
        .collect()
}

#[test]
fn version_1_has_pairs_of_joints() {
    let (file, _) = version_1();
    let body = body(&file);
    springs_are_sound(&body);
    let springs = &body.springs;
    assert_eq!(names(&body, springs), ["hair 0", "hair 1", "hair 2"]);
    let [chain] = &springs.chains[..] else {
        panic!()
    };
    assert_eq!((&*chain.name, chain.center), ("tress", Some(1)));
    // The first collider is none: the others move up.
    assert_eq!(
        (springs.colliders.len(), &chain.colliders[..]),
        (2, &[0, 1][..])
    );
    let [sphere, capsule] = &springs.colliders[..] else {
        panic!()
    };
    assert!(sphere.tail.is_none() && (sphere.radius - 0.04).abs() < 1e-12);
    let axis = capsule.tail.unwrap() - capsule.offset;
    assert!((axis.length() - 0.1).abs() < 1e-6);
    for (k, joint) in springs.joints.iter().enumerate() {
        assert!(
            joint.tail.distance(DVec3::Y * STEP) < 1e-6,
            "{}",
            joint.tail
        );
        assert!(joint.rest_rotation.abs_diff_eq(DMat3::IDENTITY, 1e-6));
        assert_eq!(joint.stiffness, 0.5 + k as f64);
        assert_eq!((joint.drag_force, joint.hit_radius), (0.25, 0.01));
        assert_eq!(joint.gravity, DVec3::new(0.0, -0.5, 0.25));
    }
    assert_eq!(
        read(&file)
            .notes
            .iter()
            .filter(|n| n.contains("colliders"))
            .count(),
        1
    );
}

#[test]
fn version_0_has_all_nodes_below_a_root() {
    let (mut file, hair) = version_0();
    let body_0 = body(&file);
    springs_are_sound(&body_0);
    let springs = &body_0.springs;
    assert_eq!(
        names(&body_0, springs),
        ["hair 0", "hair 1", "hair 2", "hair 3"]
    );
    assert_eq!(
        (&*springs.chains[0].name, springs.chains[0].center),
        ("hair 0", None)
    );
    // z points the other way, of colliders and of gravity.
    assert_eq!(springs.joints[0].gravity, DVec3::new(0.0, -0.5, 0.25));
    let sphere = springs.colliders[springs.chains[0].colliders[0] as usize];
    let (one, _) = version_1();
    let same = body(&one).springs.colliders[0];
    assert!(sphere.offset.distance(same.offset) < 1e-9);
    // What has no child has a tail 7 cm on.
    for (joint, length) in springs.joints.iter().zip([STEP, STEP, STEP, 0.07]) {
        assert!(
            joint.tail.distance(DVec3::Y * length) < 1e-6,
            "{}",
            joint.tail
        );
    }
    // A root below another's has numbers of its own.
    let groups = &mut file.json["extensions"]["VRM"]["secondaryAnimation"]["boneGroups"];
    let mut group = groups[0].clone();
    (group["bones"], group["stiffiness"]) = (json!([hair + 2]), json!(3));
    groups.as_array_mut().unwrap().insert(0, group);
    let stiffness =
        |b: &Body| -> Vec<f64> { b.springs.joints.iter().map(|j| j.stiffness).collect() };
    assert_eq!(stiffness(&body(&file)), [0.5, 0.5, 3.0, 3.0]);
}

#[test]
fn nodes_that_turn_are_bones_also_where_no_skin_has_them() {
    let (mut file, hair) = version_1();
    // Between the bar and the tress a node that is no joint; it turns the tress.
    let pivot = file.push("nodes", json!({"name": "pivot", "children": [hair]}));
    file.json["nodes"][3]["children"] = json!([pivot]);
    let joints = file.json["extensions"]["VRMC_springBone"]["springs"][0]["joints"].as_array_mut();
    joints.unwrap().insert(0, json!({"node": pivot}));
    let body = body(&file);
    assert_eq!(names(&body, &body.springs)[0], "pivot");
    // What the schema has as defaults.
    let joint = body.springs.joints[0];
    assert_eq!(
        (joint.stiffness, joint.drag_force, joint.hit_radius),
        (1.0, 0.5, 0.0)
    );
    assert_eq!(joint.gravity, DVec3::ZERO);
}

/// Without a line of TOML: hair is no tissue, its bones are carried, and they swing.
#[test]
fn a_vrm_swings_as_it_comes() {
    for (file, _) in [version_0(), version_1()] {
        let body = body(&file);
        let tress = body.attachments.iter().find(|a| a.name == "tress").unwrap();
        assert!(!tress.follows_tissue);
        assert_eq!(
            body.skin.positions.len(),
            Bar::new(25, 0.05).positions.len()
        );
        let (avatar, report) = bake(&body, &Recipe::default(), &mut |_| ()).unwrap();
        assert_eq!(report.springs.joints, body.springs.joints.len());
        assert_eq!(report.springs.colliders, avatar.springs.colliders.len());
        let potential = CpuPotential::new(Arc::new(avatar.clone()), 1).unwrap();
        let settings = Settings {
            time_step: 1.0 / 60.0,
            ..Settings::default()
        };
        let mut simulation = Simulation::new(&avatar, potential, settings).unwrap();
        let bone = avatar.skeleton.find("hair 1").unwrap();
        let parent = avatar.skeleton.parents[bone].unwrap() as usize;
        let mut most = 0.0_f64;
        for step in 0..90 {
            let shift = DVec3::X * 0.1 * (0.2 * f64::from(step)).sin();
            let frame = Frame {
                position: avatar.skeleton.joints[0] + shift,
                ..Frame::IDENTITY
            };
            let instance = &mut simulation.instances_mut()[0];
            instance.pins = vec![Pin { bone: 0, frame }];
            simulation.step_blocking().unwrap();
            let frames = &simulation.instances()[0].state.frames;
            let turn = frames[parent].rotation.transpose() * frames[bone].rotation;
            most = most.max(DQuat::from_mat3(&turn).to_axis_angle().1);
        }
        assert!(most > 0.05, "{most} rad");
        let still = Recipe {
            springs: false,
            ..Recipe::default()
        };
        assert!(
            bake(&body, &still, &mut |_| ())
                .unwrap()
                .0
                .springs
                .is_empty()
        );
    }
}

#[test]
fn what_moves_tissue_is_left_to_the_tissue() {
    let (mut file, _) = version_1();
    // A chain on the bar's own joints.
    let springs = file.json["extensions"]["VRMC_springBone"]["springs"].as_array_mut();
    springs
        .unwrap()
        .push(json!({"name": "bust", "joints": [{"node": 2}, {"node": 3}]}));
    let (avatar, report) = bake(&body(&file), &Recipe::default(), &mut |_| ()).unwrap();
    assert_eq!(avatar.springs.chains.len(), 1);
    let note = report.notes.iter().find(|n| n.contains("bone 1")).unwrap();
    assert!(note.contains("tissue"), "{note}");
}

#[test]
fn broken_chains_are_left_out_with_a_word() {
    let (sound, hair) = version_1();
    let springs = "/extensions/VRMC_springBone/springs";
    type Change<'a> = &'a dyn Fn(&mut Value);
    let cases: [(Change<'_>, &str); 9] = [
        (&|s| s[0]["joints"][1]["node"] = json!(999), "node 999"),
        (&|s| s[0]["joints"][1]["node"] = json!(-1), "no node"),
        (
            &|s| s[0]["joints"][0]["hitRadius"] = json!(-0.1),
            "negative hitRadius",
        ),
        (
            &|s| s[0]["joints"][0]["stiffness"] = json!("x"),
            "stiffness",
        ),
        (
            &|s| s[0]["joints"][2]["gravityPower"] = json!(1e300),
            "gravityPower",
        ),
        (
            &|s| s[0]["joints"][2]["gravityDir"] = json!([0, 1]),
            "gravity",
        ),
        // A ring, and a joint twice.
        (&|s| s[0]["joints"][3]["node"] = json!(hair), "not above"),
        (&|s| s[0]["joints"][1]["node"] = json!(hair), "not above"),
        (
            &|s| {
                let again =
                    json!({"name": "again", "joints": [{"node": hair}, {"node": hair + 1}]});
                s.as_array_mut().unwrap().push(again);
            },
            "turned already",
        ),
    ];
    for (change, word) in cases {
        let mut file = sound.clone();
        change(file.json.pointer_mut(springs).unwrap());
        let character = read(&file);
        let note = character.notes.iter().find(|n| n.contains("spring chain"));
        assert!(
            note.is_some_and(|n| n.contains(word)),
            "{word}: {:?}",
            character.notes
        );
        let left = character.body(&[]).unwrap().springs.chains.len();
        assert_eq!(left, usize::from(word == "turned already"), "{word}");
    }
    let mut file = sound.clone();
    file.json.pointer_mut(springs).unwrap()[0]["joints"][0]["dragForce"] = json!(1.5);
    assert_eq!(body(&file).springs.joints[0].drag_force, 1.0);
    assert!(read(&file).notes.iter().any(|n| n.contains("drag force")));
}

/// Whatever the extensions hold, the file is read, and what swings is sound.
#[test]
fn ten_thousand_damaged_extensions_cost_no_more_than_their_chains() {
    let strange = [
        json!(-1),
        json!(0),
        json!(1),
        json!(3),
        json!(6),
        json!(1e300),
        json!(u64::MAX),
        json!(0.5),
        json!(null),
        json!("x"),
        json!([]),
        json!({}),
        json!([1, 2, 3]),
        json!([[0]]),
        json!(-1e9),
    ];
    let mut random = Random::new(79);
    let mut whole = 0;
    for (sound, _) in [version_0(), version_1()] {
        for _ in 0..5000 {
            let mut file = sound.clone();
            for _ in 0..1 + random.index(3) {
                let at = somewhere_in(&mut file.json["extensions"], 2, &mut random);
                *at = strange[random.index(strange.len())].clone();
            }
            let character = parse_gltf(&file.glb(), "figure.vrm").unwrap();
            let body = character.body(&[]).unwrap();
            springs_are_sound(&body);
            whole += usize::from(body.springs.joints.len() >= HAIR - 1);
        }
    }
    assert!((1000..9900).contains(&whole), "{whole}");
}
