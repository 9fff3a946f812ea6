//! What reaches the inside of the layer from the skin: skin weights and pose blend shapes.

use super::{baked, recipe};
use glam::DVec3;
use supple::internal::cpu::pose_blend::pose_offset;
use supple::model::{PoseBlend, PoseOffsets, SkinWeight};
use supple_bake::{Body, HandleCandidates, all_tets, full_space, without_tissue};
use supple_samples::Finger;

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
    let avatar = baked(&body, &recipe(HandleCandidates::Skin, 20));
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

/// E · column against the column that was extended as a whole. A row loses 5e-3 at most, and its kept entries take as much:
/// twice that of the largest value on the skin, 1.1 mm.
#[test]
fn the_extension_of_offsets_is_that_of_pose_blend_shapes() {
    let body = blended_finger();
    let avatar = baked(&body, &recipe(HandleCandidates::Skin, 20));
    let (blend, points) = (&avatar.cubature.pose_blend, avatar.cubature.len());
    let mut worst = 0.0f64;
    for k in 0..blend.features {
        let offsets = &body.pose_blend.columns[k * avatar.skin.len()..][..avatar.skin.len()];
        for i in 0..points {
            let found = pose_offset(avatar.pose_extension.row(i), offsets);
            let wanted = DVec3::from(blend.columns[k * points + i].map(f64::from));
            worst = worst.max(found.distance(wanted));
        }
        // What is the same all over the skin loses nothing but what f32 rounds: y is.
        for i in 0..points {
            let found = pose_offset(avatar.pose_extension.row(i), offsets).y;
            let wanted = f64::from(blend.columns[k * points + i][1]);
            let roundings = avatar.pose_extension.row(i).len() as f64 + 2.0;
            assert!((found - wanted).abs() < roundings * 2f64.powi(-24) * 0.5e-3);
        }
    }
    println!("{worst:e} m");
    assert!(worst < 1e-2 * 1.1e-3, "{worst:e} m");
    let longest = avatar.pose_extension.longest();
    assert!(longest > 3 && longest < avatar.skin.len() / 2, "{longest}");
}

#[test]
fn spaces_with_other_points_take_no_offsets() {
    let avatar = baked(&blended_finger(), &recipe(HandleCandidates::Skin, 20));
    let offsets = vec![[1e-3; 3]; avatar.offset_vertices()];
    let mut held = PoseOffsets::default();
    for space in [all_tets(&avatar).unwrap(), full_space(&avatar).unwrap()] {
        let error = held.set(&space, &offsets).unwrap_err().to_string();
        assert!(error.contains("a full space"), "{error}");
    }
    held.set(&without_tissue(&avatar), &offsets).unwrap();
    assert_eq!(held.as_slice(), offsets);
}

#[test]
fn skin_weights_inside_a_finger_follow_the_skin_and_the_bones() {
    let body = blended_finger();
    let avatar = baked(&body, &recipe(HandleCandidates::Skin, 20));
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
