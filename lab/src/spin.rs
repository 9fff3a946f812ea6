//! A body spun up and stopped about the vertical.

use super::measure::{depth, longest, upper_quantile, world_displacement};
use super::{Bound, Figure, Page, Runner};
use glam::DVec3;
use supple::Result;
use supple::internal::cpu::skin_displacement;
use supple::model::{Avatar, State};
use supple_pictures::Curves;

/// See [`draw`].
pub const FIGURE: Figure = Figure {
    name: "spin",
    title: "A body spun up and stopped",
    paper: "figure 7",
    draw,
};

/// Turns the body half around about the vertical. Its tissue lags while the turn becomes faster, leads while it
/// becomes slower, most of all where it is deep, and comes to rest after the stop.
fn draw(runner: &Runner) -> Result<Page> {
    let scene = runner.scene("body_spin")?;
    let avatar = runner.avatar_of(&scene)?;
    let run = runner.play(&scene, &avatar)?;
    let (times, states) = (&run.recording.times, &run.recording.states);
    let keys = &scene.pins[0].motion.rotation_degrees;
    let (start, stop) = (keys[0][0], keys[keys.len() - 1][0]);
    let half = 0.5 * (start + stop);
    let depth = depth(&avatar);
    let area = &avatar.skin.measure;
    let deep = upper_quantile(&depth, area, 0.25);

    let lag: Vec<(f64, f64)> = (times.iter().zip(states))
        .map(|(t, state)| (*t, 1e3 * tangential(&avatar, state, |v| depth[v] >= deep)))
        .collect();
    let displacements: Vec<Vec<DVec3>> = (states.iter())
        .map(|state| skin_displacement(&avatar, state))
        .collect();
    let largest: Vec<(f64, f64)> = (times.iter().zip(&displacements))
        .map(|(t, d)| (*t, 1e3 * longest(d.iter().copied())))
        .collect();
    let within = |from: f64, to: f64| {
        move |curve: &[(f64, f64)]| -> Vec<f64> {
            let inside = curve.iter().filter(|p| (from..=to).contains(&p.0));
            inside.map(|p| p.1).collect()
        }
    };
    let least = |values: Vec<f64>| values.into_iter().fold(f64::INFINITY, f64::min);
    let most = |values: Vec<f64>| values.into_iter().fold(f64::NEG_INFINITY, f64::max);

    let mut page = Page::new(format!(
        "The pelvis turns {:.0}° about the vertical within {:.1} s and stops. In the first half the turn becomes \
         faster and soft tissue stays behind (blue curve below 0); in the second half it becomes slower and the \
         tissue runs ahead. The colours show how far tissue moves from the skinned shape, insets the same on the \
         reference shape.",
        keys[keys.len() - 1][3],
        stop - start
    ));
    page.picture(
        "spin",
        runner.strip(&scene, &avatar, &run),
        "spun up, slowed down, and after the stop",
    );
    let turned: Vec<(f64, f64)> = times
        .iter()
        .map(|&t| {
            let h = 0.5 * scene.settings.time_step;
            let turn = |t: f64| scene.pins[0].motion.at(t);
            let (_, rotation) = turn(t - h).motion_to(&turn(t + h));
            (t, rotation.z / (2.0 * h))
        })
        .collect();
    page.curves(
        Curves::new("Angular velocity of the pelvis", "time (s)", "rad/s").line("pelvis", turned),
    );
    page.curves(
        Curves::new(
            "Soft tissue against the turn",
            "time (s)",
            "displacement (mm)",
        )
        .line("along the turn, mean of the deepest quarter", lag.clone())
        .line("largest", largest.clone()),
    );

    let peak = most(within(start, stop)(&largest));
    page.check(
        "lag while spun up",
        least(within(start, half)(&lag)),
        "mm",
        Bound::AtMost(-0.3),
    );
    page.check(
        "lead while slowed down",
        most(within(half, stop + 0.1)(&lag)),
        "mm",
        Bound::AtLeast(0.3),
    );
    page.check("largest displacement", peak, "mm", Bound::Within(1.0, 60.0));
    page.check(
        "among the skin that moved most (a fiftieth), the part over the deepest third of tissue",
        peak_is_deep(&avatar, &depth, &displacements),
        "",
        Bound::AtLeast(0.9),
    );
    let end = times[times.len() - 1];
    page.check(
        "left in the last 0.2 s, of the peak",
        most(within(end - 0.2, end)(&largest)) / peak,
        "",
        Bound::AtMost(runner.pick(0.2, 0.05)),
    );
    page.check_intact("", &run.report);
    Ok(page)
}

/// Mean displacement along the turn (about the vertical through the root) of the `chosen` skin, m.
fn tangential(avatar: &Avatar, state: &State, chosen: impl Fn(usize) -> bool) -> f64 {
    let axis = state.frames[0].position;
    let moved = world_displacement(avatar, state);
    let skin = supple::internal::cpu::posed_skin(avatar, state);
    let (mut sum, mut total) = (0.0, 0.0);
    for v in (0..moved.len()).filter(|&v| chosen(v)) {
        let along = DVec3::Z.cross(skin.positions[v] - axis).normalize_or_zero();
        sum += avatar.skin.measure[v] * along.dot(moved[v]);
        total += avatar.skin.measure[v];
    }
    sum / total
}

/// Of the fiftieth of the skin's area that moved farthest at any time: the part over the deepest third.
fn peak_is_deep(avatar: &Avatar, depth: &[f64], displacements: &[Vec<DVec3>]) -> f64 {
    let area = &avatar.skin.measure;
    let far: Vec<f64> = (0..area.len())
        .map(|v| longest(displacements.iter().map(|d| d[v])))
        .collect();
    let (far_enough, deep_enough) = (
        upper_quantile(&far, area, 0.02),
        upper_quantile(depth, area, 1.0 / 3.0),
    );
    let (mut deep, mut all) = (0.0, 0.0);
    for v in (0..area.len()).filter(|&v| far[v] >= far_enough) {
        all += area[v];
        deep += if depth[v] >= deep_enough {
            area[v]
        } else {
            0.0
        };
    }
    deep / all
}
