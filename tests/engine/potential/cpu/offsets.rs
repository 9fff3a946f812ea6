//! A host's offsets of the skin: they do what pose blend shapes of the same size do, and no more.

use super::batches::triples;
use super::{floor, start};
use pollster::block_on;
use std::sync::Arc;
use supple::glam::DVec3;
use supple::internal::features::pose_feature;
use supple::internal::{pose_offsets, random_avatar};
use supple::model::{Avatar, PoseBlend, State};
use supple::potential::{CpuPotential, Evaluation, Potential, StepStart};

/// An avatar whose cubature points follow the pose columns of its skin by its extension, and the same without columns.
fn pair() -> (Arc<Avatar>, Arc<Avatar>) {
    let mut with = random_avatar(7, 4, 12, 90, 300);
    let (vertices, features) = (with.skin.len(), with.skin.pose_blend.features);
    let at_point = |k: usize, i: usize| -> [f32; 3] {
        let column = |v: u32| with.skin.pose_blend.columns[k * vertices + v as usize];
        let share =
            |&(v, share): &(u32, f32)| f64::from(share) * DVec3::from(column(v).map(f64::from));
        let followed = with.pose_extension.row(i).iter().map(share);
        followed.sum::<DVec3>().as_vec3().to_array()
    };
    let points = with.cubature.len();
    let columns = (0..features).flat_map(|k| (0..points).map(move |i| (k, i)));
    with.cubature.pose_blend.columns = columns.map(|(k, i)| at_point(k, i)).collect();
    let mut without = with.clone();
    without.skin.pose_blend = PoseBlend::default();
    without.cubature.pose_blend = PoseBlend::default();
    (Arc::new(with), Arc::new(without))
}

/// What the columns of `avatar` make of the pose of `state`, as a host would say it.
fn said(avatar: &Avatar, state: &State) -> Vec<[f32; 3]> {
    let (blend, vertices) = (&avatar.skin.pose_blend, avatar.skin.len());
    let feature = pose_feature(&avatar.skeleton.parents, &state.frames);
    let offset = |v: usize| -> DVec3 {
        let column = |k: usize| DVec3::from(blend.columns[k * vertices + v].map(f64::from));
        feature.iter().enumerate().map(|(k, f)| f * column(k)).sum()
    };
    (0..vertices)
        .map(|v| offset(v).as_vec3().to_array())
        .collect()
}

/// The evaluation of a step, and the skin that is posed at its end.
fn evaluated(
    avatar: &Arc<Avatar>,
    [previous, current, state]: &[State; 3],
    offsets: [&[[f32; 3]]; 2],
) -> (Evaluation, Vec<DVec3>) {
    let mut potential = CpuPotential::new(avatar.clone(), 1).unwrap();
    let colliders = [floor(-0.01)];
    let start = StepStart {
        pose_offsets: offsets[0],
        ..start(previous, current, &colliders)
    };
    let (mut out, mut skin, mut normals) = ([Evaluation::default()], Vec::new(), Vec::new());
    block_on(async {
        potential.begin_step(&[start], &[true]).await?;
        let states = std::slice::from_ref(state);
        potential.evaluate(states, &[true], &mut out).await?;
        potential.pose_skin(states, &offsets[1..], &[]).await?;
        potential.read_skin(0, &mut skin, &mut normals).await
    })
    .unwrap();
    let [evaluation] = out;
    (evaluation, skin)
}

/// Offsets are rounded to 2⁻²⁴ of their size of some millimetres: 1e-10 m.
#[test]
fn offsets_do_what_pose_blend_shapes_do() {
    let (with, without) = pair();
    for states in &triples(&with) {
        let said = [1, 2].map(|k| said(&with, &states[k]));
        let (wanted, skin) = evaluated(&with, states, [&[], &[]]);
        let (found, moved) = evaluated(&without, states, [&said[0], &said[1]]);
        let apart = skin.iter().zip(&moved).map(|(a, b)| a.distance(*b));
        let apart = apart.fold(0.0, f64::max);
        assert!(apart < 1e-9, "{apart:e} m");
        assert!(wanted.contacts > 10 && wanted.contacts == found.contacts);
        let (bare, unmoved) = evaluated(&without, states, [&[], &[]]);
        let size = |e: &Evaluation| e.gradient.iter().fold(0.0, |a: f64, g| a.max(g.abs()));
        let error = |e: &Evaluation| {
            let pairs = e.gradient.iter().zip(&wanted.gradient);
            pairs.fold(0.0, |a: f64, (g, w)| a.max((g - w).abs()))
        };
        // 1e8 Pa/m hold a vertex by 1e-10 m more or less, of a contact margin of 1e-3 m.
        assert!(error(&found) < 1e-6 * size(&wanted), "{:e}", error(&found));
        assert!(error(&bare) > 1e-3 * size(&wanted), "{:e}", error(&bare));
        assert!(
            skin.iter()
                .zip(&unmoved)
                .any(|(a, b)| a.distance(*b) > 1e-4)
        );
    }
}

#[test]
fn offsets_that_cannot_be_are_refused_by_name() {
    let avatar = Arc::new(random_avatar(7, 4, 12, 90, 300));
    let rest = avatar.rest_state();
    let refused = |avatar: &Arc<Avatar>, offsets: &[[f32; 3]]| {
        let mut potential = CpuPotential::new(avatar.clone(), 1).unwrap();
        let start = StepStart {
            pose_offsets: offsets,
            ..start(&rest, &rest, &[])
        };
        let begun = block_on(potential.begin_step(&[start], &[true]));
        let posed = block_on(potential.pose_skin(std::slice::from_ref(&rest), &[offsets], &[]));
        let [begun, posed] = [begun, posed].map(|outcome| outcome.unwrap_err().to_string());
        assert_eq!(begun, posed);
        begun
    };
    let good = pose_offsets(1, &avatar, 5e-3);
    let error = refused(&avatar, &good[1..]);
    assert!(
        error.contains("pose_offsets: 299 given for 300 vertices"),
        "{error}"
    );
    // In millimetres, where metres are wanted.
    for (value, name) in [(f32::NAN, "NaN"), (f32::INFINITY, "inf"), (-5.0, "-5.0")] {
        let mut bad = good.clone();
        bad[17][1] = value;
        let error = refused(&avatar, &bad);
        assert!(
            error.contains("pose_offsets[17]: [") && error.contains(name),
            "{error}"
        );
        assert!(
            error.contains("0.120 m large: give finite metres"),
            "{error}"
        );
    }
    let mut before = (*avatar).clone();
    before.pose_extension = Default::default();
    let error = refused(&Arc::new(before), &good);
    assert!(error.contains("bake the character again"), "{error}");
}
