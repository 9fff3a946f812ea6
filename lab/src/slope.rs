//! A soft block on slopes, against Coulomb's law.

use super::press::limb_recipe;
use super::{Bound, Figure, Page, Runner};
use glam::DVec3;
use std::sync::Arc;
use supple::Result;
use supple::collider::{Collider, Shape};
use supple::internal::math::par_map;
use supple::model::{Avatar, Frame, Integrator};
use supple::potential::{CpuPotential, Potential};
use supple::sim::{Settings, Simulation, SolverMode};
use supple_bake::{HandleRegion, Recipe, SparseCholesky, bake, full_space};
use supple_pictures::Curves;
use supple_samples::Limb;

/// See [`draw`].
pub const FIGURE: Figure = Figure {
    name: "slope",
    title: "A soft block on slopes",
    paper: "",
    draw,
};

const FRICTION: f64 = 0.5;
const GRAVITY: f64 = 9.81;
/// How long it slides, s.
const DURATION: f64 = 2.0;
/// Steps to converge in: it lies down, and the converged runs.
const CONVERGED: SolverMode = SolverMode::Converged {
    tolerance: 1e-10,
    max_iterations: 100,
};

/// What it lies on and slides by: a soft limb around its bone.
const BLOCK: Limb = Limb {
    length: 0.25,
    inner_radius: 0.015,
    outer_radius: 0.04,
    stations: 6,
    layers: 2,
    sectors: 6,
};

/// How steps are made.
const MODES: [(&str, Integrator, SolverMode); 3] = [
    ("default", Integrator::Bdf2, SolverMode::BUDGETED),
    (
        "backward Euler, one iteration",
        Integrator::BackwardEuler,
        SolverMode::OneIteration,
    ),
    ("converged", Integrator::Bdf2, CONVERGED),
];

/// A slide.
#[derive(Clone, Copy)]
struct Case {
    /// Into [`spaces`].
    space: usize,
    /// Into [`MODES`].
    mode: usize,
    rate: f64,
    degrees: f64,
    /// Along the slope at the start, m/s.
    speed: f64,
}

impl Case {
    /// As Coulomb has it after [`DURATION`], m/s: at rest where friction can hold it.
    fn expected(&self) -> f64 {
        let (sine, cosine) = self.degrees.to_radians().sin_cos();
        let pull = GRAVITY * (sine - FRICTION * cosine);
        (self.speed + DURATION * pull).max(0.0)
    }

    /// How far `speed` may be off that, m/s: 3 %, and the slip speed below which friction is not whole.
    fn tolerance(&self) -> f64 {
        0.03 * self.expected() + Settings::default().slip_speed
    }
}

/// How it went.
struct Slide {
    /// Along the slope in the end, m/s.
    speed: f64,
    iterations: f64,
}

/// Lets a block that lies on the ground slide for two seconds once the ground tilts, and compares its speed with
/// Coulomb's law.
fn draw(runner: &Runner) -> Result<Page> {
    let mut page = Page::new(
        "A soft block (30 kPa, a limb of 4 cm radius around its bone) lies on the ground; the ground tilts, and two \
         seconds later it has g (sin α − μ cos α) times 2 s of speed more, or none where friction holds it: below \
         26.6° with μ = 0.5. In the paper's mode, backward Euler with one Newton iteration a step, the first guess of a \
         step does not see friction give way; the default takes the iterations that it needs.",
    );
    let spaces = spaces()?;
    let cases = cases(runner);
    let slides = par_map(cases.len(), |k| slide(&spaces[cases[k].space].1, cases[k]));
    let slides = slides.into_iter().collect::<Result<Vec<Slide>>>()?;
    let mut rows = Vec::new();
    for (case, slide) in cases.iter().zip(&slides) {
        let expected = case.expected();
        let space = &spaces[case.space].0;
        let (mode, ..) = MODES[case.mode];
        rows.push(vec![
            space.clone(),
            mode.into(),
            format!("{}", case.rate),
            format!("{}°", case.degrees),
            format!("{}", case.speed),
            format!("{expected:.3}"),
            format!("{:.3}", slide.speed),
            match expected {
                0.0 => "–".into(),
                _ => format!("{:+.1} %", 100.0 * (slide.speed / expected - 1.0)),
            },
            format!("{:.2}", slide.iterations),
        ]);
        // The paper's mode is shown, and claims nothing.
        if case.mode != 1 {
            page.check(
                format!(
                    "{space}, {mode}, {} Hz, {}° from {} m/s: off Coulomb's speed",
                    case.rate, case.degrees, case.speed
                ),
                (slide.speed - expected).abs(),
                "m/s",
                Bound::AtMost(case.tolerance()),
            );
        }
    }
    for (k, (space, _)) in spaces.iter().enumerate() {
        for rate in RATES {
            let shown = |case: &Case| case.space == k && case.rate == rate && case.speed == 0.0;
            if let Some(chart) = chart(space, rate, &cases, &slides, shown) {
                page.curves(chart);
            }
        }
    }
    page.table(
        "After two seconds.",
        &[
            "space",
            "steps by",
            "steps/s",
            "slope",
            "from (m/s)",
            "Coulomb (m/s)",
            "speed (m/s)",
            "off",
            "iterations",
        ],
        rows,
    );
    Ok(page)
}

const RATES: [f64; 2] = [60.0, 100.0];

/// Speeds of the slides that are `shown` over the slope; none where there is nothing to show.
fn chart(
    space: &str,
    rate: f64,
    cases: &[Case],
    slides: &[Slide],
    shown: impl Fn(&Case) -> bool,
) -> Option<Curves> {
    let shown: Vec<(&Case, &Slide)> = (cases.iter().zip(slides))
        .filter(|(case, _)| shown(case))
        .collect();
    let steepest = shown
        .iter()
        .map(|(case, _)| case.degrees)
        .fold(0.0, f64::max);
    let first = shown.first()?.0;
    let law = (40..=2 * steepest as usize).map(|k| {
        let degrees = 0.5 * k as f64;
        (degrees, Case { degrees, ..*first }.expected())
    });
    let mut chart = Curves::new(
        &format!("{space}, {rate} steps a second, from rest"),
        "slope (°)",
        "speed after 2 s (m/s)",
    )
    .line("Coulomb", law);
    for (mode, (name, ..)) in MODES.iter().enumerate() {
        let of = shown.iter().filter(|(case, _)| case.mode == mode);
        chart = chart.dots(name, of.map(|(case, slide)| (case.degrees, slide.speed)));
    }
    Some(chart)
}

/// The block with every node of its layer solved for, and with 12 handles, each with its name.
fn spaces() -> Result<[(String, Arc<Avatar>); 2]> {
    let recipe = Recipe {
        handles: vec![HandleRegion {
            count: Some(12),
            ..HandleRegion::default()
        }],
        damping_time: Some(0.01),
        ..limb_recipe()
    };
    let reduced = bake(&BLOCK.body()?, &recipe, &mut |_| {})?.0;
    let full = full_space(&reduced)?;
    Ok([
        ("full space".into(), Arc::new(full)),
        ("12 handles".into(), Arc::new(reduced)),
    ])
}

fn cases(runner: &Runner) -> Vec<Case> {
    let slopes: &[f64] = runner.pick(&[20.0, 45.0], &[20.0, 25.0, 30.0, 35.0, 45.0, 60.0]);
    let rates: &[f64] = runner.pick(&RATES[..1], &RATES);
    let mut cases = Vec::new();
    for space in 0..2 {
        for mode in 0..MODES.len() {
            // The converged runs of a test would take most of its time.
            if runner.small() && mode == 2 {
                continue;
            }
            for &rate in rates {
                for &degrees in slopes {
                    for speed in [0.0, 0.3] {
                        cases.push(Case {
                            space,
                            mode,
                            rate,
                            degrees,
                            speed,
                        });
                    }
                }
            }
        }
    }
    cases
}

fn slide(avatar: &Arc<Avatar>, case: Case) -> Result<Slide> {
    let (_, integrator, solver) = MODES[case.mode];
    let settings = Settings {
        time_step: 1.0 / case.rate,
        integrator,
        solver,
        ..Settings::default()
    };
    let potential = CpuPotential::new(avatar.clone(), 1)?;
    let sparse = Box::new(SparseCholesky::new(potential.pattern())?);
    // It lies down first.
    let still = Settings {
        integrator: Integrator::BackwardEuler,
        solver: CONVERGED,
        ..settings
    };
    let mut simulation = Simulation::with_solver(avatar, potential, still, sparse)?;
    let instance = &mut simulation.instances_mut()[0];
    instance.gravity = -GRAVITY * DVec3::Z;
    let heights = avatar.skin.position.iter().map(|p| p.z);
    let ground = Frame {
        position: heights.fold(0.0, f64::min) * DVec3::Z,
        ..Frame::IDENTITY
    };
    instance.colliders.push(Collider {
        friction: FRICTION,
        ..Collider::new(Shape::HalfSpace, ground)
    });
    for _ in 0..100 {
        simulation.step_blocking()?;
    }
    simulation.set_settings(settings)?;
    let instance = &mut simulation.instances_mut()[0];
    let state = instance.state.clone();
    instance.set_state(state);
    if case.speed > 0.0 {
        let at = instance.state.frames[0];
        instance.set_motion(0, at, case.speed * DVec3::X, DVec3::ZERO);
    }
    let (sine, cosine) = case.degrees.to_radians().sin_cos();
    instance.gravity = GRAVITY * DVec3::new(sine, 0.0, -cosine);
    let steps = (DURATION * case.rate) as usize;
    let (mut iterations, mut moved) = (0, 0.0);
    for _ in 0..steps {
        let before = simulation.instances()[0].state.frames[0].position.x;
        iterations += simulation.step_blocking()?.instances[0].iterations;
        moved = simulation.instances()[0].state.frames[0].position.x - before;
    }
    Ok(Slide {
        speed: moved * case.rate,
        iterations: iterations as f64 / steps as f64,
    })
}
