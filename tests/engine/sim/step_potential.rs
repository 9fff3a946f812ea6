//! The potential of a step that is looked at from outside: its derivatives, and that it is the one that a step minimises.

use crate::support::{SMALL, full_space_limb};
use std::sync::Arc;
use supple::Result;
use supple::collider::{Collider, Shape};
use supple::glam::DVec3;
use supple::internal::math::Random;
use supple::model::{Frame, State};
use supple::potential::{CpuPotential, Evaluation, HessianForm};
use supple::sim::{Pin, Settings, Simulation, SkinSpring, SolverMode, StepPotential};

/// A held limb of two bones under a ball and drawn aside by its skin, some steps after it was let go.
fn pressed() -> Result<(Simulation<CpuPotential>, StepPotential)> {
    let avatar = Arc::new(full_space_limb(&SMALL, 2, false));
    let settings = Settings {
        time_step: 0.005,
        solver: SolverMode::Converged {
            tolerance: 1e-12,
            max_iterations: 200,
        },
        ..Settings::default()
    };
    let mut simulation = Simulation::new(&avatar, CpuPotential::new(avatar.clone(), 1)?, settings)?;
    let instance = &mut simulation.instances_mut()[0];
    instance.pins = vec![Pin {
        bone: 0,
        frame: Frame::IDENTITY,
    }];
    let frame = Frame {
        position: DVec3::new(0.12, 0.0, 0.056),
        ..Frame::IDENTITY
    };
    let mut ball = Collider::new(Shape::Sphere { radius: 0.02 }, frame);
    ball.friction = 0.4;
    instance.colliders.push(ball);
    let far = |a: &usize, b: &usize| {
        let along = |v: usize| avatar.skin.position[v].x;
        along(*a).total_cmp(&along(*b))
    };
    let vertex = (0..avatar.skin.len()).max_by(far).unwrap_or_default();
    let place = avatar.skin.position[vertex] + DVec3::new(0.002, 0.01, -0.004);
    instance
        .skin_springs
        .push(SkinSpring::new(&avatar, vertex, place, 300.0)?);
    for _ in 0..3 {
        simulation.step_blocking()?;
    }
    let instance = &simulation.instances()[0];
    let potential = StepPotential::new(avatar, instance, simulation.settings())?;
    Ok((simulation, potential))
}

fn unit(dofs: usize, k: usize) -> Vec<f64> {
    (0..dofs).map(|i| f64::from(u8::from(i == k))).collect()
}

fn largest(values: impl IntoIterator<Item = f64>) -> f64 {
    values.into_iter().map(f64::abs).fold(0.0, f64::max)
}

/// A step ends where the gradient of this very E vanishes on all DoFs that are free.
#[test]
fn a_converged_step_is_its_minimum() -> Result<()> {
    let (mut simulation, mut potential) = pressed()?;
    let fixed = potential.fixed().to_vec();
    assert_eq!(fixed.iter().filter(|f| **f).count(), 6);
    let mut free_gradient = |state: &State| -> Result<f64> {
        let mut out = Evaluation::default();
        potential.evaluate(state, HessianForm::Solver, &mut out)?;
        let free = out.gradient.iter().zip(&fixed).filter(|(_, f)| !**f);
        Ok(largest(free.map(|(g, _)| *g)))
    };
    let before = free_gradient(&simulation.instances()[0].state)?;
    let report = simulation.step_blocking()?;
    assert!(report.instances[0].contacts > 0);
    let after = free_gradient(&simulation.instances()[0].state)?;
    assert!(before > 1e-3, "{before}");
    assert!(after < 1e-5 * before, "{after} of {before}");
    Ok(())
}

#[test]
fn derivatives_are_those_of_the_energy() -> Result<()> {
    const STEP: f64 = 1e-6;
    let (_, mut potential) = pressed()?;
    let space = potential.space();
    let random = &mut Random::new(3);
    let off: Vec<f64> = (0..space.blocks())
        .flat_map(|_| random.vector(2e-4).to_array())
        .collect();
    let state = potential.start().moved(&off, 1.0);
    let mut at = |state: &State| -> Result<(f64, Evaluation)> {
        let mut out = Evaluation::default();
        let energies = potential.evaluate(state, HessianForm::Exact, &mut out)?;
        assert_eq!(energies, potential.energies(state)?);
        Ok((energies.total(), out))
    };
    let (_, exact) = at(&state)?;
    let scale = largest(exact.gradient.iter().copied());
    let mut columns = Vec::new();
    // A few of each kind: all of the bones', every seventh of the handles'.
    let bones = 3 * space.handle_block(0);
    let chosen: Vec<usize> = (0..bones).chain((bones..space.dofs()).step_by(7)).collect();
    for &k in &chosen {
        let e = unit(space.dofs(), k);
        let (ahead, behind) = (at(&state.moved(&e, STEP))?, at(&state.moved(&e, -STEP))?);
        let expected = (ahead.0 - behind.0) / (2.0 * STEP);
        let error = (exact.gradient[k] - expected).abs();
        assert!(error < 1e-6 * scale, "{k}: {expected}, off by {error}");
        let pairs = ahead.1.gradient.iter().zip(&behind.1.gradient);
        columns.push(
            pairs
                .map(|(a, b)| (a - b) / (2.0 * STEP))
                .collect::<Vec<_>>(),
        );
    }
    let scale = largest(exact.hessian.iter().flatten().copied());
    let entry = |i: usize, k: usize| {
        let (i, k) = (i.max(k), i.min(k));
        let block = potential.pattern().find(i / 3, k / 3);
        block.map_or(0.0, |b| exact.hessian[b][i % 3 + 3 * (k % 3)])
    };
    for (a, &i) in chosen.iter().enumerate() {
        for (b, &k) in chosen.iter().enumerate() {
            let expected = 0.5 * (columns[b][i] + columns[a][k]);
            let error = (entry(i, k) - expected).abs();
            assert!(
                error < 1e-5 * scale,
                "({i}, {k}): {expected}, off by {error}"
            );
        }
    }
    Ok(())
}
