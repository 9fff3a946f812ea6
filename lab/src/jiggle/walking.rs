//! The sample body walks: how far its tissue moves at each rate.

use super::{Bound, RATES, REFERENCE, frames};
use crate::measure::upper_quantile;
use crate::{Page, Runner};
use supple::Result;
use supple::internal::cpu::skin_displacement;
use supple::internal::math::par_map;
use supple_pictures::Curves;

/// Plays the committed walk at each rate; in a test for less long, and beside its fastest rate alone.
pub(super) fn draw(runner: &Runner, page: &mut Page) -> Result<()> {
    let mut scene = runner.scene("body_walk")?;
    scene.output.panels.clear();
    let duration = runner.pick(1.2, 3.0);
    let rates = runner.pick(&RATES[1..REFERENCE], &RATES[..]);
    let avatar = runner.avatar_of(&scene)?;
    let runs = par_map(rates.len(), |k| {
        let mut scene = scene.clone();
        scene.settings.time_step = 1.0 / rates[k];
        scene.steps = (duration * rates[k]).round() as usize;
        scene.measure.full_press = duration;
        runner.play(&scene, &avatar)
    });
    let runs = runs.into_iter().collect::<Result<Vec<_>>>()?;
    // Where the tissue moves most, in the slowest of the steps: a fiftieth of the skin, after the start.
    let eased = scene.motion.as_ref().map_or(0.0, |m| m.ease_in);
    let curves: Vec<Vec<(f64, f64)>> = (runs.iter())
        .map(|run| {
            let states = &run.recording.states;
            let moved = par_map(states.len(), |k| {
                let lengths: Vec<f64> = skin_displacement(&avatar, &states[k])
                    .iter()
                    .map(|d| 1e3 * d.length())
                    .collect();
                upper_quantile(&lengths, &avatar.skin.measure, 0.02)
            });
            let times = run.recording.times.iter().copied();
            times.zip(moved).filter(|(t, _)| *t >= eased).collect()
        })
        .collect();
    let largest = |curve: &[(f64, f64)]| curve.iter().map(|p| p.1).fold(0.0, f64::max);
    let truth = largest(&curves[rates.len() - 1]);
    page.text(
        "The walk's clip has 30 poses a second with straight lines between them: its corners are blows that short frames \
         resolve and long ones do not, so that the tissue of a walk moves more the shorter the frames are. What that makes is \
         measured here, and no bound is claimed.",
    );
    let mut chart = Curves::new(
        "The sample body walks",
        "time (s)",
        "displacement that a fiftieth of the skin exceeds (mm)",
    );
    let mut rows = Vec::new();
    for ((rate, curve), run) in rates.iter().zip(&curves).zip(&runs) {
        let name = frames(*rate);
        let most = largest(curve);
        rows.push(vec![
            name.clone(),
            format!("{most:.2}"),
            format!("{:.2}", most / truth),
            format!("{:.2}", run.report.iterations),
            format!("{:.3}", run.report.det_f()),
        ]);
        // Of the tissue alone: what joints do at the heel's strike is not this figure's.
        page.check(
            format!("smallest det F, walk, {name}"),
            run.report.det_f(),
            "",
            Bound::AtLeast(0.05),
        );
        chart = chart.line(&name, curve.iter().copied());
    }
    page.curves(chart);
    page.table(
        "The walk: the largest displacement that a fiftieth of the skin exceeds.",
        &[
            "frames",
            "largest (mm)",
            "over the last line",
            "iterations",
            "smallest det F",
        ],
        rows,
    );
    Ok(())
}
