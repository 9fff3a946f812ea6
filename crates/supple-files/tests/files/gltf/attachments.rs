//! What is not the body's volume: found, followed or left rigid, baked, simulated, drawn.

use super::evaluation::check_rest;
use super::fixture::*;
use glam::{DAffine3, DMat4, DQuat, DVec3};
use serde_json::json;
use std::sync::Arc;
use supple::collider::{Collider, Shape};
use supple::model::{Frame, UpAxis};
use supple::potential::CpuPotential;
use supple::sim::{Settings, Simulation};
use supple::skeleton::{Spring, Tracking};
use supple_bake::{Attachment, Body, Recipe, bake, from_bytes, full_space, to_bytes};
use supple_files::{Recording, parse_gltf, write_glb};

/// A bar with an eye (a small closed bar beside it, on bone 1), a sleeve (an open tube around its
/// middle, on all bones) and a tress (an open tube on a bone of its own).
fn dressed() -> Fixture {
    let mut file = bar_file(&BarFile {
        rings: 25,
        ..BarFile::default()
    });
    let count = Bar::new(25, 0.05).positions.len();
    let coordinates: Vec<[f32; 2]> = (0..count).map(|v| [v as f32 / 100.0, 0.25]).collect();
    let coordinates = file.floats("VEC2", &coordinates);
    file.json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] = json!(coordinates);
    let tress = file.push(
        "nodes",
        json!({"name": "tress", "translation": [0, 0.1, 0]}),
    );
    file.json["nodes"][3]["children"] = json!([tress]);
    let bind = joint_worlds(DAffine3::IDENTITY, &[DQuat::IDENTITY; BONES]);
    let last = bind[2] * DAffine3::from_translation(DVec3::Y * 0.1);
    let inverse: Vec<DMat4> = bind
        .into_iter()
        .chain([last])
        .map(|b| b.inverse().into())
        .collect();
    let inverse = file.matrices(&inverse);
    file.json["skins"][0] = json!({"joints": [1, 2, 3, tress], "inverseBindMatrices": inverse});

    let plain = Bar::new(12, 1.0);
    // Without the ends' vertices and their triangles a bar is a tube, open at both ends.
    let last = plain.positions.len() as u16 - 1;
    let open: Vec<[u16; 3]> = (plain.triangles.iter().copied())
        .filter(|t| t.iter().all(|v| *v != 0 && *v != last))
        .collect();
    let on = |bone: u8| {
        let joints = vec![[bone, 0, 0, 0]; plain.positions.len()];
        (joints, vec![[1.0, 0.0, 0.0, 0.0]; plain.positions.len()])
    };
    let place = |scale: DVec3, shift: DVec3| -> Vec<DVec3> {
        plain.positions.iter().map(|p| scale * *p + shift).collect()
    };
    let worn = [
        (
            "eye",
            place(DVec3::new(0.05, 0.01, 0.01), DVec3::new(0.31, 0.055, 0.001)),
            on(1),
            &plain.triangles,
        ),
        (
            "sleeve",
            place(DVec3::new(0.5, 0.054, 0.054), DVec3::X * 0.15),
            plain.influences(),
            &open,
        ),
        (
            "tress",
            place(DVec3::new(0.3, 0.01, 0.01), DVec3::new(0.5, 0.06, 0.0)),
            on(3),
            &open,
        ),
    ];
    for (name, positions, (joints, weights), triangles) in worn {
        // Only vertices that are used.
        let tube = triangles.len() == open.len();
        let used = usize::from(tube)..positions.len() - usize::from(tube);
        let positions = &positions[used.clone()];
        let (joints, weights) = (&joints[used.clone()], &weights[used.clone()]);
        let shifted = triangles.iter().map(|t| t.map(|v| v - used.start as u16));
        let triangles: Vec<[u16; 3]> = shifted.collect();
        let positions = file.vectors(positions);
        let attributes = json!({
            "POSITION": positions,
            "JOINTS_0": file.accessor(BYTE, "VEC4", joints.len(), joints.as_flattened()),
            "WEIGHTS_0": file.floats("VEC4", weights),
        });
        let indices = file.shorts("SCALAR", 3 * triangles.len(), triangles.as_flattened());
        let material = file.push("materials", json!({"name": format!("{name} stuff")}));
        let primitive = json!({"attributes": attributes, "indices": indices, "material": material});
        let mesh = file.push("meshes", json!({"name": name, "primitives": [primitive]}));
        let node = file.push("nodes", json!({"mesh": mesh, "skin": 0}));
        file.json["scenes"][0]["nodes"]
            .as_array_mut()
            .unwrap()
            .push(json!(node));
    }
    file
}

fn attachment<'a>(body: &'a Body, name: &str) -> &'a Attachment {
    body.attachments.iter().find(|a| a.name == name).unwrap()
}

#[test]
fn the_closed_body_is_tissue_and_the_rest_hangs_on_it() {
    let body = check_rest(&dressed().glb());
    assert!(body.skin.is_closed());
    assert_eq!(
        body.skin.positions.len(),
        Bar::new(25, 0.05).positions.len()
    );
    let names: Vec<&str> = body.attachments.iter().map(|a| &*a.name).collect();
    assert_eq!(names, ["eye", "sleeve", "tress"]);
    let follows = |name| attachment(&body, name).follows_tissue;
    assert!(!follows("eye") && follows("sleeve") && !follows("tress"));
    assert_eq!(body.render_meshes.len(), 4);

    // A second volume on several bones, beside the first, is tissue; one inside the first is not.
    for (shift, tissue) in [(0.3, true), (0.0, false)] {
        let mut file = bar_file(&BarFile::default());
        let bar = Bar::new(10, 0.03);
        let places: Vec<DVec3> = bar
            .positions
            .iter()
            .map(|p| *p + DVec3::Y * shift)
            .collect();
        let second = bar.primitive(&mut file, &places);
        file.json["meshes"][0]["primitives"]
            .as_array_mut()
            .unwrap()
            .push(second);
        let body = parse_gltf(&file.glb(), "two.glb")
            .unwrap()
            .body(&[])
            .unwrap();
        assert_eq!(body.attachments.is_empty(), tissue, "{shift}");
    }
}

#[test]
fn attachments_are_baked_and_drawn() {
    let body = check_rest(&dressed().glb());
    let (avatar, report) = bake(&body, &Recipe::default(), &mut |_| ()).unwrap();
    let tissue = avatar.tissue_vertices();
    assert_eq!(tissue, body.skin.positions.len());
    let baked = to_bytes(&avatar, Some(&report)).unwrap();
    assert_eq!(
        from_bytes(&baked, "a.supple".as_ref()).unwrap().avatar,
        avatar
    );
    let found: Vec<_> = report
        .attachments
        .iter()
        .map(|a| (&*a.name, a.following))
        .collect();
    let count = attachment(&body, "sleeve").surface.positions.len();
    assert_eq!(found, [("eye", 0), ("sleeve", count), ("tress", 0)]);

    // The sleeve lies 4 mm over the skin: it moves with what is below.
    let (mut moving, mut near) = (0, 0);
    for (k, row) in avatar.attached.iter().enumerate() {
        let v = tissue + k;
        assert_eq!(avatar.skin.measure[v], 0.0);
        let shares: f64 = row.iter().map(|(_, s)| s).sum();
        // All of it but the sleeve's narrow ends, which lie deep below.
        assert!((0.0..1.0 + 1e-9).contains(&shares), "{shares}");
        near += usize::from((shares - 1.0).abs() < 1e-9);
        for &(skin, _) in row {
            let distance = avatar.skin.position[v].distance(avatar.skin.position[skin as usize]);
            assert!(distance < 0.06, "{distance}");
        }
        let own: f64 = avatar.skin.basis.row(v).iter().map(|u| u.value).sum();
        let below = |&(s, share): &(u32, f64)| {
            share
                * avatar
                    .skin
                    .basis
                    .row(s as usize)
                    .iter()
                    .map(|u| u.value)
                    .sum::<f64>()
        };
        assert!((own - row.iter().map(below).sum::<f64>()).abs() < 1e-12);
        moving += usize::from(own > 0.1);
    }
    assert_eq!(near, count - 16);
    assert!(moving > count / 4, "{moving} of {count}");
    // The full space follows the same skin vertices.
    let full = full_space(&avatar).unwrap();
    full.validate().unwrap();
    assert_eq!(full.skin.len(), avatar.skin.len());

    // Drawn: the file's parts, their coordinates and materials.
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("out.glb");
    let mut state = avatar.rest_state();
    state
        .handles
        .iter_mut()
        .for_each(|h| *h = DVec3::new(0.0, 0.01, 0.0));
    let recording = Recording {
        up: UpAxis::Z,
        times: vec![0.0],
        states: vec![state],
        props: Vec::new(),
    };
    write_glb(&avatar, &recording, &path).unwrap();
    let gltf::Gltf { document, blob } = gltf::Gltf::open(&path).unwrap();
    let blob = blob.unwrap();
    let mesh = document.meshes().next().unwrap();
    assert_eq!(mesh.primitives().count(), body.render_meshes.len());
    for (primitive, part) in mesh.primitives().zip(&body.render_meshes) {
        assert_eq!(primitive.material().name().unwrap_or(""), part.material);
        let reader = primitive.reader(|_| Some(&blob[..]));
        let indices: Vec<u32> = reader.read_indices().unwrap().into_u32().collect();
        assert_eq!(indices, part.triangles.as_flattened());
        let coordinates = reader
            .read_tex_coords(0)
            .map(|c| c.into_f32().collect::<Vec<_>>());
        assert_eq!(coordinates.unwrap_or_default(), part.texture_coordinates);
        for (p, v) in reader.read_positions().unwrap().zip(&part.vertices) {
            let expected = avatar.skin.position[*v as usize].as_vec3().to_array();
            assert_eq!(p, expected);
        }
    }
}

#[test]
fn attachments_touch_nothing() {
    let body = check_rest(&dressed().glb());
    let (avatar, _) = bake(&body, &Recipe::default(), &mut |_| ()).unwrap();
    // A ball that holds the far end of the tress and nothing else, then one that holds the bar's end.
    let tress = avatar.skin.position.iter().map(|p| p.x).fold(0.0, f64::max);
    assert!(tress > LENGTH + 0.05);
    for (place, touches) in [(tress, false), (LENGTH, true)] {
        let frame = Frame {
            position: DVec3::new(place, if touches { 0.0 } else { 0.06 }, 0.0),
            ..Frame::IDENTITY
        };
        let potential = CpuPotential::new(Arc::new(avatar.clone()), 1).unwrap();
        let mut simulation = Simulation::new(&avatar, potential, Settings::default()).unwrap();
        simulation.instances_mut()[0].colliders.push(Collider {
            stiffness: Some(1e6),
            ..Collider::new(Shape::Sphere { radius: 0.03 }, frame)
        });
        let report = simulation.step_blocking().unwrap().instances.remove(0);
        assert_eq!(report.contacts > 0, touches, "{} contacts", report.contacts);
    }
}

#[test]
fn bones_of_hair_are_carried_and_have_no_forces() {
    let body = check_rest(&dressed().glb());
    let (avatar, _) = bake(&body, &Recipe::default(), &mut |_| ()).unwrap();
    let carried: Vec<bool> = (0..avatar.skeleton.len())
        .map(|j| avatar.is_carried(j))
        .collect();
    assert_eq!(carried, [false, false, false, true]);
    let simulation = |avatar: &supple::model::Avatar| {
        let potential = CpuPotential::new(Arc::new(avatar.clone()), 1).unwrap();
        Simulation::new(avatar, potential, Settings::default()).unwrap()
    };
    // The same bar without tress, and so without its bone.
    let mut bare = body.clone();
    bare.attachments.retain(|a| a.name != "tress");
    bare.render_meshes.clear();
    let (bare, _) = bake(&bare, &Recipe::default(), &mut |_| ()).unwrap();
    assert_eq!(bare.skeleton.len(), 3);

    // Falling, and then drawn to targets of which the tress' is turned against its parent's.
    let (mut worn, mut plain) = (simulation(&avatar), simulation(&bare));
    let local = |frames: &[Frame]| frames[2].rotation.transpose() * frames[3].rotation;
    for step in 0..20 {
        let turned = DMat4::from_quat(DQuat::from_rotation_x(0.7));
        let turn = glam::DMat3::from_mat4(turned);
        for simulation in [&mut worn, &mut plain].into_iter().filter(|_| step >= 10) {
            let instance = &mut simulation.instances_mut()[0];
            let frames = instance.state.frames.clone();
            let target = |(bone, frame): (usize, &Frame)| {
                let mut frame = Frame {
                    position: frame.position + DVec3::Z * 0.01,
                    ..*frame
                };
                if bone == 3 {
                    frame.rotation = frames[2].rotation * turn;
                }
                let rotation = Some(Spring {
                    stiffness: 50.0,
                    damping: 0.5,
                });
                let position = Some(Spring {
                    stiffness: 500.0,
                    damping: 5.0,
                });
                Tracking {
                    rotation,
                    position,
                    ..Tracking::new(bone, frame)
                }
            };
            instance.targets = frames.iter().enumerate().map(target).collect();
        }
        let [a, b] = [&mut worn, &mut plain].map(|s| {
            s.step_blocking().unwrap();
            s.instances()[0].state.clone()
        });
        // Nothing that has mass knows of the tress.
        assert_eq!((&a.frames[..3], &a.handles), (&b.frames[..], &b.handles));
        let expected = if step < 10 {
            glam::DMat3::IDENTITY
        } else {
            turn
        };
        assert!(local(&a.frames).abs_diff_eq(expected, 1e-9), "step {step}");
        let offset = avatar.skeleton.joints[3] - avatar.skeleton.joints[2];
        let joint = a.frames[2].transform(offset);
        let gap = joint.distance(a.frames[3].position);
        assert!(gap < 1e-9, "step {step}: {gap}");
    }
}

#[test]
fn joints_that_carry_nothing_ride() {
    let mut file = bar_file(&BarFile::default());
    let mut joints = vec![1, 2, 3];
    for k in 0..40 {
        let parent = if k % 5 == 0 {
            3
        } else {
            *joints.last().unwrap()
        };
        let place = json!({"name": format!("extra {k}"), "translation": [0, 0.01, 0]});
        let node = file.push("nodes", place);
        match file.json["nodes"][parent]["children"].as_array_mut() {
            Some(children) => children.push(json!(node)),
            None => file.json["nodes"][parent]["children"] = json!([node]),
        }
        joints.push(node);
    }
    let bind = joint_worlds(DAffine3::IDENTITY, &[DQuat::IDENTITY; BONES]);
    let below =
        |k: usize| bind[2] * DAffine3::from_translation(DVec3::Y * 0.01 * (k % 5 + 1) as f64);
    let worlds: Vec<DAffine3> = bind.into_iter().chain((0..40).map(below)).collect();
    let inverse: Vec<DMat4> = worlds.iter().map(|w| w.inverse().into()).collect();
    let inverse = file.matrices(&inverse);
    file.json["skins"][0] = json!({"joints": joints, "inverseBindMatrices": inverse});

    let of = |file: &Fixture| {
        let body = parse_gltf(&file.glb(), "bar.glb")
            .unwrap()
            .body(&[])
            .unwrap();
        bake(&body, &Recipe::default(), &mut |_| ()).unwrap().0
    };
    let (many, plain) = (of(&file), of(&bar_file(&BarFile::default())));
    assert_eq!(many.joints.len(), 43);
    assert_eq!(many.skeleton.names, plain.skeleton.names);
    // They stand where the file has them, and are taken as well.
    let mut matrices = Vec::new();
    many.joints
        .joint_matrices(&many.rest_state().frames, &mut matrices)
        .unwrap();
    for (found, expected) in matrices.iter().zip(&worlds) {
        let distance = found
            .as_dmat4()
            .w_axis
            .truncate()
            .distance(expected.translation);
        assert!(distance < 1e-6, "{distance}");
    }
    let mut frames = Vec::new();
    many.joints
        .frames_from_world(&many.skeleton, &matrices, &mut frames)
        .unwrap();
    assert_eq!(frames.len(), 3);

    // A motion of it has a node for each joint.
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("out.glb");
    let recording = Recording {
        times: vec![0.0],
        states: vec![many.rest_state()],
        ..Recording::default()
    };
    write_glb(&many, &recording, &path).unwrap();
    let written = gltf::Gltf::open(&path).unwrap();
    let extra = |n: &gltf::Node<'_>| n.name().is_some_and(|name| name.starts_with("extra"));
    assert_eq!(written.nodes().filter(extra).count(), 40);
}
