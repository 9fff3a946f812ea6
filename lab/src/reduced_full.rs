//! The reduced model beside the full space.

use super::measure::volume_ratios;
use super::press::relative_error;
use super::{Bound, Figure, Page, Runner};
use glam::DVec3;
use std::sync::Arc;
use supple::Result;
use supple::collider::Shape;
use supple::model::{Avatar, Integrator};
use supple::sim::SolverMode;
use supple_bake::{CubatureRecipe, HandleCandidates, HandleRegion, Truncation, all_tets};
use supple_pictures::{Curves, picture_strip};
use supple_scene::{Focus, Scene, SceneRun};

/// See [`draw`].
pub const FIGURE: Figure = Figure {
    name: "reduced_full",
    title: "Reduced model against full space",
    paper: "figure 13",
    draw,
};

/// A press, and the handles that it is played with.
struct Press {
    scene: &'static str,
    /// What is played otherwise than in the scene.
    otherwise: fn(&mut Scene),
    /// Long steps: each ends near equilibrium, s.
    time_step: f64,
    /// The tissue about the contact: lowest and highest corner in the reference shape, m.
    about: [[f64; 3]; 2],
    /// Handles there, on the skin and under it, rising.
    counts: &'static [usize],
    /// Handles on the skin everywhere else.
    elsewhere: usize,
    /// How the contact is seen through the collider, which is not drawn.
    view: DVec3,
    focus: Focus,
}

const SMALL: &[Press] = &[Press {
    scene: "finger_press",
    otherwise: |_| {},
    time_step: 0.1,
    about: [[0.060, -0.012, -0.025], [0.092, 0.012, -0.004]],
    counts: &[15, 45, 135],
    elsewhere: 20,
    view: DVec3::new(0.3, 0.7, 1.0),
    focus: Focus {
        point: DVec3::new(0.076, 0.0, -0.012),
        radius: 0.03,
    },
}];
const FULL: &[Press] = &[
    Press {
        scene: "hand_press",
        otherwise: widen,
        time_step: 0.2,
        about: [[0.092, -0.07, -0.05], [0.132, 0.05, -0.006]],
        counts: &[80, 160, 320],
        elsewhere: 30,
        view: DVec3::new(0.25, 0.1, 1.0),
        focus: Focus {
            point: DVec3::new(0.1, -0.005, -0.03),
            radius: 0.08,
        },
    },
    Press {
        scene: "chest_press",
        otherwise: |_| {},
        time_step: 0.2,
        about: [[-0.04, 1.15, 0.0], [0.19, 1.38, 0.2]],
        counts: &[20, 40, 80],
        elsewhere: 40,
        view: DVec3::new(-0.3, 1.0, -0.1),
        focus: Focus {
            point: DVec3::new(0.03, -0.1, 1.22),
            radius: 0.26,
        },
    },
];

/// A cylinder of twice the scene's radius that begins to touch where the scene's does: the dent is then wider than the
/// cells of the hand's lattice.
fn widen(scene: &mut Scene) {
    const WIDER: f64 = 0.008;
    for collider in &mut scene.colliders {
        if let Shape::Cylinder {
            radius,
            half_length,
        } = *collider.shape
        {
            collider.shape = Shape::Cylinder {
                radius: radius + WIDER,
                half_length,
            }
            .into();
            (collider.motion.z.iter_mut()).for_each(|key| key[1] -= WIDER);
        }
        // The default.
        collider.stiffness = Some(1e8);
    }
}

/// Little is cut off: the default costs accuracy where handles are dense.
const LITTLE: Truncation = Truncation {
    enabled: true,
    below: 0.005,
    above: 0.02,
    ..Truncation::OFF
};

/// What a user would take for the full space, %.
const ACCEPTED: f64 = 25.0;

/// The same press in the full space and in three reduced ones.
fn draw(runner: &Runner) -> Result<Page> {
    let mut page = Page::new(
        "The same press with every node of the soft layer free, and with ever fewer handles: in the tissue about the \
         contact, on the skin and under it, and a few on the skin everywhere else. A handle basis can only follow what is as \
         wide as its handles are apart. All are solved to convergence in long steps with every tet a cubature point, so that \
         what differs is the space alone. Error is that of the skin's unposed displacement at full press, relative, L2. The \
         basis is little truncated, but for one line; another has the recipe's ten points a handle. The hand's cylinder is \
         twice as wide as in its scene. Inverted is the part of the tissue's volume in tets that are turned inside out: with \
         every node free, splinters that the skin cuts off the hand's lattice may be, with next to no tissue in them.",
    );
    for press in runner.pick(SMALL, FULL) {
        compare(runner, press, &mut page)?;
    }
    Ok(page)
}

fn compare(runner: &Runner, press: &Press, page: &mut Page) -> Result<()> {
    let mut scene = runner.scene(press.scene)?;
    (press.otherwise)(&mut scene);
    scene.settings.time_step = press.time_step;
    scene.settings.integrator = Integrator::BackwardEuler;
    scene.settings.solver = SolverMode::Converged {
        tolerance: 1e-6,
        max_iterations: 60,
    };
    let time = scene.measure.full_press;
    scene.steps = scene.step_at(time);
    scene.output.panels.retain(|panel| panel.time == time);
    scene.output.panels.truncate(1);
    scene.output.panel_size = [420, 420];
    for panel in &mut scene.output.panels {
        (panel.view, panel.focus) = (Some(press.view), Some(press.focus));
        panel.colliders = false;
    }
    let own = runner.avatar_of(&scene)?;
    let (full_avatar, full) = runner.play_full_space(&scene, &own)?;
    let truth = &full.snapshots[0].displacement;
    let longest = truth.iter().map(|d| d.length()).fold(0.0, f64::max);
    scene.output.legend_mm = Some(1e3 * longest);

    let largest = press.counts[press.counts.len() - 1];
    let variants = (press.counts.iter())
        .map(|&count| (count, LITTLE, true, ""))
        .chain([
            (
                largest,
                Truncation::default(),
                true,
                ", truncated by default",
            ),
            (largest, LITTLE, false, ", ten points each"),
        ]);
    let (mut rows, mut errors, mut shots) = (Vec::new(), Vec::new(), Vec::new());
    let mut least = f64::INFINITY;
    for (count, truncation, every_tet, told) in variants {
        let reduced = with_handles(&scene, press, count, truncation)?;
        let mut avatar = runner.avatar_of(&reduced)?;
        if every_tet {
            // Not in the bake, whose file would be a hundred times as large.
            avatar = Arc::new(all_tets(&avatar)?);
        }
        let run = runner.play(&reduced, &avatar)?;
        let mut shot = run.snapshots[0].clone();
        let error = relative_error(&shot.displacement, truth);
        let name = format!("{count} + {}{told}", press.elsewhere);
        rows.push(row(name, 100.0 * error, &avatar, &run));
        if told.is_empty() {
            least = least.min(run.report.det_f());
            errors.push((count as f64, 100.0 * error));
            shot.panel.caption = format!("{count} handles: {:.0} % error", 100.0 * error);
            shots.push(shot);
        }
    }
    let name = format!("full space: {} nodes", full.report.handles);
    rows.push(row(name, 0.0, &full_avatar, &full));
    let mut shot = full.snapshots[0].clone();
    shot.panel.caption = "full space".into();
    shots.push(shot);
    let name = press.scene;
    page.picture(
        name,
        picture_strip(&scene, &full_avatar, &shots),
        format!(
            "{name}: skin coloured by its unposed displacement, one scale for all; what presses is not drawn"
        ),
    );
    page.table(
        &format!("{name} at full press"),
        &[
            "handles about the contact + elsewhere",
            "points",
            "error",
            "displacement (mm)",
            "force (N)",
            "smallest det F",
            "inverted (ppm)",
        ],
        rows,
    );
    for pair in errors.windows(2) {
        page.check(
            format!(
                "{name}: error with {} handles over that with {}",
                pair[1].0, pair[0].0
            ),
            pair[1].1 / pair[0].1,
            "",
            Bound::AtMost(0.98),
        );
    }
    if let Some((count, error)) = errors.last() {
        page.check(
            format!("{name}: error with {count} handles"),
            *error,
            "%",
            Bound::AtMost(ACCEPTED),
        );
    }
    page.check(
        format!("{name}: smallest det F with handles"),
        least,
        "",
        Bound::AtLeast(0.05),
    );
    let title = format!("{name}: error against the full space");
    let curves = Curves::new(&title, "handles about the contact", "error (%)");
    page.curves(curves.dots("error", errors));
    Ok(())
}

/// A row of the table: what `run` came to at its end.
fn row(name: String, error: f64, avatar: &Avatar, run: &SceneRun) -> Vec<String> {
    let report = &run.report;
    let points = &avatar.cubature;
    let inverted = run.recording.states.last().map_or(0.0, |state| {
        let tets = volume_ratios(avatar, state)
            .into_iter()
            .zip(&points.measure);
        let turned = tets.filter(|(ratio, _)| *ratio <= 0.0);
        let volume = turned.fold(0.0, |sum, (_, volume)| sum + volume);
        volume / points.measure.iter().sum::<f64>()
    });
    vec![
        name,
        points.len().to_string(),
        format!("{error:.1} %"),
        format!("{:.2}", report.full_press_displacement_mm),
        format!("{:.2}", report.contact_force_n),
        format!("{:.3}", report.det_f()),
        format!("{:.1}", 1e6 * inverted),
    ]
}

/// `scene` with an avatar of so many handles about the contact.
fn with_handles(
    scene: &Scene,
    press: &Press,
    count: usize,
    truncation: Truncation,
) -> Result<Scene> {
    let mut scene = scene.clone();
    let (_, mut recipe) = scene.avatar.body()?;
    recipe.handles = vec![
        HandleRegion {
            candidates: HandleCandidates::Volume,
            within: Some(press.about),
            count: Some(count),
            ..HandleRegion::default()
        },
        HandleRegion {
            count: Some(press.elsewhere),
            ..HandleRegion::default()
        },
    ];
    recipe.truncation = truncation;
    recipe.cubature = CubatureRecipe::default();
    scene.avatar = scene.avatar.baked_by(recipe)?;
    Ok(scene)
}
