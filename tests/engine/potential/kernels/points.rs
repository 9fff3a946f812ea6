//! Kernels with one thread a point: pose_blend, displacement, inertial_target, elasticity, skin, normals.

use super::INSTANCE;
use super::bound::{Comparison, LENGTH, Outcome, QUOTIENT, abs, abs_cross};
use super::material::{DAMPING_RATE, Magnitudes};
use super::scene::{Phase, Scene, mat, vec};
use supple::glam::{DMat3, DVec3};
use supple::internal::cpu::displacement::{FrameMotion, position, unposed_displacement};
use supple::internal::cpu::elasticity::{Damping, displacement_gradient, stress, tangent};
use supple::internal::cpu::inertial_target as twin;
use supple::internal::cpu::normals::{normal, vertex_triangles};
use supple::internal::cpu::{displacement, pose_blend as pose_blend_twin, skin as skin_twin};
use supple::internal::gpu::shared;
use supple::internal::math::{Mat9, Rows};
use supple::model::{BasisEntry, PointSet, SkinWeight};

/// x̄: a product, then as many sums as there are features and shares, and one with X.
pub fn pose_blend(scene: &Scene) -> Outcome {
    let mut out = Comparison::default();
    let avatar = &scene.avatar;
    let own: Rows<(u32, f32)> = (0..avatar.skin.len() as u32).map(|v| [(v, 1.0)]).collect();
    for (phase, name, set, extension) in [
        (
            Phase::Evaluated,
            "unposed",
            &avatar.cubature,
            &avatar.pose_extension,
        ),
        (Phase::Evaluated, "skin_unposed", &avatar.skin, &own),
        (Phase::Posed, "posed_skin_unposed", &avatar.skin, &own),
    ] {
        let features = set.pose_blend.features;
        let feature: Vec<f32> = scene.pose_features(phase, features);
        let feature: Vec<f64> = feature.into_iter().map(f64::from).collect();
        let got = scene.rest(phase, name, set);
        let mut want = vec![DVec3::ZERO; set.len()];
        pose_blend_twin::pose_blend(&set.position, &set.pose_blend, &feature, 0, &mut want);
        for i in 0..set.len() {
            let column = |k: usize| vec(set.pose_blend.columns[k * set.len() + i]).abs();
            let terms = (0..features).map(|k| feature[k].abs() * column(k));
            let (shares, offsets) = (extension.row(i), scene.offsets(phase));
            let term =
                |&(v, share): &(u32, f32)| f64::from(share.abs()) * vec(offsets[v as usize]).abs();
            let followed = shares.iter().map(term).sum::<DVec3>();
            let magnitude = set.position[i].abs() + terms.sum::<DVec3>() + followed;
            let want = want[i] + pose_blend_twin::pose_offset(shares, offsets);
            out.vector(got[i], want, magnitude, features + shares.len() + 2);
        }
    }
    out.finish("x̄")
}

fn abs_rows(skinning: &[SkinWeight], basis: &[BasisEntry]) -> (Vec<SkinWeight>, Vec<BasisEntry>) {
    let weight = |w: &SkinWeight| SkinWeight {
        weight: w.weight.abs(),
        ..*w
    };
    let entry = |u: &BasisEntry| BasisEntry {
        value: u.value.abs(),
        gradient: u.gradient.abs(),
        ..*u
    };
    (
        skinning.iter().map(weight).collect(),
        basis.iter().map(entry).collect(),
    )
}

fn abs_all(vectors: &[DVec3]) -> Vec<DVec3> {
    vectors.iter().map(|v| v.abs()).collect()
}

/// −|J|: T − J on absolute values is then the sum of both.
pub fn minus_joints(scene: &Scene) -> Vec<DVec3> {
    scene.joints().iter().map(|j| -j.abs()).collect()
}

/// d: U φ and its sums (n_h + 1), T − J, a row of R (3), two sums, w, and the sums over bones.
pub fn displacement(scene: &Scene) -> Outcome {
    let mut out = Comparison::default();
    let set = &scene.avatar.cubature;
    let phase = Phase::Evaluated;
    let rest = scene.rest(phase, "unposed", set);
    // Both the start's own slot, whose d gave way to ŷ, and the evaluated state.
    for slot in [INSTANCE, phase.slot()] {
        let (base, increment) = scene.handles(phase, slot);
        let motions = scene.motions(phase, slot);
        let abs_motions: Vec<FrameMotion> = motions
            .iter()
            .map(|m| FrameMotion {
                rotation: abs(m.rotation),
                rotation_change: abs(m.rotation_change),
                translation_change: m.translation_change.abs(),
            })
            .collect();
        let got = scene.moved(phase, slot);
        for i in 0..set.len() {
            let (skinning, basis) = (set.skinning.row(i), set.basis.row(i));
            let t = rest[i] + unposed_displacement(basis, &base);
            let change = unposed_displacement(basis, &increment);
            let want = displacement::displacement(skinning, scene.joints(), &motions, t, change);
            let (abs_skinning, abs_basis) = abs_rows(skinning, basis);
            let abs_t = rest[i].abs() + unposed_displacement(&abs_basis, &abs_all(&base));
            let abs_change = unposed_displacement(&abs_basis, &abs_all(&increment));
            let magnitude = displacement::displacement(
                &abs_skinning,
                &minus_joints(scene),
                &abs_motions,
                abs_t,
                abs_change,
            );
            let roundings = basis.len() + skinning.len() + 8;
            if slot != INSTANCE {
                out.vector(vec(got[i].displacement), want, magnitude, roundings);
            }
            let roundings = basis.len() + 2;
            out.vector(
                vec(got[i].unposed),
                t + change,
                abs_t + abs_change,
                roundings,
            );
            let frames = scene.frames(phase, slot);
            let want = displacement::blended_rotation(skinning, &frames);
            let magnitude = DMat3::from_cols_array(&[1.0; 9]);
            out.matrix(mat(got[i].blended), want, magnitude, skinning.len() + 1);
        }
    }
    out.finish("d and T")
}

/// ŷ: c U φ and its sums (n_h + 1), T − J, four rows of a matrix (3 each), their sums, w, and the sums over bones.
pub fn inertial_target(scene: &Scene) -> Outcome {
    let mut out = Comparison::default();
    let set = &scene.avatar.cubature;
    let phase = Phase::Evaluated;
    let [past, sizes] = scene.past(phase);
    let got = scene.moved(phase, INSTANCE);
    for (i, got) in got.iter().enumerate() {
        let (skinning, basis) = (set.skinning.row(i), set.basis.row(i));
        let unposed = vec(got.unposed);
        let want = twin::inertial_target(skinning, basis, scene.joints(), &past, unposed);
        let (abs_skinning, abs_basis) = abs_rows(skinning, basis);
        let joints = minus_joints(scene);
        let magnitude =
            twin::inertial_target(&abs_skinning, &abs_basis, &joints, &sizes, unposed.abs());
        let roundings = basis.len() + skinning.len() + 12;
        out.vector(vec(got.displacement), want, magnitude, roundings);
    }
    out.finish("ŷ")
}

pub fn mat9(t: &shared::Tangent) -> Mat9 {
    let lower = [
        [mat(t.c00), DMat3::ZERO, DMat3::ZERO],
        [mat(t.c10), mat(t.c11), DMat3::ZERO],
        [mat(t.c20), mat(t.c21), mat(t.c22)],
    ];
    std::array::from_fn(|row| {
        std::array::from_fn(|column| {
            let (i, j) = (row / 3, column / 3);
            if i >= j {
                lower[i][j].col(column % 3)[row % 3]
            } else {
                lower[j][i].col(row % 3)[column % 3]
            }
        })
    })
}

/// |C| : |A|.
fn abs_contract(c: &Mat9, a: DMat3) -> DMat3 {
    let a = abs(a).to_cols_array();
    let row = |i: usize| (0..9).map(|j| c[i][j].abs() * a[j]).sum();
    DMat3::from_cols_array(&std::array::from_fn(row))
}

/// P and C, within [`Magnitudes`].
pub fn elasticity(scene: &Scene) -> Outcome {
    let mut out = Comparison::default();
    let set = &scene.avatar.cubature;
    let phase = Phase::Evaluated;
    let starts: Vec<shared::Tangent> = scene.items(phase, "tangent", INSTANCE, set.len());
    let mut clamped = 0;
    for slot in [INSTANCE, phase.slot()] {
        let (_, increment) = scene.handles(phase, slot);
        let (_, drift) = scene.handles(phase, INSTANCE);
        let phi = scene.displaced(phase, slot);
        let stresses: Vec<shared::Mat3> = scene.items(phase, "stress", slot, set.len());
        let tangents: Vec<shared::Tangent> = scene.items(phase, "tangent", slot, set.len());
        for i in 0..set.len() {
            let (basis, tissue) = (set.basis.row(i), scene.tissue_at(i));
            let h = displacement_gradient(basis, &phi);
            let change =
                displacement_gradient(basis, &increment) - displacement_gradient(basis, &drift);
            let (_, abs_basis) = abs_rows(&[], basis);
            let abs_h = displacement_gradient(&abs_basis, &abs_all(&phi));
            let abs_change = displacement_gradient(&abs_basis, &abs_all(&increment))
                + displacement_gradient(&abs_basis, &abs_all(&drift));
            let start = mat9(&starts[i]);
            let rate = scene.damping_rate(i);
            let damping = (slot != INSTANCE).then_some(Damping {
                rate,
                tangent: &start,
                change,
            });
            let f = DMat3::IDENTITY + h;
            let magnitudes = Magnitudes::new(tissue, h, abs_h);
            clamped += usize::from(magnitudes.is_clamped());
            let want = stress(tissue, f, damping);
            let (mut magnitude, mut roundings) = magnitudes.stress(basis.len());
            if damping.is_some() {
                roundings += DAMPING_RATE;
                magnitude += rate * abs_contract(&start, abs_change);
            }
            out.matrix(mat(stresses[i]), want, magnitude, roundings);

            if magnitudes.is_at_the_clamp() {
                continue;
            }
            let want = tangent(tissue, f, damping, 1.0);
            let got = mat9(&tangents[i]);
            let (mut magnitude, mut roundings) = magnitudes.tangent(basis.len());
            if damping.is_some() {
                roundings += DAMPING_RATE;
                let largest = start.iter().flatten().fold(0.0, |a: f64, c| a.max(c.abs()));
                magnitude += rate * largest;
            }
            for row in 0..9 {
                for column in 0..9 {
                    out.number(got[row][column], want[row][column], magnitude, roundings);
                }
            }
        }
    }
    if 10 * clamped > 19 * set.len() {
        return Err(format!("{clamped} of {} points are clamped", 2 * set.len()));
    }
    out.finish("P and C")
}

/// Σ_j w_j (R_j (T − J_j) + c_j) on absolute values.
pub fn abs_position(
    scene: &Scene,
    phase: Phase,
    slot: usize,
    set: &PointSet,
    i: usize,
    rest: DVec3,
) -> DVec3 {
    let (skinning, basis) = abs_rows(set.skinning.row(i), set.basis.row(i));
    let (base, increment) = scene.handles(phase, slot);
    let phi: Vec<DVec3> = base
        .iter()
        .zip(&increment)
        .map(|(b, d)| b.abs() + d.abs())
        .collect();
    let mut frames = scene.frames(phase, slot);
    for frame in &mut frames {
        frame.rotation = abs(frame.rotation);
        frame.position = frame.position.abs();
    }
    let t = rest.abs() + unposed_displacement(&basis, &phi);
    position(&skinning, &minus_joints(scene), &frames, t)
}

/// As d, with φ = φ_base + Δφ one more.
pub fn skin_roundings(set: &PointSet, i: usize) -> usize {
    set.basis.row(i).len() + set.skinning.row(i).len() + 9
}

/// x: see [`skin_roundings`].
pub fn skin(scene: &Scene) -> Outcome {
    let mut out = Comparison::default();
    let set = &scene.avatar.skin;
    let phase = Phase::Posed;
    let rest = scene.rest(phase, "posed_skin_unposed", set);
    let frames = scene.frames(phase, phase.slot());
    let phi = scene.displaced(phase, phase.slot());
    let got: Vec<shared::SkinVertex> = scene.skin_vertices();
    for i in 0..set.len() {
        let (skinning, basis) = (set.skinning.row(i), set.basis.row(i));
        let want = skin_twin::skin(skinning, basis, scene.joints(), &frames, &phi, rest[i]);
        let magnitude = abs_position(scene, phase, phase.slot(), set, i, rest[i]);
        out.vector(
            vec(got[i].position),
            want,
            magnitude,
            skin_roundings(set, i),
        );
    }
    out.finish("x")
}

/// n = N/|N|: edges, a cross product (3) and the sum over triangles; then the length and a quotient. An error e of N turns n by at most e/|N|.
pub fn normals(scene: &Scene) -> Outcome {
    let mut out = Comparison::default();
    let count = scene.avatar.skin.len();
    let got: Vec<shared::SkinVertex> = scene.skin_vertices();
    let positions: Vec<DVec3> = got.iter().map(|v| vec(v.position)).collect();
    let around = vertex_triangles(count, &scene.avatar.triangles);
    for i in 0..count {
        let want = normal(&positions, i, around.row(i));
        let edges = around.row(i).iter().map(|&[b, c]| {
            let edge = |v: u32| positions[v as usize] - positions[i];
            (edge(b), edge(c))
        });
        let (mut sum, mut terms) = (DVec3::ZERO, DVec3::ZERO);
        for (b, c) in edges {
            sum += b.cross(c);
            terms += abs_cross(b, c);
        }
        let magnitude = 1.0 + terms.length() / sum.length();
        let roundings = around.row(i).len() + 4 + LENGTH + QUOTIENT;
        out.vector(vec(got[i].normal), want, DVec3::splat(magnitude), roundings);
    }
    out.finish("n")
}
