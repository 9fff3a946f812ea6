//! The benchmark's steps made in several ways, and what each makes of the tissue.

use crate::measure::{longest, volume_ratios};
use crate::{Bound, Page, Runner};
use std::sync::Arc;
use supple::Result;
use supple::internal::cpu::{min_det_f, posed_skin};
use supple::internal::math::par_map;
use supple::model::{Avatar, Integrator};
use supple::sim::SolverMode;
use supple_scene::{Scene, SceneRun};

/// Below this det F the smallest of the cubature points is said to be strained.
const STRAINED: f64 = 0.3;

/// Adds how the default run, the converged one of the same integrator, and the paper's compare.
pub(super) fn compare(
    runner: &Runner,
    page: &mut Page,
    scene: &Scene,
    avatar: &Arc<Avatar>,
    default: &SceneRun,
) -> Result<()> {
    let play = |integrator, solver| {
        let mut scene = scene.clone();
        scene.settings.integrator = integrator;
        scene.settings.solver = solver;
        scene.output.panels.clear();
        runner.play(&scene, avatar)
    };
    let converged = play(Integrator::Bdf2, SolverMode::CONVERGED)?;
    let paper = play(Integrator::BackwardEuler, SolverMode::OneIteration)?;
    let runs = [
        ("default", default),
        ("converged", &converged),
        ("backward Euler, one iteration", &paper),
    ];
    let mut rows = Vec::new();
    for (name, run) in runs {
        let steps = Inverted::of(avatar, run);
        let apart = 1e3 * apart(avatar, run, &converged);
        let report = &run.report;
        rows.push(vec![
            name.into(),
            format!("{:.2}", report.iterations),
            format!("{:.3}", report.det_f()),
            format!("{:.3}", steps.least_of_points),
            format!("{}", steps.inverted),
            format!("{}", steps.unseen),
            format!("{:.2}", report.max_penetration_mm),
            format!("{apart:.2}"),
        ]);
        if name == "default" {
            page.check(
                format!("{}: skin off the converged run at any step", scene.name),
                apart,
                "mm",
                Bound::AtMost(1.0),
            );
        }
    }
    page.table(
        &format!(
            "{}, friction 0.5, {} steps: tets that are turned inside out, and whether a cubature point, all that a \
             solver sees, told of it by a det F below {STRAINED}",
            scene.name, scene.steps
        ),
        &[
            "steps by",
            "iterations",
            "det F of tets",
            "of points",
            "steps with an inverted tet",
            "of them no point strained",
            "penetration (mm)",
            "skin off converged (mm)",
        ],
        rows,
    );
    Ok(())
}

/// How often tets are turned inside out.
struct Inverted {
    /// Smallest det F of a cubature point in any step.
    least_of_points: f64,
    /// Steps that end with such a tet.
    inverted: usize,
    /// Of these, steps that end with every point above [`STRAINED`].
    unseen: usize,
}

impl Inverted {
    fn of(avatar: &Avatar, run: &SceneRun) -> Self {
        let states = &run.recording.states;
        let ratios = par_map(states.len(), |k| {
            let points = volume_ratios(avatar, &states[k]).into_iter();
            let points = points.fold(f64::INFINITY, f64::min);
            (min_det_f(avatar, &states[k]), points)
        });
        let inverted = ratios.iter().filter(|(tets, _)| *tets <= 0.0);
        Self {
            least_of_points: ratios.iter().fold(f64::INFINITY, |m, r| m.min(r.1)),
            inverted: inverted.clone().count(),
            unseen: inverted.filter(|(_, points)| *points >= STRAINED).count(),
        }
    }
}

/// Largest distance of a skin vertex between two runs at the same step, m.
fn apart(avatar: &Avatar, a: &SceneRun, b: &SceneRun) -> f64 {
    let (a, b) = (&a.recording.states, &b.recording.states);
    let of_step = par_map(a.len().min(b.len()), |k| {
        let [a, b] = [&a[k], &b[k]].map(|state| posed_skin(avatar, state).positions);
        longest(a.iter().zip(&b).map(|(a, b)| *a - *b))
    });
    of_step.into_iter().fold(0.0, f64::max)
}
