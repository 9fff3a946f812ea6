//! How Newton's method converges.

use super::{Bound, Figure, Page, Runner};
use faer::linalg::solvers::DenseSolveCore;
use faer::{Mat, Side};
use std::sync::Arc;
use supple::Result;
use supple::gpu::{AdapterChoice, GpuDevice};
use supple::internal::cpu::Exact;
use supple::model::{Avatar, Integrator, Space, State};
use supple::potential::{
    BlockPattern, CpuPotential, GpuOptions, GpuPotential, HessianForm, Potential,
};
use supple::sim::{Instance, Iteration, Settings, Simulation, SolverMode, StepReport};
use supple_bake::SparseCholesky;
use supple_pictures::Curves;
use supple_scene::{Driver, Scene};

/// See [`draw`].
pub const FIGURE: Figure = Figure {
    name: "convergence",
    title: "Newton's method, iteration by iteration",
    paper: "",
    draw,
};

/// Steps of 1/30 s made before the one that is looked at: the finger is then pressed at its fastest.
const STEPS: usize = 20;
const TIME_STEP: f64 = 1.0 / 30.0;

/// Iterations looked at.
const ITERATIONS: usize = 14;

/// What f32 resolves of E, J.
const ENERGY_RESOLUTION: f64 = 1e-8;

/// One step of the pressed finger, minimised by three potentials from the same start: how far from the minimum each
/// iteration ends.
fn draw(runner: &Runner) -> Result<Page> {
    let mut page = Page::new(
        "One step of 1/30 s, a finger on its way into a cylinder: distance of the iterate from the minimum. With \
         the exact Hessian (all second derivatives, f64) Newton's method converges quadratically once it knows \
         which vertices touch: each iteration doubles the digits. The solver's Hessian leaves out the geometric \
         terms and projects the tangent, so that it is always positive definite, and converges linearly; those of \
         contact are a setting. On a GPU \
         the forces are of f32: it ends where a step changes the energy by less than f32 resolves.",
    );
    let mut scene = runner.scene("finger_press")?;
    scene.settings.time_step = TIME_STEP;
    // One step: under BDF2 a frame that long takes two.
    scene.settings.integrator = Integrator::BackwardEuler;
    scene.settings.solver = SolverMode::CONVERGED;
    let avatar = runner.avatar_of(&scene)?;
    let start = before_the_step(&scene, &avatar)?;

    let reference = || CpuPotential::new(avatar.clone(), 1);
    let mut exact = simulation(&scene, &avatar, Exact(reference()?))?;
    iterates(&mut exact, &start, 60)?;
    let minimum = exact.instances()[0].state.clone();
    let floor = energy_floor(&mut exact, &start, &minimum)?;

    let exact = errors(&mut exact, &start, &minimum)?;
    let mut solver = simulation(&scene, &avatar, reference()?)?;
    let solver = errors(&mut solver, &start, &minimum)?;
    scene.settings.geometric_contact = true;
    let mut geometric = simulation(&scene, &avatar, reference()?)?;
    let geometric = errors(&mut geometric, &start, &minimum)?;
    scene.settings.geometric_contact = false;
    let line = |errors: &[f64]| -> Vec<(f64, f64)> {
        let points = errors.iter().enumerate();
        points.map(|(k, e)| (k as f64, *e)).collect()
    };
    let mut chart = Curves::new("", "iterations", "distance from the minimum (m)")
        .logarithmic()
        .dots("exact Hessian", line(&exact))
        .dots("solver's Hessian", line(&solver))
        .dots("with contact's geometric terms", line(&geometric));

    page.check(
        "distance left by an iteration, for its square before, with the exact Hessian",
        quadratic_rate(&exact),
        "1/m",
        Bound::AtMost(QUADRATIC),
    );
    page.check(
        "distance reached with the exact Hessian",
        exact[ITERATIONS],
        "m",
        Bound::AtMost(1e-13),
    );
    page.check(
        "distance reached with the solver's Hessian",
        solver[ITERATIONS],
        "m",
        Bound::AtMost(1e-6),
    );
    page.check(
        "distance reached with the geometric terms of contact",
        geometric[ITERATIONS],
        "m",
        Bound::AtMost(1e-6),
    );
    match pollster::block_on(GpuDevice::open(AdapterChoice::HardwareElseSoftware)) {
        Err(error) => page.text(format!("There is no GPU curve: {error}.")),
        Ok(gpu) => {
            let (device, queue) = (&gpu.device, &gpu.queue);
            let options = GpuOptions::default();
            let potential = GpuPotential::new(device, queue, avatar.clone(), 1, options)?;
            let name = potential.name();
            let mut simulation = simulation(&scene, &avatar, potential)?;
            let errors = errors(&mut simulation, &start, &minimum)?;
            page.check(
                "distance reached on the GPU",
                errors[ITERATIONS],
                "m",
                Bound::AtMost(floor),
            );
            page.text(format!(
                "On the GPU ({name}) steps shorter than {floor:.1e} m change the energy by less than f32 resolves of \
                 it (1e-8 J). It ends {:.1e} m from the minimum.",
                errors[ITERATIONS]
            ));
            chart = chart.dots("solver's Hessian, GPU", line(&errors));
        }
    }
    page.curves(chart);
    Ok(page)
}

/// The scene's instance before the step that is looked at, driven to that step's end.
fn before_the_step(scene: &Scene, avatar: &Arc<Avatar>) -> Result<Instance> {
    let potential = CpuPotential::new(avatar.clone(), 1)?;
    let mut simulation = simulation(scene, avatar, potential)?;
    let mut driver = Driver::new(scene, avatar)?;
    driver.start(avatar, &mut simulation.instances_mut()[0]);
    driver.launch(avatar, &mut simulation.instances_mut()[0]);
    for step in 1..=STEPS {
        driver.drive(step as f64 * TIME_STEP, &mut simulation.instances_mut()[0])?;
        simulation.step_blocking()?;
    }
    let end = (STEPS + 1) as f64 * TIME_STEP;
    driver.drive(end, &mut simulation.instances_mut()[0])?;
    Ok(simulation.instances()[0].clone())
}

/// With a factorisation in f64 throughout.
fn simulation<P: Potential>(scene: &Scene, avatar: &Avatar, potential: P) -> Result<Simulation<P>> {
    let solver = Box::new(SparseCholesky::new(potential.pattern())?);
    Simulation::with_solver(avatar, potential, scene.settings, solver)
}

/// One step from `start` with at most `iterations` iterations: their iterates, and where the last one leads.
fn iterates<P: Potential>(
    simulation: &mut Simulation<P>,
    start: &Instance,
    iterations: usize,
) -> Result<Vec<State>> {
    let settings = *simulation.settings();
    simulation.set_settings(Settings {
        solver: SolverMode::Converged {
            tolerance: f64::MIN_POSITIVE,
            max_iterations: iterations,
        },
        ..settings
    })?;
    simulation.instances_mut()[0].clone_from(start);
    let mut iterates = Vec::new();
    let mut observer = |iteration: &Iteration<'_>| iterates.push(iteration.state.clone());
    let mut report = StepReport::default();
    pollster::block_on(simulation.step_observed(&mut report, &mut observer))?;
    iterates.push(simulation.instances()[0].state.clone());
    Ok(iterates)
}

/// Distance from the minimum after 0, 1, 2, … iterations, m. The 0th is that of qⁿ; what stops early stays.
fn errors<P: Potential>(
    simulation: &mut Simulation<P>,
    start: &Instance,
    minimum: &State,
) -> Result<Vec<f64>> {
    let iterates = iterates(simulation, start, ITERATIONS)?;
    let mut errors = vec![distance(&start.state, minimum)];
    // The first iterate is the prediction, after no iteration.
    errors.extend(iterates[1..].iter().map(|state| distance(state, minimum)));
    errors.resize(ITERATIONS + 1, errors[errors.len() - 1]);
    Ok(errors)
}

/// Largest distance of a handle's displacement or a joint, m.
fn distance(a: &State, b: &State) -> f64 {
    let handles = a.handles.iter().zip(&b.handles);
    let handles = handles.map(|(a, b)| a.distance(*b));
    let joints = a.frames.iter().zip(&b.frames);
    let joints = joints.map(|(a, b)| a.position.distance(b.position));
    handles.chain(joints).fold(0.0, f64::max)
}

/// Rounding of a place of some cm, m.
const ROUNDING: f64 = 1e-14;

/// 1/m: a Hessian that changes by itself over a millimetre, a fifth of the layer's depth. A method of linear convergence
/// reaches a million times as much.
const QUADRATIC: f64 = 1e3;
/// The contacts are known from here on, m.
const KNOWN: f64 = 1e-4;

/// C of e_{k+1} ≤ C e_k² once the contacts are known, for errors whose squares would be above rounding, with
/// a C that is allowed; infinite where there is none.
fn quadratic_rate(errors: &[f64]) -> f64 {
    // What is at rounding at once is within the bound too.
    let known = |e: &&[f64]| e[0] < KNOWN && QUADRATIC * e[0] * e[0] > 10.0 * ROUNDING;
    let pairs = errors.windows(2).filter(known);
    let rate = pairs.map(|e| e[1] / (e[0] * e[0])).reduce(f64::max);
    rate.unwrap_or(f64::INFINITY)
}

/// The longest step of a handle or a joint that changes the energy by [`ENERGY_RESOLUTION`] at most near its minimum,
/// m: |δ_i|² ≤ (H⁻¹)_ii δᵀHδ = 2 (H⁻¹)_ii ΔE.
fn energy_floor(
    simulation: &mut Simulation<Exact>,
    start: &Instance,
    minimum: &State,
) -> Result<f64> {
    let potential = &simulation.potential().0;
    let mut hessian = potential.dense_hessian(0, minimum, HessianForm::Solver)?;
    simulation.instances_mut()[0].clone_from(start);
    let rows = 2 * minimum.frames.len();
    let mut bones = vec![[0.0; 9]; rows * (rows + 1) / 2];
    let skeleton = simulation.skeleton_potential(0);
    let gradient = &mut vec![0.0; hessian.len()];
    let space = Space {
        frames: minimum.frames.len(),
        handles: 0,
    };
    let pattern = BlockPattern::new(space, &[], &[]);
    skeleton.add_derivatives(&minimum.frames, gradient, &mut bones, &pattern);
    for row in 0..rows {
        for column in 0..=row {
            let block = &bones[row * (row + 1) / 2 + column];
            for (k, value) in block.iter().enumerate() {
                hessian[3 * row + k % 3][3 * column + k / 3] += value;
            }
        }
    }
    // Cholesky reads the lower triangle only.
    let dofs = hessian.len();
    let dense = Mat::from_fn(dofs, dofs, |i, k| hessian[i][k]);
    let Ok(factor) = dense.llt(Side::Lower) else {
        return Ok(f64::NAN);
    };
    let inverse = factor.inverse();
    let is_length = |dof: &usize| dof / 3 >= rows || (dof / 3).is_multiple_of(2);
    let softest = (0..dofs).filter(is_length).map(|i| inverse[(i, i)]);
    Ok((2.0 * ENERGY_RESOLUTION * softest.fold(0.0, f64::max)).sqrt())
}
