//! What a recipe or a body may not say.

use super::recipe;
use glam::DVec3;
use supple_bake::{Body, HandleCandidates, HandleRegion, Recipe, bake};
use supple_samples::Limb;

#[test]
fn bad_recipes_and_bodies_are_typed_errors() {
    let body = Limb::S.body().unwrap();
    let error =
        |body: &Body, recipe: &Recipe| bake(body, recipe, &mut |_| {}).unwrap_err().to_string();
    let region = |change: fn(&mut HandleRegion)| {
        let mut recipe = recipe(HandleCandidates::Skin, 8);
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
                    candidates: HandleCandidates::Points,
                    points: vec![[0.1, 0.0, 0.0]],
                    ..Default::default()
                }
            },
            "outside the layer",
        ),
        (
            |r| {
                *r = HandleRegion {
                    candidates: HandleCandidates::Points,
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
    assert!(error(&orphan, &recipe(HandleCandidates::Skin, 8)).contains("belongs to no tet"));
    // With no layer the skin is meshed, but there must be one.
    let mut empty = body;
    empty.layer = Default::default();
    empty.skin.triangles.clear();
    assert!(error(&empty, &recipe(HandleCandidates::Skin, 8)).contains("skin"));
}
