//! What reaches the inside of the layer from the skin: skin weights and pose blend shapes.

use super::{baked, recipe};
use glam::DVec3;
use supple::model::{PoseBlend, SkinWeight};
use supple_bake::{Body, HandleCandidates, all_tets, full_space};
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
