//! Kernels that sum over points and contacts: gradient, point_hessian, hessian.

use super::INSTANCE;
use super::bound::{Comparison, Outcome, abs, abs_cross, abs_skew};
use super::compact::{listed, places, rows, vertex_blocks};
use super::points::{mat9, minus_joints};
use super::scene::{GRAVITY, INERTIAL_STEP, Phase, Scene, mat, prescribed, vec};
use supple::glam::{DMat3, DVec3};
use supple::internal::cpu::displacement::arms;
use supple::internal::cpu::gradient::{gradient as gradient_twin, point_force};
use supple::internal::cpu::hessian::{
    ContactRows, ContactTerms, SkinBlocks, gather_blocks, gather_contacts,
};
use supple::internal::cpu::point_hessian::{
    PointTerms, PointView, is_prescribed, point_hessian as hessian_twin,
};
use supple::internal::cpu::{Basis, FineSkin, Incidence};
use supple::internal::features::point_blocks;
use supple::internal::gpu::shared;
use supple::internal::math::Mat9;

const PHASE: Phase = Phase::Evaluated;

/// A cubature point with its twin's terms, and what they are made of on absolute values.
struct Prepared {
    terms: PointTerms,
    arms: Vec<DVec3>,
    tangent: Mat9,
    abs_force: DVec3,
    abs_arms: Vec<DVec3>,
    abs_blended: DMat3,
    abs_tangent: Mat9,
}

fn prepare(scene: &Scene) -> Vec<Prepared> {
    let set = &scene.avatar.cubature;
    let frames = scene.frames(PHASE, PHASE.slot());
    let mut abs_frames = frames.clone();
    for frame in &mut abs_frames {
        frame.rotation = abs(frame.rotation);
    }
    let starts = scene.moved(PHASE, INSTANCE);
    let motions = scene.moved(PHASE, PHASE.slot());
    let stresses: Vec<shared::Mat3> = scene.items(PHASE, "stress", PHASE.slot(), set.len());
    let tangents: Vec<shared::Tangent> = scene.items(PHASE, "tangent", PHASE.slot(), set.len());
    let point = |i: usize| {
        let (skinning, weight) = (set.skinning.row(i), set.measure[i]);
        let mass = scene.avatar.density * weight;
        let inertia = mass / (INERTIAL_STEP * INERTIAL_STEP);
        let (d, y) = (vec(motions[i].displacement), vec(starts[i].displacement));
        let unposed = vec(motions[i].unposed);
        let force = point_force(mass, INERTIAL_STEP, d, y, GRAVITY);
        let blended = mat(motions[i].blended);
        let mut tangent = mat9(&tangents[i]);
        tangent.iter_mut().flatten().for_each(|c| *c *= weight);
        let mut point_arms = vec![DVec3::ZERO; skinning.len()];
        arms(skinning, scene.joints(), &frames, unposed, &mut point_arms);
        let mut abs_arms = point_arms.clone();
        let joints = minus_joints(scene);
        arms(skinning, &joints, &abs_frames, unposed.abs(), &mut abs_arms);
        Prepared {
            terms: PointTerms {
                inertia,
                force,
                pulled_force: blended.transpose() * force,
                stress: weight * mat(stresses[i]),
                blended: blended * inertia,
                metric: blended.transpose() * blended * inertia,
            },
            arms: point_arms,
            tangent,
            abs_force: inertia * (d.abs() + y.abs()) + mass * GRAVITY.abs(),
            abs_arms,
            abs_blended: abs(blended),
            abs_tangent: tangent.map(|row| row.map(f64::abs)),
        }
    };
    (0..set.len()).map(point).collect()
}

fn view<'a>(
    scene: &'a Scene,
    point: &'a Prepared,
    i: usize,
) -> PointView<'a, supple::model::BasisEntry> {
    let set = &scene.avatar.cubature;
    PointView {
        terms: &point.terms,
        skinning: set.skinning.row(i),
        arms: &point.arms,
        basis: set.basis.row(i),
        tangent: &point.tangent,
        prescribed: &[],
    }
}

/// Blocks of cubature point `i` in its own order.
fn blocks_of(scene: &Scene, i: usize) -> Vec<u32> {
    let mut blocks = Vec::new();
    point_blocks(scene.avatar.space(), &scene.avatar.cubature, i, &mut blocks);
    blocks
}

/// Where the blocks of each point begin, and how many there are.
fn offsets(scene: &Scene, count: impl Fn(usize) -> usize) -> Vec<usize> {
    let mut offsets = vec![0];
    for i in 0..scene.avatar.cubature.len() {
        offsets.push(offsets[i] + count(blocks_of(scene, i).len()));
    }
    offsets
}

fn point_gradients(scene: &Scene) -> (Vec<usize>, Vec<DVec3>) {
    let offsets = offsets(scene, |blocks| blocks);
    let total = offsets[offsets.len() - 1];
    let all: Vec<[f32; 4]> = scene.items(PHASE, "point_gradients", INSTANCE, total);
    (
        offsets,
        all.iter().map(|g| vec([g[0], g[1], g[2]])).collect(),
    )
}

/// A point's part: the force (5), then a row of Rᵀ (3), w, n_b sums and U, beside the stress (5), or
/// an arm (5) and a cross product (2). The gather: terms over 64 threads, then six levels, and three
/// products of a contact.
pub fn gradient(scene: &Scene) -> Outcome {
    let mut out = Comparison::default();
    let set = &scene.avatar.cubature;
    let (offsets, parts) = point_gradients(scene);
    for (i, point) in prepare(scene).iter().enumerate() {
        let (skinning, basis) = (set.skinning.row(i), set.basis.row(i));
        let view = view(scene, point, i);
        let pulled = point.abs_blended.transpose() * point.abs_force;
        let stress = abs(point.terms.stress);
        for local in 0..blocks_of(scene, i).len() {
            let magnitude = if local >= 2 * skinning.len() {
                let u = &basis[local - 2 * skinning.len()];
                u.value.abs() * pulled + stress * u.gradient.abs()
            } else if local.is_multiple_of(2) {
                skinning[local / 2].weight * point.abs_force
            } else {
                abs_cross(point.abs_arms[local / 2], point.abs_force)
            };
            let want = gradient_twin(&view, local);
            let roundings = skinning.len() + 5 + 8;
            out.vector(parts[offsets[i] + local], want, magnitude, roundings);
        }
    }
    out.finish("a point's gradient")?;

    let mut out = Comparison::default();
    let blocks = scene.avatar.space().blocks();
    let (mut sums, mut magnitudes) = (vec![DVec3::ZERO; blocks], vec![DVec3::ZERO; blocks]);
    let mut terms = vec![0; blocks];
    let mut add = |block: u32, term: DVec3| {
        sums[block as usize] += term;
        magnitudes[block as usize] += term.abs();
        terms[block as usize] += 1;
    };
    for i in 0..set.len() {
        for (local, &block) in blocks_of(scene, i).iter().enumerate() {
            add(block, parts[offsets[i] + local]);
        }
    }
    for (k, contact) in listed(scene).iter().enumerate() {
        let levers = rows(scene, k);
        for (block, place) in places(scene, contact) {
            add(block, contact.force * levers[place]);
        }
    }
    for block in 0..blocks {
        let got = DVec3::from_slice(&scene.evaluation.gradient[3 * block..3 * block + 3]);
        let roundings = terms[block] / 64 + 2 + 6 + 3;
        out.vector(got, sums[block], magnitudes[block], roundings);
    }
    out.finish("the gradient")
}

/// |J| of local block `local`.
fn abs_jacobian(scene: &Scene, point: &Prepared, i: usize, local: usize) -> DMat3 {
    let set = &scene.avatar.cubature;
    let (skinning, basis) = (set.skinning.row(i), set.basis.row(i));
    if local >= 2 * skinning.len() {
        basis[local - 2 * skinning.len()].value.abs() * point.abs_blended
    } else if local.is_multiple_of(2) {
        DMat3::from_diagonal(DVec3::splat(skinning[local / 2].weight))
    } else {
        abs_skew(point.abs_arms[local / 2])
    }
}

fn point_hessians(scene: &Scene) -> (Vec<usize>, Vec<DMat3>) {
    let offsets = offsets(scene, |blocks| blocks * (blocks + 1) / 2);
    let total = offsets[offsets.len() - 1];
    let all: Vec<shared::Mat3> = scene.items(PHASE, "point_hessians", INSTANCE, total);
    (offsets, all.into_iter().map(mat).collect())
}

/// Two J (an arm: 5; B: n_b + 2), m/h² (3) and a row of their product (3); two ∇U, w, C and the sums (8); and
/// the sum of both.
pub fn point_hessian(scene: &Scene) -> Outcome {
    let mut out = Comparison::default();
    let set = &scene.avatar.cubature;
    let (offsets, got) = point_hessians(scene);
    for (i, point) in prepare(scene).iter().enumerate() {
        let (frames, basis) = (2 * set.skinning.row(i).len(), set.basis.row(i));
        let blocks = frames + basis.len();
        let mut want = vec![DMat3::ZERO; blocks * (blocks + 1) / 2];
        hessian_twin(&view(scene, point, i), &mut want);
        for a in 0..blocks {
            for b in 0..=a {
                let (ja, jb) = (
                    abs_jacobian(scene, point, i, a),
                    abs_jacobian(scene, point, i, b),
                );
                let mut magnitude = point.terms.inertia * (ja.transpose() * jb);
                if b >= frames {
                    let abs_entry = |local: usize| supple::model::BasisEntry {
                        gradient: basis[local - frames].gradient.abs(),
                        ..basis[local - frames]
                    };
                    let stiffness = abs_entry(a).stiffness(&point.abs_tangent);
                    magnitude += abs_entry(b).contract(&stiffness);
                }
                let pair = a * (a + 1) / 2 + b;
                let roundings = 2 * (frames / 2 + 6) + 6 + 2;
                out.matrix(got[offsets[i] + pair], want[pair], magnitude, roundings);
            }
        }
    }
    out.finish("a point's Hessian")
}

/// Places of `blocks` in rising order.
fn rising(blocks: &[u32]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..blocks.len()).collect();
    order.sort_by_key(|&k| blocks[k]);
    order
}

/// One rounding a term, three more for a contact's products.
pub fn hessian(scene: &Scene) -> Outcome {
    let set = &scene.avatar.cubature;
    let (offsets, parts) = point_hessians(scene);
    // The twin wants the blocks of every point in rising order.
    let mut sorted_blocks = Vec::new();
    let mut sorted_parts = Vec::new();
    for i in 0..set.len() {
        let blocks = blocks_of(scene, i);
        let order = rising(&blocks);
        let mut part = Vec::new();
        for (a, &from_a) in order.iter().enumerate() {
            for &from_b in &order[..=a] {
                let (high, low) = (from_a.max(from_b), from_a.min(from_b));
                let stored = parts[offsets[i] + high * (high + 1) / 2 + low];
                part.push(if from_a >= from_b {
                    stored
                } else {
                    stored.transpose()
                });
            }
        }
        sorted_blocks.push(order.iter().map(|&k| blocks[k]).collect::<Vec<_>>());
        sorted_parts.push(part);
    }
    let cubature = Incidence::new(&scene.pattern, sorted_blocks.into_iter().collect());

    let contacts = listed(scene);
    let orders: Vec<Vec<usize>> = (0..scene.avatar.skin.len())
        .map(|v| rising(&vertex_blocks(scene, v)))
        .collect();
    let skin_blocks = orders.iter().enumerate().map(|(v, order)| {
        let blocks = vertex_blocks(scene, v);
        order.iter().map(move |&k| blocks[k]).collect::<Vec<_>>()
    });
    let skin = Incidence::new(&scene.pattern, skin_blocks.collect());
    let stride = orders.iter().map(Vec::len).max().unwrap_or(0) + 2;
    let mut levers = vec![DVec3::ZERO; contacts.len() * stride];
    for (k, contact) in contacts.iter().enumerate() {
        let rows = rows(scene, k);
        for (place, &from) in orders[contact.vertex as usize].iter().enumerate() {
            levers[k * stride + place] = rows[from];
        }
        let own = orders[contact.vertex as usize].len();
        levers[k * stride + own..][..2].copy_from_slice(&rows[rows.len() - 2..]);
    }
    let abs_levers: Vec<DVec3> = levers.iter().map(|l| l.abs()).collect();
    let abs_parts: Vec<Vec<DMat3>> = (sorted_parts.iter())
        .map(|part| part.iter().map(|h| abs(*h)).collect())
        .collect();

    let mut by_row = ContactRows::default();
    let fine = FineSkin::default();
    let skin = SkinBlocks {
        coarse: &skin,
        fine: &fine,
        first_handle: scene.avatar.space().handle_block(0) as u32,
    };
    by_row.fill(&contacts, &skin, scene.avatar.space().blocks());
    let gather = |parts: &[Vec<DMat3>], levers: &[DVec3]| {
        let mut out = vec![[0.0; 9]; scene.pattern.len()];
        for row in 0..scene.avatar.space().blocks() {
            let range = scene.pattern.columns().range(row);
            let out = &mut out[range];
            gather_blocks(&cubature, row, |i| &parts[i], out);
            let mut force = DVec3::ZERO;
            let terms = ContactTerms {
                rows: &by_row,
                contacts: &contacts,
                levers: (stride, levers),
                skin,
                pattern: &scene.pattern,
                prescribed: &[],
            };
            gather_contacts(&terms, row, &mut force, out);
        }
        out
    };
    let mut want = gather(&sorted_parts, &levers);
    let mut magnitude = gather(&abs_parts, &abs_levers);
    let prescribed = prescribed(&scene.avatar, INSTANCE);
    for (k, (row, column)) in scene.pattern.blocks().enumerate() {
        if is_prescribed(&prescribed, row) || is_prescribed(&prescribed, column) {
            (want[k], magnitude[k]) = ([0.0; 9], [0.0; 9]);
        }
    }
    let mut out = Comparison::default();
    let most = set.len() + contacts.len() + 3;
    for (block, (want, magnitude)) in want.iter().zip(&magnitude).enumerate() {
        for k in 0..9 {
            out.number(
                scene.evaluation.hessian[block][k],
                want[k],
                magnitude[k],
                most,
            );
        }
    }
    out.finish("the Hessian")
}
