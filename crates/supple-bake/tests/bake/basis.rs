//! U of the baked handles: on the skin, in the volume, at points inside tets, in the full space.

use super::{TINY, baked, recipe, untruncated};
use glam::DVec3;
use supple::model::{Avatar, PointSet};
use supple_bake::{HandleCandidates, HandleRegion, PHASES, Recipe, all_tets, bake, full_space};
use supple_samples::Limb;

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
    for (candidates, count) in [
        (HandleCandidates::Skin, 82),
        (HandleCandidates::Volume, 160),
    ] {
        let mut phases = Vec::new();
        let (avatar, report) =
            bake(&body, &recipe(candidates, count), &mut |p| phases.push(p)).unwrap();
        println!("{}", serde_json::to_string_pretty(&report).unwrap());
        assert!(phases.into_iter().eq(0..=PHASES.len()));
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
    let avatar = baked(&body, &untruncated(recipe(HandleCandidates::Skin, 40)));
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
    let avatar = all_tets(&baked(&body, &recipe(HandleCandidates::Skin, 8))).unwrap();
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
    let avatar = baked(&body, &recipe(HandleCandidates::Skin, 20));
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
            candidates: HandleCandidates::Points,
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
