//! Layers of the paper's size.

use super::recipe;
use supple_bake::{Body, CubatureRecipe, HandleCandidates, HandleRegion, Recipe, bake, to_bytes};
use supple_samples::{Limb, hand};

/// A layer of the hand's size: 20,328 nodes, 85,800 tets, 87 handles and 700 points.
#[test]
fn a_layer_of_twenty_thousand_nodes_bakes() {
    let limb = Limb {
        stations: 65,
        layers: 6,
        sectors: 44,
        ..Limb::S
    };
    let mut recipe = recipe(HandleCandidates::Skin, 87);
    recipe.cubature.points = Some(700);
    let body = limb.body().unwrap();
    let (_, report) = bake(&body, &recipe, &mut |_| {}).unwrap();
    println!("{:?}\n{:?}", report.cubature, report.cost.seconds);
    assert_eq!(
        (report.mesh.quality.nodes, report.handles.count),
        (20328, 87)
    );
}

/// The sample hand: a lattice of 20,000 nodes, 87 handles over palm and pads, 700 points.
#[test]
fn the_sample_hand_bakes() {
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
    let (avatar, report) = bake(&body, &recipe, &mut |_| {}).unwrap();
    println!("{}", serde_json::to_string_pretty(&report).unwrap());
    println!("{} bytes", to_bytes(&avatar, None).unwrap().len());
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
