//! Both solvers of a Newton step: right to rounding, prescribed DoFs untouched, and a way out of
//! every failed factorisation.

use supple::internal::math::Random;
use supple::internal::random_avatar;
use supple::potential::BlockPattern;
use supple::sim::{DenseCholesky, LinearSolver};
use supple_bake::SparseCholesky;

/// A pattern of 3 bones and 20 handles that is not full.
fn pattern() -> BlockPattern {
    let avatar = random_avatar(1, 3, 20, 12, 12);
    BlockPattern::new(avatar.space(), &[], &[&avatar.cubature])
}

/// Σ over points J Jᵀ within the pattern, with bone stiffness `contrast` times that of handles, and
/// `diagonal` of the mean diagonal added.
fn definite(pattern: &BlockPattern, contrast: f64, diagonal: f64) -> Vec<[f64; 9]> {
    let avatar = random_avatar(1, 3, 20, 12, 12);
    let random = &mut Random::new(2);
    let mut hessian = vec![[0.0; 9]; pattern.len()];
    let mut touched = Vec::new();
    let bones = 2 * pattern.space().frames as u32;
    for i in 0..avatar.cubature.len() {
        supple::internal::features::point_blocks(
            pattern.space(),
            &avatar.cubature,
            i,
            &mut touched,
        );
        touched.sort_unstable();
        let jacobians: Vec<_> = touched
            .iter()
            .map(|b| random.matrix(1.0) * if *b < bones { contrast } else { 1.0 })
            .collect();
        for (a, row) in touched.iter().enumerate() {
            for (b, column) in touched[..=a].iter().enumerate() {
                let at = pattern.find(*row as usize, *column as usize).unwrap();
                let value = (jacobians[a].transpose() * jacobians[b]).to_cols_array();
                for (entry, v) in hessian[at].iter_mut().zip(value) {
                    *entry += v;
                }
            }
        }
    }
    for (block, (row, column)) in hessian.iter_mut().zip(pattern.blocks()) {
        let size = if row < bones as usize {
            contrast * contrast
        } else {
            1.0
        };
        if row == column {
            (0..3).for_each(|k| block[4 * k] += diagonal * size);
        }
    }
    hessian
}

fn dense(pattern: &BlockPattern, hessian: &[[f64; 9]]) -> faer::Mat<f64> {
    let dofs = pattern.space().dofs();
    let mut full = faer::Mat::zeros(dofs, dofs);
    for (block, (row, column)) in hessian.iter().zip(pattern.blocks()) {
        for (k, value) in block.iter().enumerate() {
            full[(3 * row + k % 3, 3 * column + k / 3)] = *value;
            full[(3 * column + k / 3, 3 * row + k % 3)] = *value;
        }
    }
    full
}

fn solvers(pattern: &BlockPattern) -> Vec<(&'static str, Box<dyn LinearSolver>)> {
    vec![
        ("dense", Box::new(DenseCholesky::new(pattern))),
        ("sparse", Box::new(SparseCholesky::new(pattern).unwrap())),
    ]
}

fn gradient(dofs: usize) -> Vec<f64> {
    let random = &mut Random::new(9);
    (0..dofs).map(|_| random.uniform(-1.0, 1.0)).collect()
}

/// Every third DoF of the first bone, and one handle.
fn some_fixed(dofs: usize) -> Vec<bool> {
    (0..dofs)
        .map(|i| (i < 18 && i % 3 == 0) || (30..33).contains(&i))
        .collect()
}

/// |(g + H δ)_free| / |g_free|.
fn residual(full: &faer::Mat<f64>, gradient: &[f64], fixed: &[bool], step: &[f64]) -> f64 {
    let (mut error, mut size) = (0.0, 0.0);
    for i in (0..step.len()).filter(|&i| !fixed[i]) {
        let row: f64 = (0..step.len()).map(|j| full[(i, j)] * step[j]).sum();
        error += (row + gradient[i]).powi(2);
        size += gradient[i].powi(2);
    }
    (error / size).sqrt()
}

#[test]
fn solves_to_rounding_and_leaves_fixed_dofs() {
    let pattern = pattern();
    let hessian = definite(&pattern, 300.0, 0.05);
    let dofs = pattern.space().dofs();
    let (full, gradient) = (dense(&pattern, &hessian), gradient(dofs));
    for fixed in [vec![false; dofs], some_fixed(dofs)] {
        for (name, mut solver) in solvers(&pattern) {
            let mut step = vec![f64::NAN; dofs];
            let report = solver
                .solve(&hessian, &gradient, &fixed, &mut step)
                .unwrap();
            assert_eq!(report.diagonal_shift, 0.0, "{name}");
            let error = residual(&full, &gradient, &fixed, &step);
            // One refinement of an f32 factor: (κ ε₃₂)².
            assert!(error < 1e-6, "{name}: {error:e}");
            assert!((0..dofs).all(|i| !fixed[i] || step[i] == 0.0), "{name}");
            assert!(report.residual < 1e-6, "{name}: {:e}", report.residual);
        }
    }
}

/// What a solver has solved before leaves no trace, and blocks of fixed DoFs are nothing to it.
#[test]
fn fixed_dofs_are_not_in_the_dense_matrix() {
    let pattern = pattern();
    let hessian = definite(&pattern, 300.0, 0.05);
    let dofs = pattern.space().dofs();
    let gradient = gradient(dofs);
    // The second bone, which handles move with, and a handle; then none; then single DoFs.
    let blocks: Vec<bool> = (0..dofs)
        .map(|i| (6..12).contains(&i) || (30..33).contains(&i))
        .collect();
    let mut kept = DenseCholesky::new(&pattern);
    for fixed in [blocks.clone(), vec![false; dofs], some_fixed(dofs), blocks] {
        let mut other = hessian.clone();
        for (block, (row, column)) in other.iter_mut().zip(pattern.blocks()) {
            for (k, entry) in block.iter_mut().enumerate() {
                if fixed[3 * row + k % 3] || fixed[3 * column + k / 3] {
                    *entry = 1e3;
                }
            }
        }
        let solve = |solver: &mut DenseCholesky, hessian: &[[f64; 9]]| {
            let mut step = vec![f64::NAN; dofs];
            let report = solver.solve(hessian, &gradient, &fixed, &mut step).unwrap();
            (step, report)
        };
        let expected = solve(&mut DenseCholesky::new(&pattern), &hessian);
        assert_eq!(solve(&mut kept, &hessian), expected);
        assert_eq!(solve(&mut kept, &other), expected);
    }
}

#[test]
fn ill_conditioned_systems_go_to_double_precision() {
    let pattern = pattern();
    let dofs = pattern.space().dofs();
    let (fixed, gradient) = (vec![false; dofs], gradient(dofs));
    // 36 rows of rank against 78 DoFs: the condition number is that of the diagonal that is added,
    // from where f32 serves, over where its factor is too coarse, to where it has none.
    for exponent in 1..=7 {
        let hessian = definite(&pattern, 30.0, 0.1f64.powi(exponent));
        let full = dense(&pattern, &hessian);
        for (name, mut solver) in solvers(&pattern) {
            let mut step = vec![0.0; dofs];
            let report = solver
                .solve(&hessian, &gradient, &fixed, &mut step)
                .unwrap();
            assert_eq!(report.diagonal_shift, 0.0, "{name}");
            assert!(report.residual < 1e-4, "{name}: {:e}", report.residual);
            // Unscaled rows differ by the contrast.
            let error = residual(&full, &gradient, &fixed, &step);
            assert!(error < 30.0 * 1e-4, "{name}, 1e-{exponent}: {error:e}");
        }
    }
}

#[test]
fn indefinite_systems_are_shifted_into_a_descent_direction() {
    let pattern = pattern();
    let mut hessian = definite(&pattern, 300.0, 0.05);
    let dofs = pattern.space().dofs();
    let fixed = vec![false; dofs];
    let gradient = gradient(dofs);
    // The smallest eigenvalue of the scaled matrix goes just below zero.
    for (block, (row, column)) in hessian.iter_mut().zip(pattern.blocks()) {
        if row == column {
            (0..3).for_each(|k| block[4 * k] *= 1.0 - 0.0045);
        }
    }
    let smallest = {
        let full = dense(&pattern, &hessian);
        let scale = |i: usize| full[(i, i)].sqrt().recip();
        let scaled = faer::Mat::from_fn(dofs, dofs, |i, j| scale(i) * full[(i, j)] * scale(j));
        scaled.self_adjoint_eigenvalues(faer::Side::Lower).unwrap()[0]
    };
    assert!((-1e-2..-1e-4).contains(&smallest), "{smallest:e}");
    for (name, mut solver) in solvers(&pattern) {
        let mut step = vec![0.0; dofs];
        let report = solver
            .solve(&hessian, &gradient, &fixed, &mut step)
            .unwrap();
        assert_eq!(report.diagonal_shift, 1e-2, "{name}");
        let slope: f64 = gradient.iter().zip(&step).map(|(g, s)| g * s).sum();
        assert!(slope < 0.0, "{name}: {slope:e}");
    }
}

#[test]
fn hopeless_systems_are_typed_errors() {
    let pattern = pattern();
    let dofs = pattern.space().dofs();
    let (fixed, gradient) = (vec![false; dofs], gradient(dofs));
    let negative = definite(&pattern, 1.0, 0.1)
        .iter()
        .map(|b| b.map(|v| -v))
        .collect();
    let mut unfinished = definite(&pattern, 1.0, 0.1);
    unfinished[5][0] = f64::NAN;
    let mut infinite = definite(&pattern, 1.0, 0.1);
    infinite[2][4] = f64::INFINITY;
    for hessian in [negative, unfinished, infinite] {
        for (name, mut solver) in solvers(&pattern) {
            let mut step = vec![0.0; dofs];
            let solved = solver.solve(&hessian, &gradient, &fixed, &mut step);
            let error = solved.expect_err(name);
            assert!(
                matches!(error, supple::Error::Solve { .. }),
                "{name}: {error}"
            );
            // And it serves again afterwards.
            let hessian = definite(&pattern, 10.0, 0.1);
            solver
                .solve(&hessian, &gradient, &fixed, &mut step)
                .unwrap();
            assert!(step.iter().all(|s| s.is_finite()), "{name}");
        }
    }
}
