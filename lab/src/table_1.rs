//! What a step costs, in the full space and in the reduced one.

use super::{Bound, Figure, Page, Runner};
use std::sync::Arc;
use supple::Result;
use supple::model::{Avatar, Integrator};
use supple::potential::{CpuPotential, Potential};
use supple::sim::{Simulation, SolverMode, Timings};
use supple_bake::full_space_simulation;
use supple_bake::subspace::modal;
use supple_pictures::Curves;
use supple_scene::{Driver, Scene};

/// See [`draw`].
pub const FIGURE: Figure = Figure {
    name: "table_1",
    title: "What a step costs",
    paper: "table 1",
    draw,
};

/// An avatar of the table.
struct Subject {
    name: &'static str,
    scene: &'static str,
    /// Cubature points, rising.
    points: &'static [usize],
    /// As many amplitudes as the handles have.
    modes: usize,
    /// The paper's force, Hessian, solve and step, ms: of the full space and of each number of points.
    paper: &'static [[f64; 4]],
}

const SMALL: &[Subject] = &[Subject {
    name: "finger",
    scene: "finger_press",
    points: &[100, 400],
    modes: 30,
    paper: &[],
}];
const FULL: &[Subject] = &[
    Subject {
        name: "hand",
        scene: "hand_press",
        points: &[700, 2000],
        modes: 261,
        paper: &[
            [1119.0, 2928.0, 6883.0, 10932.0],
            [1.01, 10.24, 0.51, 11.78],
            [1.87, 16.4, 0.53, 18.82],
        ],
    },
    Subject {
        name: "body",
        scene: "chest_press",
        points: &[500, 1400],
        modes: 246,
        paper: &[
            [882.0, 2401.0, 3947.0, 7233.0],
            [1.51, 7.16, 0.49, 9.17],
            [1.99, 11.63, 0.47, 14.1],
        ],
    },
];

/// The medians of a step's parts under full press.
fn draw(runner: &Runner) -> Result<Page> {
    let mut page = Page::new(
        "Medians of a step of one Newton iteration under full press, f64 on this machine's CPU, and the paper's numbers \
         (Intel i7-9750H). The force column is what is done point by point, with the tangents; the Hessian column is their \
         sum into block rows, with the gradient; contact, skin and the bones' own terms are in the step. The paper's body has \
         672 degrees of freedom, where 24 bones and 82 handles make 390.",
    );
    for subject in runner.pick(SMALL, FULL) {
        measure(runner, subject, &mut page)?;
    }
    Ok(page)
}

fn measure(runner: &Runner, subject: &Subject, page: &mut Page) -> Result<()> {
    let mut scene = runner.scene(subject.scene)?;
    // As the paper takes its times.
    scene.settings.integrator = Integrator::BackwardEuler;
    scene.settings.solver = SolverMode::OneIteration;
    let steps = runner.pick(7, 31);
    let (mut rows, mut growth) = (Vec::new(), Vec::new());
    let mut own = runner.avatar_of(&scene)?;

    let (avatar, simulation) = full_space_simulation(&own, 1, scene.settings)?;
    let full = pressed(&scene, &avatar, simulation, 20.0, 3)?;
    rows.push(line(subject, "full space", &avatar, &full, 0));
    let full_dofs = avatar.space().dofs();

    for (k, &points) in subject.points.iter().enumerate() {
        let mut scene = scene.clone();
        let (_, mut recipe) = scene.avatar.body()?;
        recipe.cubature.points = Some(points);
        scene.avatar = scene.avatar.baked_by(recipe)?;
        own = runner.avatar_of(&scene)?;
        let potential = CpuPotential::new(own.clone(), 1)?;
        let simulation = Simulation::new(&own, potential, scene.settings)?;
        let timings = pressed(&scene, &own, simulation, 4.0, steps)?;
        growth.push((points as f64, timings));
        let what = format!("{points} points");
        rows.push(line(subject, &what, &own, &timings, k + 1));
    }

    // With the points of the last one: a global basis needs them.
    let modes = modal(&own, subject.modes)?;
    let avatar = modes.space.avatar().clone();
    let simulation = (modes.space).simulation(1, scene.settings)?;
    let modal = pressed(&scene, &avatar, simulation, 20.0, 3)?;
    let what = format!("{} modes, {} points", subject.modes, avatar.cubature.len());
    rows.push(line(subject, &what, &avatar, &modal, usize::MAX));

    let name = subject.name;
    page.table(
        &format!("The {name}, ms, in brackets the paper's"),
        &[
            "space",
            "DoFs",
            "force",
            "Hessian",
            "solve",
            "step",
            "steps a second",
        ],
        rows,
    );
    let over = |f: fn(&Timings) -> f64| {
        let line = growth.iter().map(move |(points, t)| (*points, f(t)));
        line.collect::<Vec<_>>()
    };
    page.curves(
        Curves::new(&format!("The {name}"), "cubature points", "ms")
            .dots("step", over(|t| t.step))
            .dots("force", over(|t| t.force))
            .dots("Hessian", over(|t| t.hessian))
            .dots("solve", over(|t| t.solve)),
    );
    page.check(
        format!("{name}: degrees of freedom of the full space over the reduced ones"),
        full_dofs as f64 / own.space().dofs() as f64,
        "",
        Bound::AtLeast(10.0),
    );
    page.check(
        format!("{name}: least part of a step"),
        [&full, &modal]
            .into_iter()
            .chain(growth.iter().map(|(_, t)| t))
            .fold(f64::INFINITY, least_part),
        "ms",
        Bound::AtLeast(1e-6),
    );
    // A test's machine may do other work: times are judged in the gallery alone.
    if runner.small() {
        return Ok(());
    }
    let (first, last) = (growth[0], growth[growth.len() - 1]);
    page.check(
        format!("{name}: full space over reduced"),
        full.step / first.1.step,
        "",
        Bound::AtLeast(20.0),
    );
    page.check(
        format!("{name}: modes over handles"),
        modal.step / last.1.step,
        "",
        Bound::AtLeast(3.0),
    );
    page.check(
        format!("{name}: growth of the step over growth of the points"),
        (last.1.step / first.1.step) / (last.0 / first.0),
        "",
        Bound::AtMost(1.2),
    );
    Ok(())
}

/// The least of `least` and what a step spends on its parts, ms.
fn least_part(least: f64, t: &Timings) -> f64 {
    [t.force, t.hessian, t.solve, t.step]
        .into_iter()
        .fold(least, f64::min)
}

/// A line of the table; `paper` is the paper's line.
fn line(subject: &Subject, what: &str, avatar: &Avatar, t: &Timings, paper: usize) -> Vec<String> {
    let paper = subject.paper.get(paper);
    let cell = |k: usize, ms: f64| match paper {
        Some(line) => format!("{ms:.2} ({})", line[k]),
        None => format!("{ms:.2}"),
    };
    vec![
        what.into(),
        avatar.space().dofs().to_string(),
        cell(0, t.force),
        cell(1, t.hessian),
        cell(2, t.solve),
        cell(3, t.step),
        format!("{:.1}", 1e3 / t.step),
    ]
}

/// Plays `scene` in `hurry` times fewer steps until full press, then takes the medians of `steps` steps there.
fn pressed<P: Potential>(
    scene: &Scene,
    avatar: &Arc<Avatar>,
    mut simulation: Simulation<P>,
    hurry: f64,
    steps: usize,
) -> Result<Timings> {
    let mut driver = Driver::new(scene, avatar)?;
    driver.start(avatar, &mut simulation.instances_mut()[0]);
    driver.launch(avatar, &mut simulation.instances_mut()[0]);
    for step in 1..=scene.step_at(scene.measure.full_press / hurry) {
        let time = hurry * step as f64 * scene.settings.time_step;
        driver.drive(time, &mut simulation.instances_mut()[0])?;
        simulation.step_blocking()?;
    }
    let mut timed = Vec::new();
    for _ in 0..steps {
        timed.push(simulation.step_blocking()?.timings);
    }
    let median = |of: fn(&Timings) -> f64| {
        let mut values: Vec<f64> = timed.iter().map(of).collect();
        values.sort_by(f64::total_cmp);
        values[values.len() / 2]
    };
    let mut medians = Timings::default();
    medians.force = median(|t| t.force);
    medians.hessian = median(|t| t.hessian);
    medians.solve = median(|t| t.solve);
    medians.step = median(|t| t.step);
    Ok(medians)
}
