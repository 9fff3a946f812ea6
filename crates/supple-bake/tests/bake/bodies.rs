//! What a bake makes of whole bodies: like halves, handles where people are soft, no thin cones.

use std::path::Path;
use supple::glam::DVec3;
use supple::model::Avatar;
use supple_bake::math::NearestPoint;
use supple_bake::{BakeReport, Body, Recipe, ThinPlace, bake};
use supple_files::read_character;
use supple_samples::{Sample, SampleShape};

fn baked(body: &Body, recipe: &Recipe) -> (Avatar, BakeReport) {
    bake(body, recipe, &mut |_| {}).unwrap()
}

/// A character of the shared assets, where they are there.
fn character(file: &str) -> Option<Body> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../../shared/assets")
        .join(file);
    if !path.exists() {
        println!("skipped: {} is not there", path.display());
        return None;
    }
    Some(read_character(&path, &Default::default()).unwrap().body)
}

/// A person that stands: where parts of it are, by height, side and front.
struct Person<'a> {
    body: &'a Body,
    low: DVec3,
    height: f64,
    /// Between front and back of the trunk.
    middle: f64,
}

impl<'a> Person<'a> {
    fn new(body: &'a Body) -> Self {
        let (low, high) = body.skin.bounds();
        let height = high.y - low.y;
        let trunk =
            |p: &&DVec3| (0.45..0.8).contains(&((p.y - low.y) / height)) && p.x.abs() < 0.15;
        let depths = || body.skin.positions.iter().filter(trunk).map(|p| p.z);
        let (back, front) = (depths().fold(9.0, f64::min), depths().fold(-9.0, f64::max));
        Self {
            body,
            low,
            height,
            middle: 0.5 * (front + back),
        }
    }

    /// Name of a soft part, and where it is.
    fn part(&self, p: DVec3) -> Option<&'static str> {
        let (up, aside) = ((p.y - self.low.y) / self.height, p.x.abs());
        let in_front = p.z > self.middle;
        match up {
            0.66..0.79 if in_front && aside < 0.2 => Some("breast"),
            0.52..0.66 if in_front && aside < 0.2 => Some("belly"),
            0.455..0.56 if !in_front && aside < 0.25 => Some("buttock"),
            0.27..0.455 if aside < 0.3 => Some("thigh"),
            0.05..0.27 if aside < 0.4 => Some("calf"),
            _ => None,
        }
    }

    /// Handles of a part to the left, on the middle and to the right.
    fn handles(&self, avatar: &Avatar, part: &str) -> [usize; 3] {
        let mut count = [0; 3];
        for p in avatar
            .handles
            .iter()
            .filter(|p| self.part(**p) == Some(part))
        {
            let side = match p.x {
                x if x > 0.005 => 0,
                x if x < -0.005 => 2,
                _ => 1,
            };
            count[side] += 1;
        }
        count
    }

    /// Has like halves, and handles on what is soft: `least` a side, and six of each part.
    fn check(&self, avatar: &Avatar, report: &BakeReport, least: usize) {
        let name = &self.body.name;
        for part in ["breast", "belly", "buttock", "thigh", "calf"] {
            let [left, middle, right] = self.handles(avatar, part);
            println!("{name}: {part} {left} + {middle} + {right}");
            assert_eq!(left, right, "{name}: {part}");
            assert!(
                left >= least && left + middle + right >= 6,
                "{name}: {part} {left}"
            );
        }
        let half = 0.5 * report.handles.spacing[1];
        for p in &avatar.handles {
            let twin = DVec3::new(-p.x, p.y, p.z);
            let gaps = avatar.handles.iter().map(|q| q.distance(twin));
            assert!(gaps.fold(9.0, f64::min) < half, "{name}: {p}");
        }
    }
}

#[test]
fn the_sample_body_has_like_halves_by_its_own_recipe_and_without_one() {
    let (body, recipe) = Sample::Body.body().unwrap();
    for (recipe, least) in [(recipe, 4), (Recipe::default(), 4)] {
        let (avatar, report) = baked(&body, &recipe);
        Person::new(&body).check(&avatar, &report, least);
        assert_eq!(report.thin_places, []);
    }
}

/// The shape for motion: its breasts and belly are deeper than the mean's, and sound.
#[test]
fn the_full_shape_has_deep_breasts_and_a_belly() {
    let baked_shape = |shape: SampleShape| {
        let (body, _) = Sample::Body.shaped(shape.betas()).unwrap();
        let (avatar, report) = baked(&body, &Recipe::default());
        (body, avatar, report)
    };
    let (_, _, mean) = baked_shape(SampleShape::Mean);
    let (body, avatar, full) = baked_shape(SampleShape::Full);
    Person::new(&body).check(&avatar, &full, 4);
    let depth = |report: &BakeReport, name: &str| {
        let found = report.softness.iter().find(|r| r.name == name);
        let region = found.unwrap();
        println!("{name}: {region}");
        region.depth
    };
    for part in ["breast", "belly"] {
        let (deep, usual) = (depth(&full, part), depth(&mean, part));
        assert!(deep > 1.1 * usual && deep > 0.055, "{part}: {deep} {usual}");
    }
    assert_eq!(full.mesh.skin, mean.mesh.skin);
}

/// Its nipples were the tips of cones without tissue; its breasts had no handle.
#[test]
fn breasts_are_deep_to_their_tips() {
    let Some(body) = character("makehuman-female-cmu-02_01.glb") else {
        return;
    };
    let (avatar, report) = baked(&body, &Recipe::default());
    let person = Person::new(&body);
    person.check(&avatar, &report, 4);
    let layer = &avatar.layer;
    let held: Vec<DVec3> = (layer.mesh.nodes.iter().zip(&layer.bone_of_node))
        .filter_map(|(p, bone)| bone.map(|_| *p))
        .collect();
    let search = NearestPoint::new(&held);
    for side in [-1.0, 1.0] {
        let of_breast = |p: &&DVec3| p.x * side > 0.0 && person.part(**p) == Some("breast");
        let tip = body.skin.positions.iter().filter(of_breast);
        let tip = tip.max_by(|a, b| a.z.total_cmp(&b.z)).unwrap();
        let depth = search.distance(*tip);
        println!("tip {tip}: {:.1} mm deep", 1e3 * depth);
        // A deep part of this body has 40 mm.
        assert!(depth > 0.75 * report.deep, "{depth} at {tip}");
    }
    // Seen from its breasts' height nothing is thin; what is left is told.
    let high = |p: &ThinPlace| p.position[1] > 1.0;
    assert!(
        !report.thin_places.iter().any(high),
        "{:?}",
        report.thin_places
    );
}

/// A helmet and what is in it: 25 of 60 handles stood there. The neck may have a pair.
#[test]
fn a_head_called_neck_has_no_handles() {
    let Some(body) = character("khronos-CesiumMan.glb") else {
        return;
    };
    let (avatar, report) = baked(&body, &Recipe::default());
    let on_head = report.bone_names.iter().zip(&report.handles.per_bone);
    let on_head = on_head.filter(|(name, _)| *name == "Skeleton_neck_joint_2");
    assert!(on_head.map(|(_, count)| count).sum::<usize>() <= 4);
    let low = body.skin.bounds().0.y;
    let up = |p: &DVec3| (p.y - low) / report.extent[1];
    let highest = avatar.handles.iter().map(up).fold(0.0, f64::max);
    assert!(highest < 0.85, "{highest}");
}
