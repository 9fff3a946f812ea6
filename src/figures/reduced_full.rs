//! The reduced model beside the full space.

use super::press::relative_error;
use super::{Bound, Curves, Figure, Page, Studio};
use crate::Result;
use crate::bake::{HandleRegion, Truncation};
use crate::export::picture_strip;
use crate::load::Scene;
use crate::sim::SolverMode;

/// See [`draw`].
pub const FIGURE: Figure = Figure {
    name: "reduced_full",
    title: "Reduced model against full space",
    paper: "figure 13",
    draw,
};

/// A press and how it is played.
struct Press {
    scene: &'static str,
    /// Long steps: each ends near equilibrium, s.
    time_step: f64,
    /// Handles, rising.
    counts: &'static [usize],
}

const SMALL: &[Press] = &[Press {
    scene: "finger_press",
    time_step: 0.1,
    counts: &[12, 30, 75],
}];
const FULL: &[Press] = &[
    Press {
        scene: "hand_press",
        time_step: 0.2,
        counts: &[40, 87, 200],
    },
    Press {
        scene: "chest_press",
        time_step: 0.2,
        counts: &[40, 82, 200],
    },
];

/// The same press in the full space and in three reduced ones.
fn draw(studio: &Studio) -> Result<Page> {
    let mut page = Page::new(
        "The same press with every node of the soft layer free, and with ever fewer handles. All are solved to \
         convergence in long steps, so that what differs is the space alone. Error is that of the skin's unposed \
         displacement at full press, relative, L2. The basis is not truncated, but for one line.",
    );
    for press in studio.pick(SMALL, FULL) {
        compare(studio, press, &mut page)?;
    }
    Ok(page)
}

fn compare(studio: &Studio, press: &Press, page: &mut Page) -> Result<()> {
    let mut scene = studio.scene(press.scene)?;
    scene.settings.time_step = press.time_step;
    scene.settings.solver = SolverMode::Converged {
        tolerance: 1e-6,
        max_iterations: 60,
    };
    let time = scene.measure.full_press;
    scene.steps = scene.step_at(time);
    scene.output.panels.retain(|panel| panel.time == time);
    scene.output.panels.truncate(1);
    let own = studio.avatar_of(&scene)?;
    let (full_avatar, full) = studio.play_full_space(&scene, &own)?;
    let truth = &full.snapshots[0].displacement;
    let longest = truth.iter().map(|d| d.length()).fold(0.0, f64::max);
    scene.output.legend_mm = Some(1e3 * longest);

    let largest = press.counts[press.counts.len() - 1];
    let whole = press.counts.iter().map(|&count| (count, Truncation::OFF));
    let (mut rows, mut errors, mut shots) = (Vec::new(), Vec::new(), Vec::new());
    for (count, truncation) in whole.chain([(largest, Truncation::default())]) {
        let reduced = with_handles(&scene, count, truncation)?;
        let avatar = studio.avatar_of(&reduced)?;
        let run = studio.play(&reduced, &avatar)?;
        let mut shot = run.snapshots[0].clone();
        let error = relative_error(&shot.displacement, truth);
        let kept = match truncation.enabled {
            true => ", truncated",
            false => "",
        };
        rows.push(vec![
            format!("{count}{kept}"),
            format!("{:.1} %", 100.0 * error),
            format!("{:.2}", run.report.full_press_displacement_mm),
            format!("{:.2}", run.report.contact_force_n),
            format!("{:.3}", run.report.min_det_f),
        ]);
        if !truncation.enabled {
            errors.push((count as f64, 100.0 * error));
            shot.panel.caption = format!("{count} handles");
            shots.push(shot);
        }
    }
    let report = &full.report;
    rows.push(vec![
        format!("full space: {}", report.handles),
        "0 %".into(),
        format!("{:.2}", report.full_press_displacement_mm),
        format!("{:.2}", report.contact_force_n),
        format!("{:.3}", report.min_det_f),
    ]);
    let mut shot = full.snapshots[0].clone();
    shot.panel.caption = "full space".into();
    shots.push(shot);
    let name = press.scene;
    page.picture(
        name,
        picture_strip(&scene, &full_avatar, &shots),
        format!("{name}: skin coloured by its unposed displacement, one scale for all"),
    );
    page.table(
        &format!("{name} at full press"),
        &[
            "handles",
            "error",
            "displacement (mm)",
            "force (N)",
            "smallest det F",
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
    page.curves(Curves::new(name, "handles", "error (%)").dots("whole basis", errors));
    Ok(())
}

/// `scene` with an avatar of so many handles, where its own recipe has its first ones.
fn with_handles(scene: &Scene, count: usize, truncation: Truncation) -> Result<Scene> {
    let mut scene = scene.clone();
    let (_, mut recipe) = scene.avatar.body()?;
    let region = recipe.handles.first().cloned().unwrap_or_default();
    recipe.handles = vec![HandleRegion {
        count: Some(count),
        spacing: None,
        ..region
    }];
    recipe.truncation = truncation;
    scene.avatar.bake = Some(recipe);
    Ok(scene)
}
