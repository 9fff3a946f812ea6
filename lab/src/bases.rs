//! The handle basis against the modal basis and against no tissue.

use super::skins::{COLLIDER, Look, Prop, Skin, skin_strip};
use super::{Bound, Figure, Page, Runner};
use glam::DVec3;
use std::sync::Arc;
use supple::collider::{Collider, Shape};
use supple::internal::cpu::{min_det_f, skin_displacement};
use supple::internal::math::Stopwatch;
use supple::model::{Avatar, Integrator, State};
use supple::potential::{CpuPotential, Potential};
use supple::sim::{Settings, Simulation, SolverMode};
use supple::{Error, Result};
use supple_bake::math::NearestPoint;
use supple_bake::subspace::{Subspace, modal};
use supple_bake::without_tissue;
use supple_pictures::{ColourScale, Curves};
use supple_scene::{Driver, Scene, SceneCollider};

/// See [`draw_hand`].
pub const HAND: Figure = Figure {
    name: "bases_hand",
    title: "Handles against modes: a hand on a cylinder",
    paper: "figure 14",
    draw: draw_hand,
};

/// See [`draw_chest`].
pub const CHEST: Figure = Figure {
    name: "bases_chest",
    title: "Handles against modes: a sphere on the chest",
    paper: "figure 15",
    draw: draw_chest,
};

/// A press and what it is compared in.
struct Study {
    scene: Scene,
    /// When the press is deep and deeper, s: equilibria on the way.
    times: Vec<f64>,
    /// Numbers of cubature points of the modal basis; the first is the handle basis's too.
    points: Vec<usize>,
    /// Farther from the touched skin than this, nothing should move, m.
    far: f64,
    look: Look,
    /// What the press is looked at more closely with.
    focus: Option<(DVec3, f64)>,
}

fn draw_hand(runner: &Runner) -> Result<Page> {
    let scene = runner.scene(runner.pick("finger_press", "hand_press"))?;
    let study = Study {
        times: runner.pick(vec![0.3, 0.7, 1.0], vec![0.5, 0.9, 1.1, 1.3, 1.5]),
        points: runner.pick(vec![300, 600], vec![700, 2000]),
        far: runner.pick(0.04, 0.06),
        look: Look {
            direction: runner.pick(scene.output.view, DVec3::new(0.25, 0.1, 1.0)),
            up: DVec3::Z,
            focus: None,
            size: [420, 400],
            columns: 2,
            draft: runner.small(),
        },
        focus: None,
        scene,
    };
    compare(runner, &study)
}

fn draw_chest(runner: &Runner) -> Result<Page> {
    let mut scene = runner.scene(runner.pick("finger_press", "chest_press"))?;
    if runner.small() {
        // A ball in the cylinder's place: on the limb 40 handles reach everywhere.
        (scene.colliders.iter_mut()).for_each(|c| c.shape = Shape::Sphere { radius: 0.006 }.into());
    }
    let study = Study {
        times: runner.pick(vec![0.3, 0.7, 1.0], vec![0.2, 0.6, 0.9, 1.2]),
        points: runner.pick(vec![300], vec![500, 1400]),
        far: runner.pick(0.04, 0.4),
        look: Look {
            direction: scene.output.view,
            up: DVec3::Z,
            focus: None,
            size: runner.pick([420, 300], [560, 420]),
            columns: 2,
            draft: runner.small(),
        },
        // The chest of the body as the scene places it.
        focus: runner.pick(None, Some((DVec3::new(0.02, 0.0, 1.22), 0.3))),
        scene,
    };
    compare(runner, &study)
}

/// A press in one space.
struct Outcome {
    name: String,
    skin: Vec<DVec3>,
    /// Unposed, of each vertex, m.
    displacement: Vec<f64>,
    /// Of steps with one Newton iteration.
    frames_a_second: f64,
    min_det_f: f64,
}

fn compare(runner: &Runner, study: &Study) -> Result<Page> {
    let mut page = Page::new(
        "The same press in equilibrium: on the skeleton alone, with the handle basis, and with as many degrees of \
         freedom of the modal basis (linear modal analysis with fixed bones). Handles move the skin around them; \
         modes move all of it, so that what bulges at the contact moves places that nothing touches.",
    );
    let avatar = with_points(runner, &study.scene, study.points[0])?;
    let rigid = Arc::new(without_tissue(&avatar));
    let no_tissue = play(runner, study, "no tissue", Space::Own(&rigid))?;
    let name = format!(
        "{} handles, {} points",
        avatar.handles.len(),
        avatar.cubature.len()
    );
    let handles = play(runner, study, &name, Space::Own(&avatar))?;
    let count = 3 * avatar.handles.len();
    let watch = Stopwatch::start();
    let modes = modal(&avatar, count)?;
    page.text(format!(
        "{count} modes of {:.1} to {:.1} Hz, found in {:.0} s.",
        modes.frequencies[0],
        modes.frequencies[count - 1],
        1e-3 * watch.ms()
    ));
    let mut outcomes = vec![no_tissue, handles];
    for &points in &study.points {
        let avatar = with_points(runner, &study.scene, points)?;
        let (places, nodes) = (
            modes.space.avatar().handles.clone(),
            modes.space.nodes().clone(),
        );
        let space = Subspace::new(&avatar, places, nodes)?;
        let name = format!("{count} modes, {} points", avatar.cubature.len());
        outcomes.push(play(runner, study, &name, Space::Modal(&space))?);
    }
    report(study, &avatar, &outcomes, page)
}

/// The scene's avatar with so many cubature points.
fn with_points(runner: &Runner, scene: &Scene, points: usize) -> Result<Arc<Avatar>> {
    let mut scene = scene.clone();
    let (_, mut recipe) = scene.avatar.body()?;
    recipe.cubature.points = Some(points);
    scene.avatar = scene.avatar.baked_by(recipe)?;
    runner.avatar_of(&scene)
}

/// What a press is played in.
enum Space<'a> {
    /// An avatar's own basis.
    Own(&'a Arc<Avatar>),
    Modal(&'a Subspace),
}

/// Presses in one space, and times steps there.
fn play(runner: &Runner, study: &Study, name: &str, space: Space<'_>) -> Result<Outcome> {
    runner.progress(&format!("{}, {name}", study.scene.name), 0, 1);
    let (settled, displacement, min_det_f) = match space {
        Space::Own(avatar) => {
            let potential = || CpuPotential::new(avatar.clone(), 1);
            let settled = settle(study, avatar, potential)?;
            let least = min_det_f(avatar, &settled.state);
            let displacement = skin_displacement(avatar, &settled.state);
            (settled, displacement, least)
        }
        Space::Modal(space) => {
            let avatar = space.avatar();
            let potential = || space.reference(1);
            let settled = settle(study, avatar, potential)?;
            let least = space.min_det_f(&settled.state)?;
            let displacement = space.skin_displacement(&settled.state)?;
            (settled, displacement, least)
        }
    };
    runner.progress(&format!("{}, {name}", study.scene.name), 1, 1);
    Ok(Outcome {
        name: name.into(),
        skin: settled.skin,
        displacement: displacement.iter().map(|d| d.length()).collect(),
        frames_a_second: settled.frames_a_second,
        min_det_f,
    })
}

/// An equilibrium.
struct Settled {
    state: State,
    /// Drawn, m.
    skin: Vec<DVec3>,
    frames_a_second: f64,
}

/// The scene's equilibrium at the last of its times, its drawn skin, and the frames a second that steps of one
/// iteration go on with there.
fn settle<P: Potential>(
    study: &Study,
    avatar: &Avatar,
    potential: impl Fn() -> Result<P>,
) -> Result<Settled> {
    const STEPS: usize = 3;
    let scene = &study.scene;
    let still = Settings {
        // One step, so long that inertia is nothing.
        time_step: 100.0,
        integrator: Integrator::BackwardEuler,
        solver: SolverMode::Converged {
            tolerance: 1e-6,
            max_iterations: 60,
        },
        ..scene.settings
    };
    let mut simulation = Simulation::new(avatar, potential()?, still)?;
    let mut driver = Driver::new(scene, avatar)?;
    driver.start(avatar, &mut simulation.instances_mut()[0]);
    driver.launch(avatar, &mut simulation.instances_mut()[0]);
    for &time in &study.times {
        let instance = &mut simulation.instances_mut()[0];
        driver.drive(time, instance)?;
        instance.history.rest(&instance.state);
        simulation.step_blocking()?;
    }
    let (mut skin, mut normals) = (Vec::new(), Vec::new());
    simulation.read_skin_blocking(0, &mut skin, &mut normals)?;
    let settled = simulation.instances()[0].clone();
    drop(simulation);
    let settings = Settings {
        integrator: Integrator::BackwardEuler,
        solver: SolverMode::OneIteration,
        ..scene.settings
    };
    let mut simulation = Simulation::new(avatar, potential()?, settings)?;
    let instance = &mut simulation.instances_mut()[0];
    *instance = settled.clone();
    instance.history.rest(&instance.state);
    let mut times = Vec::new();
    for _ in 0..STEPS {
        times.push(simulation.step_blocking()?.timings.step);
    }
    times.sort_by(f64::total_cmp);
    Ok(Settled {
        state: settled.state,
        skin,
        frames_a_second: 1e3 / times[STEPS / 2],
    })
}

/// Table, curves, pictures and checks.
fn report(study: &Study, avatar: &Avatar, outcomes: &[Outcome], mut page: Page) -> Result<Page> {
    let distance = distances(study, avatar, &outcomes[1])?;
    let largest = |o: &Outcome, far: bool| {
        let of = o.displacement.iter().zip(&distance);
        let of = of.filter(|(_, d)| !far || **d > study.far);
        1e3 * of.fold(0.0f64, |m, (u, _)| m.max(*u))
    };
    let row = |o: &Outcome| {
        vec![
            o.name.clone(),
            format!("{:.2}", largest(o, false)),
            format!("{:.4}", largest(o, true)),
            format!(
                "{:.1}",
                100.0 * largest(o, true) / largest(o, false).max(1e-9)
            ),
            format!("{:.3}", o.min_det_f),
            format!("{:.1}", o.frames_a_second),
        ]
    };
    page.table(
        &format!(
            "Unposed displacement of the skin, everywhere and farther than {:.0} cm from what is touched; steps of \
             one Newton iteration in f64 on the CPU",
            100.0 * study.far
        ),
        &["basis", "largest (mm)", "far (mm)", "far (%)", "min det F", "frames a second"],
        outcomes.iter().map(row).collect(),
    );
    page.curves(curves(&outcomes[1..], &distance));
    let (handles, modes) = (&outcomes[1], &outcomes[2..]);
    page.check(
        "far displacement with handles, by their largest",
        100.0 * largest(handles, true) / largest(handles, false),
        "%",
        Bound::AtMost(1.0),
    );
    for modes in modes {
        page.check(
            format!("far displacement with {}, by that with handles", modes.name),
            largest(modes, true) / largest(handles, true).max(1e-6),
            "",
            Bound::AtLeast(5.0),
        );
        page.check(
            format!("frames a second with handles by those with {}", modes.name),
            handles.frames_a_second / modes.frames_a_second,
            "",
            Bound::AtLeast(2.0),
        );
    }
    page.check(
        "smallest det F over all tets, handles",
        handles.min_det_f,
        "",
        Bound::AtLeast(0.0),
    );
    pictures(study, avatar, outcomes, &mut page);
    Ok(page)
}

/// Distance in the reference shape of each vertex from those that the collider touches, m.
fn distances(study: &Study, avatar: &Avatar, handles: &Outcome) -> Result<Vec<f64>> {
    /// Nearer to the collider than this is touched, m.
    const TOUCHED: f64 = 1e-4;
    let colliders = colliders(study);
    let touches = |x: DVec3| {
        let mut depths = colliders.iter().map(|p| {
            Collider::new(p.shape.clone(), p.frame)
                .signed_distance(&p.frame, x)
                .distance
        });
        depths.any(|d| d < TOUCHED)
    };
    let rest = &avatar.skin.position;
    let touched: Vec<DVec3> = (rest.iter().zip(&handles.skin))
        .filter(|(_, x)| touches(**x))
        .map(|(rest, _)| *rest)
        .collect();
    if touched.is_empty() {
        return Err(Error::invalid(
            study.scene.name.clone(),
            "nothing is touched at the last time",
        ));
    }
    let search = NearestPoint::new(&touched);
    Ok(rest.iter().map(|x| search.distance(*x)).collect())
}

/// The scene's colliders at the last time.
fn colliders(study: &Study) -> Vec<Prop> {
    let time = study.times[study.times.len() - 1];
    let at = |c: &SceneCollider| Prop {
        shape: (*c.shape).clone(),
        frame: c.motion.at(time),
        colour: COLLIDER,
    };
    study.scene.colliders.iter().map(at).collect()
}

/// The largest displacement in bins of the distance.
fn curves(outcomes: &[Outcome], distance: &[f64]) -> Curves {
    const BINS: usize = 24;
    let farthest = distance.iter().copied().fold(0.0, f64::max);
    let mut curves = Curves::new(
        "Where the skin moves",
        "distance from the touched skin (cm)",
        "largest unposed displacement (mm)",
    )
    .logarithmic();
    for outcome in outcomes {
        let mut largest = [0.0f64; BINS];
        for (u, d) in outcome.displacement.iter().zip(distance) {
            let bin = ((d / farthest * BINS as f64) as usize).min(BINS - 1);
            // The axis ends at a thousandth of a millimetre.
            largest[bin] = largest[bin].max(1e3 * u).max(1e-3);
        }
        let centre = |k: usize| 100.0 * farthest * (k as f64 + 0.5) / BINS as f64;
        let points = largest.iter().enumerate().filter(|(_, u)| **u > 0.0);
        curves = curves.line(&outcome.name, points.map(|(k, u)| (centre(k), *u)));
    }
    curves
}

fn pictures(study: &Study, avatar: &Avatar, outcomes: &[Outcome], page: &mut Page) {
    let skin = |o: &Outcome| Skin {
        caption: o.name.clone(),
        positions: o.skin.clone(),
        values: o.displacement.iter().map(|u| 1e3 * u).collect(),
        props: Vec::new(),
    };
    let mut skins: Vec<Skin> = outcomes.iter().map(skin).collect();
    let largest = ColourScale::of(skins[1].values.iter().copied());
    skins.iter_mut().for_each(|s| s.props = colliders(study));
    let title = "unposed displacement (mm)";
    let close = Look {
        focus: study.focus,
        ..study.look
    };
    let image = skin_strip(avatar, &skins, close, title, largest);
    page.picture("presses", image, "the press in each space");
    // What is far away is a tenth of it at most.
    let scale = ColourScale::up_to(0.1 * largest.high);
    skins.iter_mut().for_each(|s| s.props.clear());
    let image = skin_strip(avatar, &skins, study.look, title, scale);
    page.picture(
        "far",
        image,
        "the same with a scale of a tenth, colliders not drawn",
    );
}
