//! Every energy alone: its gradient is the derivative of its value, its exact Hessian that of its gradient, and
//! the Hessian that the solver gets is the stated projection. A term is one line in `tissue` or `skeleton`.

mod skeleton;
mod term;
mod tissue;

use supple::internal::cpu::HessianForm;
use term::{Energy, Moved, Term, largest, largest_entry};

fn terms() -> Vec<Term> {
    let mut terms = tissue::terms();
    terms.extend(skeleton::terms());
    terms
}

/// The step of differences, m or rad: rounding and the third derivative balance.
const STEP: f64 = 1e-6;

fn both_sides(dof: usize) -> [Moved; 2] {
    [-STEP, STEP].map(|length| Some((dof, length)))
}

/// ½ (D + Dᵀ) with D the central differences of the gradient: in rotations that step by R ← exp(δω) R, D itself
/// is symmetric only where the gradient vanishes.
fn symmetrised_differences(energy: &mut dyn Energy) -> Vec<Vec<f64>> {
    let dofs = energy.gradient(None).len();
    let columns: Vec<Vec<f64>> = (0..dofs)
        .map(|dof| {
            let [behind, ahead] = both_sides(dof).map(|moved| energy.gradient(moved));
            let pairs = ahead.iter().zip(&behind);
            pairs.map(|(a, b)| (a - b) / (2.0 * STEP)).collect()
        })
        .collect();
    let entry = |i: usize, k: usize| 0.5 * (columns[k][i] + columns[i][k]);
    (0..dofs)
        .map(|i| (0..dofs).map(|k| entry(i, k)).collect())
        .collect()
}

/// The largest |a − b|, over the size of `scale`.
fn apart(a: &[Vec<f64>], b: &[Vec<f64>], scale: f64) -> f64 {
    let pairs = a.iter().flatten().zip(b.iter().flatten());
    largest(&pairs.map(|(a, b)| a - b).collect::<Vec<_>>()) / scale
}

#[test]
fn gradients_are_central_differences_of_the_value() {
    for Term {
        name, mut energy, ..
    } in terms()
    {
        let gradient = energy.gradient(None);
        let scale = largest(&gradient);
        assert!(scale > 1e-6, "{name}: the gradient is zero");
        for dof in 0..gradient.len() {
            let [behind, ahead] = both_sides(dof);
            let expected = energy.difference(behind, ahead) / (2.0 * STEP);
            let found = gradient[dof];
            assert!(
                (found - expected).abs() < 2e-6 * scale,
                "{name}, DoF {dof}: {found} against {expected}"
            );
        }
    }
}

#[test]
fn differences_of_the_value_add_up_and_keep_their_digits() {
    for Term {
        name, mut energy, ..
    } in terms()
    {
        let gradient = energy.gradient(None);
        let (dofs, scale) = (gradient.len(), largest(&gradient));
        for dof in 0..dofs {
            let (there, further) = (Some((dof, 0.01)), Some(((dof + 7) % dofs, -0.02)));
            let legs = [(None, there), (there, further), (None, further)];
            let [ab, bc, ac] = legs.map(|(from, to)| energy.difference(from, to));
            let size = ab.abs() + bc.abs() + ac.abs();
            assert!((ab + bc - ac).abs() <= 1e-10 * size, "{name}, DoF {dof}");
            assert_eq!(energy.difference(there, there), 0.0, "{name}, DoF {dof}");
            // A move of 1e-9 m or rad is seen with its first-order value to six digits.
            let [behind, ahead] = [-1e-9, 1e-9].map(|length| Some((dof, length)));
            let tiny = energy.difference(behind, ahead) / 2e-9;
            assert!(
                (tiny - gradient[dof]).abs() < 1e-6 * scale,
                "{name}, DoF {dof}: {tiny} against {}",
                gradient[dof]
            );
        }
    }
}

#[test]
fn exact_hessians_are_symmetrised_differences_of_the_gradient() {
    for Term {
        name, mut energy, ..
    } in terms()
    {
        let exact = energy.hessian(HessianForm::Exact);
        let scale = largest_entry(&exact);
        assert!(scale > 1e-6, "{name}: the Hessian is zero");
        let error = apart(&exact, &symmetrised_differences(&mut *energy), scale);
        assert!(error < 3e-6, "{name}: {error:e}");
    }
}

#[test]
fn solver_hessians_are_the_stated_projection_and_positive_semi_definite() {
    for mut term in terms() {
        let name = &term.name;
        let solver = term.energy.hessian(HessianForm::Solver);
        let scale = largest_entry(&solver);
        if term.linear {
            assert!(scale < 1e-12, "{name}: {scale:e}");
            continue;
        }
        let dofs = solver.len();
        let dense = faer::Mat::from_fn(dofs, dofs, |i, k| solver[i][k]);
        let eigenvalues = dense.self_adjoint_eigenvalues(faer::Side::Lower).unwrap();
        let (least, most) = (eigenvalues[0], eigenvalues[dofs - 1]);
        assert!(least > -1e-12 * most, "{name}: {least} of {most}");
        if let Some(stated) = term.energy.stated_projection() {
            let error = apart(&solver, &stated, scale);
            assert!(error < 1e-12, "{name}: {error:e}");
        }
        if let Some(rest) = &mut term.at_rest {
            let solver = rest.hessian(HessianForm::Solver);
            let scale = largest_entry(&solver);
            let force = largest(&rest.gradient(None));
            assert!(force < 1e-11 * scale, "{name}: {force:e} at rest");
            let error = apart(&solver, &symmetrised_differences(&mut **rest), scale);
            assert!(error < 1e-8, "{name} at rest: {error:e}");
        }
    }
}
