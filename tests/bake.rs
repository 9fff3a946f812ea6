//! Baking: a limb and a finger from mesh to file.

use glam::DVec3;
use std::path::Path;
use supple::bake::{
    BakeCost, BakeReport, CubatureRecipe, HandlePlace, HandleRegion, Recipe, Truncation, all_tets,
    bake, from_bytes, full_space, read_avatar, read_baked, to_bytes, write_avatar, write_baked,
};
use supple::math::Random;
use supple::model::{Avatar, Body, PointSet, PoseBlend, SkinWeight};
use supple::sample::{Finger, Limb, hand};
use supple::{Error, glam};

/// A limb small enough for a file of a few kilobytes.
const TINY: Limb = Limb {
    length: 0.06,
    inner_radius: 0.015,
    outer_radius: 0.04,
    stations: 3,
    layers: 2,
    sectors: 6,
};

fn recipe(place: HandlePlace, count: usize) -> Recipe {
    Recipe {
        handles: vec![HandleRegion {
            place,
            count: Some(count),
            ..Default::default()
        }],
        ..Default::default()
    }
}

fn untruncated(recipe: Recipe) -> Recipe {
    Recipe {
        truncation: Truncation::OFF,
        ..recipe
    }
}

fn baked(body: &Body, recipe: &Recipe) -> Avatar {
    bake(body, recipe, &mut |_| {}).unwrap().0
}

fn tiny() -> (Avatar, BakeReport) {
    let recipe = recipe(HandlePlace::Skin, 8);
    bake(&TINY.body().unwrap(), &recipe, &mut |_| {}).unwrap()
}

/// ∇(Σ_h U_h f(X_h)) and Σ_h U_h f(X_h) at a point, for the linear f with gradient `direction`.
fn interpolated(avatar: &Avatar, points: &PointSet, i: usize, direction: DVec3) -> (f64, DVec3) {
    let row = points.basis.row(i).iter();
    row.map(|u| (u, direction.dot(avatar.handles[u.handle as usize])))
        .fold((0.0, DVec3::ZERO), |(value, gradient), (u, f)| {
            (value + u.value * f, gradient + u.gradient * f)
        })
}

#[test]
fn a_limb_bakes_with_handles_on_its_skin_and_in_its_volume() {
    let body = Limb::S.body().unwrap();
    for (place, count) in [(HandlePlace::Skin, 82), (HandlePlace::Volume, 160)] {
        let mut phases = Vec::new();
        let (avatar, report) = bake(&body, &recipe(place, count), &mut |p| phases.push(p)).unwrap();
        println!("{}", serde_json::to_string_pretty(&report).unwrap());
        assert_eq!(phases, [0, 1, 2, 3, 4, 5, 6]);
        assert_eq!(
            (
                report.mesh.quality.nodes,
                report.mesh.quality.tets,
                report.handles.count
            ),
            (2080, 7500, count)
        );
        let volume = body.layer.tissue_volume();
        let sum: f64 = avatar.cubature.measure.iter().sum();
        assert!((sum / volume - 1.0).abs() < 1e-12, "{sum} of {volume}");
        assert!(
            report.basis.linear_precision < 1e-9,
            "{:e}",
            report.basis.linear_precision
        );
        assert!(
            report.cubature.points * 10 > count * 5,
            "{:?}",
            report.cubature
        );
        assert!(
            (0.01..0.4).contains(&report.basis.truncation_cost),
            "{}",
            report.basis.truncation_cost
        );
        // The rigid core: a prism over a regular polygon.
        let core = 0.5 * 20.0 * (std::f64::consts::TAU / 20.0).sin() * 0.015f64.powi(2) * 0.25;
        assert!(
            (report.bones.total / (1000.0 * core) - 1.0).abs() < 0.02,
            "{:?}",
            report.bones
        );
    }
}

#[test]
fn handles_move_what_they_stand_on_and_bones_hold_what_is_theirs() {
    let body = Limb::S.body().unwrap();
    let avatar = baked(&body, &untruncated(recipe(HandlePlace::Skin, 40)));
    for (h, &place) in avatar.handles.iter().enumerate() {
        let vertex = avatar
            .skin
            .position
            .iter()
            .position(|&x| x == place)
            .unwrap();
        for u in avatar.skin.basis.row(vertex) {
            let expected = f64::from(u8::from(u.handle as usize == h));
            assert!(
                (u.value - expected).abs() < 1e-9,
                "U_{} at handle {h}: {}",
                u.handle,
                u.value
            );
        }
    }
    for (node, bone) in avatar.layer.bone_of_node.iter().enumerate() {
        assert!(bone.is_none() || avatar.layer.basis.row(node).is_empty());
    }
}

#[test]
fn the_gradient_is_that_of_the_value() {
    // U is linear in a tet: from one corner to the centroid it grows by ∇U · (step).
    let body = TINY.body().unwrap();
    let avatar = all_tets(&baked(&body, &recipe(HandlePlace::Skin, 8))).unwrap();
    let layer = &avatar.layer;
    let mut seen = 0;
    for (t, tet) in layer.mesh.tets.iter().enumerate() {
        for u in avatar.cubature.basis.row(t) {
            for &node in tet {
                let row = layer.basis.row(node as usize).iter();
                let at_node: f64 = row.filter(|e| e.0 == u.handle).map(|e| e.1).sum();
                let step = layer.mesh.nodes[node as usize] - avatar.cubature.position[t];
                assert!((u.value + u.gradient.dot(step) - at_node).abs() < 1e-12);
                seen += 1;
            }
        }
    }
    assert!(seen > 1000);
}

#[test]
fn the_full_space_has_every_free_node_as_a_handle() {
    let body = Limb::S.body().unwrap();
    let avatar = baked(&body, &recipe(HandlePlace::Skin, 20));
    let full = full_space(&avatar).unwrap();
    full.validate().unwrap();
    let free = body
        .layer
        .bone_of_node
        .iter()
        .filter(|b| b.is_none())
        .count();
    assert_eq!((full.handles.len(), full.cubature.len()), (free, 7500));
    let volume = body.layer.tissue_volume();
    assert!((full.cubature.measure.iter().sum::<f64>() / volume - 1.0).abs() < 1e-12);
    // Hat functions reproduce linear fields wherever no bone node takes part.
    let direction = DVec3::new(3.0, -2.0, 5.0);
    let mut free_tets = 0;
    for (t, tet) in full.layer.mesh.tets.iter().enumerate() {
        if tet
            .iter()
            .all(|&n| full.layer.bone_of_node[n as usize].is_none())
        {
            let (value, gradient) = interpolated(&full, &full.cubature, t, direction);
            assert!((value - direction.dot(full.cubature.position[t])).abs() < 1e-12);
            assert!((gradient - direction).length() < 1e-9);
            free_tets += 1;
        }
    }
    assert!(free_tets > 4000);
    for v in 0..full.skin.len() {
        let (value, _) = interpolated(&full, &full.skin, v, direction);
        assert!((value - direction.dot(full.skin.position[v])).abs() < 1e-12);
    }
}

/// A finger of three bones whose pose directions are smooth over its skin.
fn blended_finger() -> Body {
    let mut body = Finger::default().body().unwrap();
    let column = |k: usize, x: &DVec3| {
        let wave = (0.3 * k as f64 + 60.0 * x.x).sin();
        (1e-3 * DVec3::new(wave, 0.5, 40.0 * x.y))
            .as_vec3()
            .to_array()
    };
    body.pose_blend = PoseBlend {
        features: 18,
        columns: (0..18)
            .flat_map(|k| body.skin.positions.iter().map(move |x| column(k, x)))
            .collect(),
    };
    body
}

#[test]
fn pose_blend_shapes_reach_the_points_from_the_skin() {
    let body = blended_finger();
    let avatar = baked(&body, &recipe(HandlePlace::Skin, 20));
    let blend = &avatar.cubature.pose_blend;
    assert_eq!(
        (blend.features, blend.columns.len()),
        (18, 18 * avatar.cubature.len())
    );
    // The y component is 0.5 mm all over the skin and 0 on the bones: in between inside.
    let inside = blend.columns.iter().map(|c| f64::from(c[1]));
    let (low, high) = inside.fold((1.0, 0.0), |(l, h): (f64, f64), y| (l.min(y), h.max(y)));
    assert!(
        low > 0.0 && high < 0.5e-3 * 1.01 && high - low > 0.2e-3,
        "{low} {high}"
    );
    // The same tets have the same columns where every tet is a point.
    let whole = all_tets(&avatar).unwrap();
    let full = full_space(&avatar).unwrap();
    assert_eq!(whole.cubature.pose_blend, full.cubature.pose_blend);
    for (i, x) in avatar.cubature.position.iter().enumerate() {
        let t = whole.cubature.position.iter().position(|y| y == x).unwrap();
        assert_eq!(
            avatar.cubature.skinning.row(i),
            whole.cubature.skinning.row(t)
        );
        assert_eq!(avatar.cubature.basis.row(i), whole.cubature.basis.row(t));
        for k in 0..18 {
            let (a, b) = (i + k * avatar.cubature.len(), t + k * whole.cubature.len());
            assert_eq!(blend.columns[a], whole.cubature.pose_blend.columns[b]);
        }
    }
}

#[test]
fn skin_weights_inside_a_finger_follow_the_skin_and_the_bones() {
    let body = blended_finger();
    let avatar = baked(&body, &recipe(HandlePlace::Skin, 20));
    // The skin keeps the file's own weights, whatever they are.
    assert_eq!(avatar.skin.skinning, body.skinning);
    let layer = &avatar.layer;
    for (v, nodes) in layer.skin_embedding.iter().enumerate() {
        for w in body.skinning.row(v).iter().filter(|w| w.weight > 1e-3) {
            let row = layer.skinning.row(nodes[0].0 as usize);
            let found = row
                .iter()
                .find(|n| n.bone == w.bone)
                .map_or(0.0, |n| n.weight);
            assert!((found - w.weight).abs() < 2e-3, "{found} {}", w.weight);
        }
    }
    for (node, bone) in layer.bone_of_node.iter().enumerate() {
        if let Some(bone) = *bone {
            let own = SkinWeight { bone, weight: 1.0 };
            assert_eq!(layer.skinning.row(node), [own]);
        }
    }
}

#[test]
fn same_input_same_bytes_whatever_the_threads() {
    let body = Limb::S.body().unwrap();
    let recipe = recipe(HandlePlace::Skin, 30);
    let once = to_bytes(&baked(&body, &recipe), None).unwrap();
    assert!(once == to_bytes(&baked(&body, &recipe), None).unwrap());
    #[cfg(feature = "threads")]
    for threads in [1, 3] {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        assert!(once == pool.install(|| to_bytes(&baked(&body, &recipe), None).unwrap()));
    }
}

#[test]
fn a_file_comes_back_as_it_was_written() {
    let (avatar, mut report) = tiny();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("limb.supple");
    write_avatar(&avatar, &path).unwrap();
    assert_eq!(read_baked(&path).unwrap().report, None);
    write_baked(&avatar, &report, &path).unwrap();
    assert_eq!(read_avatar(&path).unwrap(), avatar);
    // The report is kept but for what the bake took.
    report.cost = BakeCost::default();
    assert_eq!(read_baked(&path).unwrap().report, Some(report));
    // Nothing else is left beside it.
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    let nowhere = folder.path().join("missing").join("limb.supple");
    assert!(matches!(
        write_avatar(&avatar, &nowhere),
        Err(Error::Io { .. })
    ));
    assert!(matches!(read_avatar(&nowhere), Err(Error::Io { .. })));
}

fn problem(bytes: &[u8]) -> String {
    let error = from_bytes(bytes, Path::new("limb.supple")).unwrap_err();
    assert!(matches!(error, Error::Format { .. }), "{error:?}");
    error.to_string()
}

#[test]
fn a_file_cut_anywhere_is_an_error() {
    let avatar = baked(&TINY.body().unwrap(), &recipe(HandlePlace::Skin, 8));
    let bytes = to_bytes(&avatar, None).unwrap();
    for length in 0..bytes.len() {
        problem(&bytes[..length]);
    }
    let longer = [bytes.as_slice(), &[0]].concat();
    assert!(problem(&longer).contains("payload"));
    assert_eq!(
        from_bytes(&bytes, Path::new("limb.supple")).unwrap().avatar,
        avatar
    );
}

#[test]
fn every_flipped_bit_is_an_error() {
    let avatar = baked(&TINY.body().unwrap(), &recipe(HandlePlace::Skin, 8));
    let bytes = to_bytes(&avatar, None).unwrap();
    let mut random = Random::new(5);
    // All of the header, and some of the rest.
    let header = 0..24 * 8;
    let rest = (0..300).map(|_| random.index(bytes.len() * 8));
    for bit in header.chain(rest) {
        let mut flipped = bytes.clone();
        flipped[bit / 8] ^= 1 << (bit % 8);
        problem(&flipped);
    }
}

#[test]
fn a_forged_checksum_does_not_get_nonsense_in() {
    // Whoever recomputes the checksum of a changed payload gets a typed error or a valid avatar.
    let (avatar, report) = tiny();
    let bytes = to_bytes(&avatar, Some(&report)).unwrap();
    let mut random = Random::new(6);
    let mut refused = 0;
    for _ in 0..2000 {
        let mut forged = bytes.clone();
        for _ in 0..1 + random.index(4) {
            let at = 24 + random.index(forged.len() - 24);
            forged[at] = random.index(256) as u8;
        }
        let mut hasher = crc32fast::Hasher::new();
        hasher.update(&forged[8..12]);
        hasher.update(&forged[16..]);
        forged[12..16].copy_from_slice(&hasher.finalize().to_le_bytes());
        match from_bytes(&forged, Path::new("limb.supple")) {
            Ok(baked) => baked.avatar.validate().unwrap(),
            Err(Error::Format { .. }) => refused += 1,
            Err(other) => panic!("{other:?}"),
        }
    }
    assert!(refused > 20, "{refused}");
}

#[test]
fn foreign_and_newer_files_are_named() {
    let avatar = baked(&TINY.body().unwrap(), &recipe(HandlePlace::Skin, 8));
    let bytes = to_bytes(&avatar, None).unwrap();
    assert!(problem(b"glTF\x02\0\0\0 something else altogether").contains("not a baked avatar"));
    let mut newer = bytes.clone();
    newer[8] += 1;
    assert!(problem(&newer).contains("update supple"));
    newer[8] = 0;
    assert!(problem(&newer).contains("bake it again"));
}

#[test]
fn bad_recipes_and_bodies_are_typed_errors() {
    let body = Limb::S.body().unwrap();
    let error =
        |body: &Body, recipe: &Recipe| bake(body, recipe, &mut |_| {}).unwrap_err().to_string();
    let region = |change: fn(&mut HandleRegion)| {
        let mut recipe = recipe(HandlePlace::Skin, 8);
        change(&mut recipe.handles[0]);
        recipe
    };
    type Change = fn(&mut HandleRegion);
    let cases: [(Change, &str); 9] = [
        (|r| r.bones = vec!["elbow".into()], "there are bone"),
        (|r| r.painted = Some("belly".into()), "handles[0].painted"),
        (|r| r.soft = -1.0, "handles[0].soft"),
        (|r| r.vertices = vec![9999], "handles[0].vertices"),
        (|r| r.within = Some([[9.0; 3], [10.0; 3]]), "no soft place"),
        (|r| r.spacing = Some(0.1), "not both"),
        (|r| r.count = Some(0), "positive count"),
        (
            |r| {
                *r = HandleRegion {
                    place: HandlePlace::Points,
                    points: vec![[0.1, 0.0, 0.0]],
                    ..Default::default()
                }
            },
            "outside the layer",
        ),
        (
            |r| {
                *r = HandleRegion {
                    place: HandlePlace::Points,
                    points: vec![[0.1, 0.03, 0.0]; 2],
                    ..Default::default()
                }
            },
            "two handles",
        ),
    ];
    for (change, expected) in cases {
        let message = error(&body, &region(change));
        assert!(message.contains(expected), "{message:?} lacks {expected:?}");
    }
    let mut orphan = body.clone();
    orphan.layer.mesh.nodes.push(DVec3::ZERO);
    orphan.layer.bone_of_node.push(None);
    assert!(error(&orphan, &recipe(HandlePlace::Skin, 8)).contains("belongs to no tet"));
    // With no layer the skin is meshed, but there must be one.
    let mut empty = body;
    empty.layer = Default::default();
    empty.skin.triangles.clear();
    assert!(error(&empty, &recipe(HandlePlace::Skin, 8)).contains("skin"));
}

#[test]
fn points_inside_tets_are_handles_too() {
    let body = Limb::S.body().unwrap();
    let points = [
        [0.101, 0.0, 0.031],
        [0.143, 0.027, -0.004],
        [0.05, -0.03, 0.0023],
    ];
    let recipe = untruncated(Recipe {
        handles: vec![HandleRegion {
            place: HandlePlace::Points,
            points: points.to_vec(),
            ..Default::default()
        }],
        ..Default::default()
    });
    let avatar = baked(&body, &recipe);
    let mesh = &avatar.layer.mesh;
    for (h, &p) in avatar.handles.iter().enumerate() {
        let inside = |&t: &usize| mesh.barycentric(t, p).iter().all(|&s| s >= -1e-12);
        let t = (0..mesh.tets.len()).find(inside).unwrap();
        let mut at_point = vec![0.0; points.len()];
        for (&n, share) in mesh.tets[t].iter().zip(mesh.barycentric(t, p)) {
            for &(handle, u) in avatar.layer.basis.row(n as usize) {
                at_point[handle as usize] += share * u;
            }
        }
        for (k, u) in at_point.iter().enumerate() {
            assert!(
                (u - f64::from(u8::from(k == h))).abs() < 1e-9,
                "U_{k} at handle {h}: {u}"
            );
        }
    }
}

/// A layer of the hand's size: 20,328 nodes, 85,800 tets, 87 handles and 700 points.
#[test]
fn a_layer_of_twenty_thousand_nodes_bakes_in_half_a_minute() {
    let limb = Limb {
        stations: 65,
        layers: 6,
        sectors: 44,
        ..Limb::S
    };
    let mut recipe = recipe(HandlePlace::Skin, 87);
    recipe.cubature.points = Some(700);
    let body = limb.body().unwrap();
    let start = std::time::Instant::now();
    let (_, report) = bake(&body, &recipe, &mut |_| {}).unwrap();
    println!("{:?}\n{:?}", report.cubature, report.cost.seconds);
    assert_eq!(
        (report.mesh.quality.nodes, report.handles.count),
        (20328, 87)
    );
    assert!(start.elapsed().as_secs() < 30, "{:?}", report.cost.seconds);
}

/// The sample hand: a lattice of 20,000 nodes, 87 handles over palm and pads, 700 points.
#[test]
fn the_sample_hand_bakes_in_half_a_minute() {
    let sample = hand().unwrap();
    let palmar = (0..)
        .zip(&sample.palmar)
        .filter(|(_, p)| **p)
        .map(|(v, _)| v);
    let recipe = Recipe {
        handles: vec![HandleRegion {
            vertices: palmar.collect(),
            count: Some(87),
            ..Default::default()
        }],
        cubature: CubatureRecipe {
            points: Some(700),
            ..Default::default()
        },
        ..Default::default()
    };
    let body = Body::of_model("hand", &sample.model, &[], sample.bones);
    let start = std::time::Instant::now();
    let (avatar, report) = bake(&body, &recipe, &mut |_| {}).unwrap();
    let seconds = start.elapsed().as_secs_f64();
    println!(
        "{seconds:.1} s {}",
        serde_json::to_string_pretty(&report).unwrap()
    );
    println!("{} bytes", to_bytes(&avatar, None).unwrap().len());
    assert!(seconds < 30.0, "{:?}", report.cost.seconds);
    assert_eq!((report.handles.count, avatar.skeleton.len()), (87, 16));
    assert!(
        report.basis.linear_precision < 1e-9,
        "{:e}",
        report.basis.linear_precision
    );
    assert!((report.cubature.weight_sum / report.cubature.volume - 1.0).abs() < 1e-12);
    assert!(!report.cubature.all_tets, "{:?}", report.cubature);
    assert_eq!(avatar.cubature.pose_blend.features, 135);
    // Weights inside meet those on the skin, to what a cell of 4 mm resolves.
    let layer = &avatar.layer;
    let mut errors: Vec<f64> = (0..avatar.skin.len())
        .map(|v| {
            let inside = |bone: u32| -> f64 {
                let at_node = |&(node, share): &(u32, f64)| {
                    let row = layer.skinning.row(node as usize).iter();
                    let weights = row.filter(|w| w.bone == bone).map(|w| w.weight);
                    share * weights.sum::<f64>()
                };
                layer.skin_embedding.row(v).iter().map(at_node).sum()
            };
            let row = body.skinning.row(v).iter();
            row.map(|w| (w.weight - inside(w.bone)).abs())
                .fold(0.0, f64::max)
        })
        .collect();
    errors.sort_by(f64::total_cmp);
    let (median, late) = (errors[errors.len() / 2], errors[errors.len() * 99 / 100]);
    println!("skin weights inside: median error {median:.4}, 99 % below {late:.4}");
    assert!(median < 0.005 && late < 0.05, "{median} {late}");
    // Skin minus bones; the wrist's bones stick out of nothing, so both are closed surfaces.
    let bones: f64 = body.bone_surfaces.iter().map(|b| b.volume()).sum();
    let volume = body.skin.volume() - bones;
    assert!(
        (report.cubature.volume / volume - 1.0).abs() < 0.02,
        "{} {volume}",
        report.cubature.volume
    );
    assert_eq!(
        (report.bones.from_surfaces, report.bones.raised),
        (16, 0),
        "{:?}",
        report.bones
    );
}
