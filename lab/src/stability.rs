//! Every scene for ten seconds, at long time steps.

use super::{Bound, Figure, Page, Runner};
use std::sync::Arc;
use supple::internal::math::par_map;
use supple::model::{Avatar, State};
use supple::sim::SolverMode;
use supple::{Error, Result};
use supple_pictures::Curves;
use supple_samples::Sample;
use supple_scene::{Scene, SceneRun};

/// See [`draw`].
pub const FIGURE: Figure = Figure {
    name: "stability",
    title: "Every scene for ten seconds",
    paper: "section 5",
    draw,
};

/// Steps a second, and how far each step minimises.
const MODES: [(f64, &str, SolverMode); 3] = [
    (60.0, "default", SolverMode::BUDGETED),
    (100.0, "default", SolverMode::BUDGETED),
    (30.0, "to 1e-8 m", SolverMode::CONVERGED),
];

/// Of whatever a scene leaves smooth: friction is the harder case.
const FRICTION: f64 = 0.5;

/// A scene in one mode.
struct Case {
    scene: Scene,
    avatar: Arc<Avatar>,
    rate: f64,
    solver: &'static str,
}

/// What came of it.
struct Outcome {
    run: SceneRun,
    /// Speed of the fastest handle in each step, m/s.
    speeds: Vec<f64>,
}

/// Plays every committed scene (in a test those of small avatars, for one second) and looks for what does not
/// hold: an error, an inverted tet, motion that grows.
fn draw(runner: &Runner) -> Result<Page> {
    let mut page = Page::new(
        "Every scene at 60 and 100 frames a second with the default solver, and at 30 with iterations to the end; \
         whatever a scene leaves smooth has a friction of 0.5. After its script a scene is left as it is. A method that is not stable shows it by speeds that grow, \
         and a tissue that is pressed too hard by a det F of 0 and below.",
    );
    let cases = cases(runner)?;
    let outcomes = par_map(cases.len(), |k| {
        let case = &cases[k];
        runner.play(&case.scene, &case.avatar).map(|run| Outcome {
            speeds: speeds(&run.recording.states, 1.0 / case.rate),
            run,
        })
    });
    let mut rows = Vec::new();
    let mut chart = Curves::new(
        "Fastest handle, 60 frames a second, default solver",
        "time (s)",
        "speed (mm/s)",
    )
    .logarithmic();
    for (case, outcome) in cases.iter().zip(&outcomes) {
        let name = format!("{}, {} Hz", case.scene.name, case.rate);
        let outcome = match outcome {
            Ok(outcome) => outcome,
            Err(error) => {
                page.text(format!("{name}: {error}"));
                page.check(format!("{name}: steps made"), 0.0, "", steps(&case.scene));
                continue;
            }
        };
        let (early, late) = outcome.speeds.split_at(outcome.speeds.len() / 2);
        let (early, late) = (most(early), most(late));
        let report = &outcome.run.report;
        rows.push(vec![
            case.scene.name.clone(),
            format!("{}", case.rate),
            case.solver.into(),
            format!("{:.2}", report.iterations),
            format!("{:.3}", 1e3 * report.energy.elastic_largest),
            format!("{:.2}", report.max_unposed_displacement_mm),
            format!("{:.1}", 1e3 * early.max(late)),
            format!(
                "{:.2}",
                1e3 * outcome.speeds.last().copied().unwrap_or_default()
            ),
            format!("{:.3}", report.max_penetration_mm),
            format!("{:.4}", report.max_joint_gap_mm),
            format!("{:.3}", report.det_f()),
        ]);
        page.check(
            format!("{name}: smallest det F"),
            report.det_f(),
            "",
            Bound::AtLeast(1e-3),
        );
        if !runner.small() {
            // A script may end in the second half; nothing that it does is faster than 1 m/s.
            page.check(
                format!("{name}: fastest handle in the second half"),
                late,
                "m/s",
                Bound::AtMost(early.max(1.0)),
            );
        }
        if case.rate == 60.0 {
            let points = outcome.speeds.iter().enumerate();
            let points = points.map(|(k, v)| ((k + 1) as f64 / case.rate, 1e3 * v));
            chart = chart.line(&case.scene.name, points);
        }
    }
    page.table(
        "Largest values over all steps.",
        &[
            "scene",
            "frames/s",
            "solver",
            "iterations",
            "elastic energy (mJ)",
            "displacement (mm)",
            "fastest handle (mm/s)",
            "at the end (mm/s)",
            "penetration (mm)",
            "joint gap (mm)",
            "det F",
        ],
        rows,
    );
    page.curves(chart);
    Ok(page)
}

fn steps(scene: &Scene) -> Bound {
    Bound::AtLeast(scene.steps as f64)
}

fn cases(runner: &Runner) -> Result<Vec<Case>> {
    let mut cases = Vec::new();
    for name in runner.scenes()? {
        let scene = runner.scene(&name)?;
        let small = matches!(scene.avatar.sample(), Some(Sample::Finger | Sample::LimbS));
        if runner.small() && !small {
            continue;
        }
        let avatar = runner.avatar_of(&scene)?;
        for (rate, solver, mode) in MODES {
            let mut scene = scene.clone();
            scene.settings.time_step = 1.0 / rate;
            scene.settings.solver = mode;
            for collider in scene.colliders.iter_mut().filter(|c| c.friction == 0.0) {
                collider.friction = FRICTION;
            }
            scene.steps = (rate * runner.pick(1.0, 10.0)) as usize;
            scene.output.panels.clear();
            cases.push(Case {
                scene,
                avatar: avatar.clone(),
                rate,
                solver,
            });
        }
    }
    if cases.is_empty() {
        return Err(Error::invalid("scenes", "there are none to play"));
    }
    Ok(cases)
}

/// Speed of the fastest handle from each state to the next, m/s.
fn speeds(states: &[State], time_step: f64) -> Vec<f64> {
    let speed = |pair: &[State]| {
        let handles = pair[0].handles.iter().zip(&pair[1].handles);
        most(
            handles
                .map(|(a, b)| a.distance(*b) / time_step)
                .collect::<Vec<_>>()
                .as_slice(),
        )
    };
    states.windows(2).map(speed).collect()
}

fn most(values: &[f64]) -> f64 {
    values.iter().copied().fold(0.0, f64::max)
}
