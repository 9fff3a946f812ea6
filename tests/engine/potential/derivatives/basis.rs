//! A general basis against the scalar one, and one that no scalars make.

use super::case::cases;
use super::{STEP, evaluate, largest, unit};
use std::sync::Arc;
use supple::glam::DMat3;
use supple::internal::cpu::{GeneralBasis, HessianForm};
use supple::internal::math::{Random, Rows};
use supple::model::BasisEntry;
use supple::potential::{CpuPotential, Potential};

#[test]
fn a_general_basis_gives_what_the_scalar_one_gives() {
    let case = cases().pop().unwrap();
    let general = |rows: &Rows<BasisEntry>| rows.map(|entry| GeneralBasis::from(entry));
    let (cubature, skin) = (
        general(&case.avatar.cubature.basis),
        general(&case.avatar.skin.basis),
    );
    let avatar = Arc::new(case.avatar.clone());
    let other = CpuPotential::with_basis(avatar, &cubature, &skin, 1).unwrap();
    let mut other = case.begun(other);
    let mut scalar = case.reference();
    let [.., state] = case.states();
    let (a, b) = (evaluate(&mut scalar, &state), evaluate(&mut other, &state));
    let close = |x: &[f64], y: &[f64]| {
        let scale = largest(x.iter().copied());
        x.len() == y.len() && x.iter().zip(y).all(|(x, y)| (x - y).abs() < 1e-12 * scale)
    };
    assert!(close(&a.gradient, &b.gradient));
    assert!(close(a.hessian.as_flattened(), b.hessian.as_flattened()));
    assert!(close(&[a.energies.total()], &[b.energies.total()]));
}

#[test]
fn a_basis_that_is_not_scalar_has_true_derivatives_too() {
    let case = cases().pop().unwrap();
    let random = &mut Random::new(31);
    let mut mixed = |rows: &Rows<BasisEntry>| {
        rows.map(|entry| GeneralBasis {
            handle: entry.handle,
            value: random.matrix(0.1),
            gradient: [random.matrix(5.0), random.matrix(5.0), random.matrix(5.0)],
        })
    };
    let (cubature, skin) = (
        mixed(&case.avatar.cubature.basis),
        mixed(&case.avatar.skin.basis),
    );
    let avatar = Arc::new(case.avatar.clone());
    let mut potential = case.begun(CpuPotential::with_basis(avatar, &cubature, &skin, 1).unwrap());
    let [.., state] = case.states();
    let evaluation = evaluate(&mut potential, &state);
    let dofs = evaluation.gradient.len();
    let scale = largest(evaluation.gradient.iter().copied());
    for k in 0..dofs {
        let e = unit(dofs, k);
        let ahead = evaluate(&mut potential, &state.moved(&e, STEP)).energies;
        let behind = evaluate(&mut potential, &state.moved(&e, -STEP)).energies;
        let expected = (ahead.total() - behind.total()) / (2.0 * STEP);
        assert!(
            (evaluation.gradient[k] - expected).abs() < 1e-5 * scale,
            "{k}"
        );
    }
    let solver = potential
        .dense_hessian(0, &state, HessianForm::Solver)
        .unwrap();
    let scale = largest(solver.iter().flatten().copied());
    for ((row, column), block) in potential.pattern().blocks().zip(&evaluation.hessian) {
        let dense = DMat3::from_cols_array(&std::array::from_fn(|m| {
            solver[3 * row + m % 3][3 * column + m / 3]
        }));
        let error = (DMat3::from_cols_array(block) - dense).to_cols_array();
        assert!(largest(error) < 1e-12 * scale);
    }
}
