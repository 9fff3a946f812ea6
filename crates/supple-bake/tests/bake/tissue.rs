//! What a bake gives each point of the tissue: axes that follow the body, and a stiffness by region.

use supple::glam::{DMat3, DVec3};
use supple::model::Avatar;
use supple_bake::{
    Body, Recipe, StiffnessRegion, all_tets, bake, from_bytes, full_space, to_bytes,
};
use supple_samples::Limb;

fn limb() -> Body {
    let mut body = Limb::S.body().unwrap();
    // 1 on the upper half of the skin, 0 below.
    let painted = body.skin.positions.iter().map(|p| f64::from(p.z > 0.0));
    body.painted = [("upper".to_owned(), painted.collect())].into();
    body
}

fn baked(stiffness: Vec<StiffnessRegion>) -> Avatar {
    let recipe: Recipe = toml::from_str("handles = [{ count = 12 }]").unwrap();
    let recipe = Recipe {
        stiffness,
        ..recipe
    };
    bake(&limb(), &recipe, &mut |_| {}).unwrap().0
}

fn region(text: &str) -> StiffnessRegion {
    toml::from_str(text).unwrap()
}

#[test]
fn axes_follow_skin_and_bone() {
    let avatar = baked(Vec::new());
    assert_eq!(avatar.tissue.len(), avatar.cubature.len());
    let mesh = &avatar.layer.mesh;
    for (t, tissue) in avatar.layer.tissue.iter().enumerate() {
        assert_eq!(tissue.stiffness, 1.0);
        // The limb is a cylinder about x, cut into 20 sectors of 18°, half of one across.
        let centre = mesh.centroid(t);
        let radial = DVec3::new(0.0, centre.y, centre.z).normalize();
        let axes = DMat3::from_quat(tissue.axes);
        assert!(
            axes.x_axis.dot(radial) > 9f64.to_radians().cos(),
            "{centre}: {}",
            axes.x_axis
        );
        assert!(axes.y_axis.x.abs() > 0.95, "{centre}: {}", axes.y_axis);
        assert!((axes.determinant() - 1.0).abs() < 1e-12);
    }
}

#[test]
fn regions_scale_the_stiffness() {
    let avatar = baked(vec![
        region("scale = 4.0\nwithin = [[0.0, -1.0, -1.0], [0.1, 1.0, 1.0]]"),
        region("scale = 0.25\npainted = \"upper\""),
        region(&format!(
            "scale = 3.0\nbones = [{:?}]",
            limb().skeleton.names[0]
        )),
    ]);
    let (mut below, mut above) = (0, 0);
    for (t, tissue) in avatar.layer.tissue.iter().enumerate() {
        let centre = avatar.layer.mesh.centroid(t);
        let boxed = if centre.x <= 0.1 { 4.0 } else { 1.0 };
        // Everything follows the one bone.
        let share = (tissue.stiffness / (3.0 * boxed)).ln() / 0.25f64.ln();
        assert!((-1e-9..=1.0 + 1e-9).contains(&share), "{share}");
        // The map fades over a sector of 18°, and the more the deeper: two sectors away it is itself again.
        let up = centre.z / centre.y.hypot(centre.z);
        if up < -36f64.to_radians().sin() {
            below += 1;
            assert!(share < 0.1, "{centre} {share}");
        } else if up > 36f64.to_radians().sin() {
            above += 1;
            assert!(share > 0.9, "{centre} {share}");
        }
    }
    assert!(below > 1000 && above > 1000);

    let everywhere = all_tets(&avatar).unwrap();
    assert_eq!(everywhere.tissue, avatar.layer.tissue);
    let full = full_space(&avatar).unwrap();
    assert_eq!(full.tissue, avatar.layer.tissue);
    let bytes = to_bytes(&avatar, None).unwrap();
    assert_eq!(
        from_bytes(&bytes, "limb.supple".as_ref()).unwrap().avatar,
        avatar
    );
}

#[test]
fn regions_that_name_what_is_not_there_are_refused() {
    let failed = |text: &str| {
        let recipe: Recipe = toml::from_str(&format!(
            "handles = [{{ count = 12 }}]\n[[stiffness]]\n{text}"
        ))
        .unwrap();
        bake(&limb(), &recipe, &mut |_| {}).unwrap_err().to_string()
    };
    assert!(failed("scale = 2.0\nbones = [\"wing\"]").contains("stiffness[0].bones"));
    let message = failed("scale = 2.0\npainted = \"lower\"");
    assert!(
        message.contains("stiffness[0].painted") && message.contains("upper"),
        "{message}"
    );
    assert!(failed("scale = 0.0").contains("stiffness[0].scale"));
    let error = toml::from_str::<Recipe>("[[stiffness]]\nfactor = 2.0")
        .unwrap_err()
        .to_string();
    assert!(error.contains("factor"), "{error}");
}

/// k = 100 E/L under each vertex: of the limb, whose depth is 25 mm all around, twice as much where it is twice as stiff.
#[test]
fn contact_is_as_stiff_as_the_tissue_under_it() {
    let depth = Limb::S.outer_radius - Limb::S.inner_radius;
    let recipe = |scale: f64| -> Avatar {
        let mut recipe: Recipe = toml::from_str(
            "handles = [{ count = 12 }]\nmaterial = { stable_neo_hookean = { youngs_modulus = 2000.0, poissons_ratio = 0.4 } }",
        )
        .unwrap();
        recipe.stiffness = vec![region(&format!("scale = {scale:?}"))];
        recipe.contact_by_tissue = true;
        bake(&limb(), &recipe, &mut |_| {}).unwrap().0
    };
    assert!(baked(Vec::new()).contact_stiffness.is_empty());
    let avatar = recipe(1.0);
    assert_eq!(avatar.contact_stiffness.len(), avatar.skin.len());
    let inside = |v: usize| (0.02..0.23).contains(&avatar.skin.position[v].x);
    let expected = 100.0 * 2000.0 / depth;
    for v in (0..avatar.skin.len()).filter(|&v| inside(v)) {
        let ratio = avatar.contact_stiffness[v] / expected;
        // The nearest bone node is a little farther than the bone.
        assert!((0.9..1.05).contains(&ratio), "vertex {v}: {ratio}");
    }
    let doubled = recipe(2.0);
    for (once, twice) in avatar
        .contact_stiffness
        .iter()
        .zip(&doubled.contact_stiffness)
    {
        assert!((twice / once - 2.0).abs() < 1e-9, "{once} and {twice}");
    }
    // No stiffer than a penalty may be that nobody asked for; and in the file.
    let stiffest = supple::collider::Collider::STIFFEST;
    assert!(recipe(1e3).contact_stiffness.iter().all(|&k| k == stiffest));
    let read = from_bytes(&to_bytes(&avatar, None).unwrap(), std::path::Path::new("a")).unwrap();
    let read = read.avatar.contact_stiffness;
    for (a, b) in avatar.contact_stiffness.iter().zip(&read) {
        assert!((a / b - 1.0).abs() < 1e-6);
    }
}
