//! The energy kernel: from the step's start, as an evaluation has it, and from any base, as a trial has it.

use super::bound::{Comparison, LENGTH, Outcome, QUOTIENT, abs};
use super::contact::distances;
use super::friction::{slid, smoothing};
use super::material::{DAMPING_RATE, Magnitudes};
use super::points::mat9;
use super::scene::{GRAVITY, INERTIAL_STEP, Phase, Scene, vec};
use super::{INSTANCE, INSTANCES};
use supple::glam::{DMat3, DVec3};
use supple::internal::cpu::elasticity::displacement_gradient;
use supple::internal::cpu::energy as twin;
use supple::internal::cpu::friction::smoothed_slopes;
use supple::internal::gpu::shared;
use supple::model::BasisEntry;

fn abs_gradient(basis: &[BasisEntry], handles: &[DVec3]) -> DMat3 {
    basis
        .iter()
        .map(|u| {
            let (phi, g) = (handles[u.handle as usize].abs(), u.gradient.abs());
            DMat3::from_cols(phi * g.x, phi * g.y, phi * g.z)
        })
        .sum()
}

/// μ λ f₀′/y u_T: a tangential part, a length, a polynomial of a quotient over another, and two products.
const SLOPE: usize = 5 + LENGTH + 3 + 2 * QUOTIENT + 2;

/// Each term is a polynomial of the state of degree ≤ 6 (the roundings of [`Magnitudes`] cover the others, generously),
/// then summed in trees: six levels over a workgroup, its partial sums over 64 threads, six levels again.
pub fn energy(scene: &Scene) -> Outcome {
    energies(scene, Phase::Evaluated, INSTANCE, INSTANCE)?;
    energies(scene, Phase::Compared, 0, INSTANCES + 1)
}

fn energies(scene: &Scene, phase: Phase, at: usize, base: usize) -> Outcome {
    let set = &scene.avatar.cubature;
    let slot = phase.slot();
    let from_start = base == INSTANCE;
    let (phi, change) = scene.handles(phase, slot);
    let (_, base_change) = scene.handles(phase, base);
    let (_, drift) = scene.handles(phase, INSTANCE);
    let moved = scene.moved(phase, slot);
    let base_moved = scene.moved(phase, base);
    let start = scene.moved(phase, INSTANCE);
    let tangents: Vec<shared::Tangent> = scene.items(phase, "tangent", INSTANCE, set.len());

    let (mut want, mut magnitude) = ([0.0; 6], [0.0; 6]);
    let mut add = |term: usize, value: f64, size: f64| {
        want[term] += value;
        magnitude[term] += size;
    };
    let mut roundings = 0;
    for i in 0..set.len() {
        let (weight, basis) = (set.measure[i], set.basis.row(i));
        let rate = scene.damping_rate(i);
        let mass = scene.avatar.density * weight;
        let delta = vec(moved[i].displacement);
        let predicted = vec(start[i].displacement);
        let moved_before = if from_start {
            DVec3::ZERO
        } else {
            vec(base_moved[i].displacement)
        };
        let residual = moved_before - predicted;
        let abs_residual = moved_before.abs() + predicted.abs();
        let size = delta.abs().dot(delta.abs() + 2.0 * abs_residual);
        add(
            0,
            twin::inertia(mass, INERTIAL_STEP, delta, residual),
            0.5 * mass / (INERTIAL_STEP * INERTIAL_STEP) * size,
        );
        let size = mass * GRAVITY.abs().dot(delta.abs());
        add(1, twin::gravity(mass, GRAVITY, delta), size);

        let h = displacement_gradient(basis, &phi);
        let d = displacement_gradient(basis, &change);
        let (abs_h, abs_d) = (abs_gradient(basis, &phi), abs_gradient(basis, &change));
        let tissue = scene.tissue_at(i);
        let magnitudes = Magnitudes::new(tissue, h, abs_h);
        roundings = roundings.max(magnitudes.energy_roundings(basis.len()));
        add(
            2,
            twin::elastic(tissue, weight, DMat3::IDENTITY + h, d),
            weight * magnitudes.energy_difference(h, d, abs_d),
        );
        let mut before = -displacement_gradient(basis, &drift);
        let mut abs_before = abs_gradient(basis, &drift);
        if !from_start {
            before += displacement_gradient(basis, &base_change);
            abs_before += abs_gradient(basis, &base_change);
        }
        let tangent = mat9(&tangents[i]);
        let abs_tangent = tangent.map(|row| row.map(f64::abs));
        let damping = |t, d, before| twin::damping(weight, rate, t, d, before);
        add(
            3,
            damping(&tangent, d, before),
            damping(&abs_tangent, abs(abs_d), abs_before),
        );
    }
    let (mut force, mut abs_force) = (DVec3::ZERO, DVec3::ZERO);
    let pairs = distances(scene, phase, slot)
        .into_iter()
        .zip(distances(scene, phase, base));
    for (k, ([x, y, z, depth], [.., before])) in pairs.enumerate() {
        let (v, c) = (k / scene.colliders.len(), k % scene.colliders.len());
        let stiffness = scene.contact_stiffness(v, c);
        let (depth, before) = (f64::from(depth).max(0.0), f64::from(before).max(0.0));
        let size = 0.5 * stiffness * (depth + before).powi(2);
        add(4, twin::contact(stiffness, before, depth), size);
        force += stiffness * depth * vec([x, y, z]);
        abs_force += stiffness * depth * vec([x, y, z]).abs();
    }

    for [(contact, before), (_, after)] in slid(scene, phase, slot, (!from_start).then_some(base)) {
        let (b, y) = (before.length(), after.length());
        let sizes = before.displacement.length() + after.displacement.length();
        let value = twin::friction(contact.limit, smoothing(), b, y);
        add(5, value, 4.0 * contact.limit * sizes);
        let (over_length, _) = smoothed_slopes(y, smoothing());
        force -= contact.limit * over_length * after.tangential();
        let cancelled = after.displacement.length() / y.min(smoothing());
        abs_force += DVec3::splat(4.0 * contact.limit * (1.0 + cancelled));
    }

    let summary: shared::Summary = scene.items(phase, "summaries", at, 1)[0];
    let got = summary.energy;
    let terms = [
        got.inertia,
        got.gravity,
        got.elastic,
        got.damping,
        got.contact,
        got.friction,
    ];
    let mut out = Comparison::default();
    let roundings = roundings + DAMPING_RATE + 6 + 1 + 6;
    for k in 0..6 {
        out.number(f64::from(terms[k]), want[k], magnitude[k], roundings);
        if want[k] == 0.0 {
            return Err(format!("energy {k} of the twin is zero"));
        }
    }
    out.vector(vec(got.force), force, abs_force, SLOPE + 13);
    out.finish("energies")
}
