//! Two bodies of different shape that hang limply and are pushed.

use super::measure::longest;
use super::{Bound, Figure, Page, Runner};
use glam::DVec3;
use std::sync::Arc;
use supple::Result;
use supple::internal::cpu::mechanics;
use supple::model::{Avatar, State};
use supple_pictures::Curves;
use supple_scene::{Scene, SceneRun};

/// See [`draw`].
pub const FIGURE: Figure = Figure {
    name: "ragdolls",
    title: "Ragdolls pushed by a bar",
    paper: "figure 12",
    draw,
};

/// A body and what the bar does to it.
struct Ragdoll {
    name: &'static str,
    avatar: Arc<Avatar>,
    run: SceneRun,
    /// How far the pelvis is from where it started, along the bar's way, over the time, s and mm.
    swing: Vec<(f64, f64)>,
    /// Kinetic energy and that under gravity, over the time, s and J.
    energy: Vec<(f64, f64)>,
}

/// A body of the default shape and a stout one hang by their wrists; a bar pushes both alike and leaves. Joints and their
/// limits hold them together, their shapes make them swing differently, and nothing makes energy.
fn draw(runner: &Runner) -> Result<Page> {
    let mut scene = runner.scene("ragdolls")?;
    let mut page = Page::new(
        "Two bodies of different shape hang by their wrists, limp but for a little bending stiffness and the ranges of \
         their joints. A bar pushes both alike and is withdrawn.",
    );
    let stout = scene.avatar.clone();
    let mut default = stout.clone();
    default.set_shape(&[])?;
    let mut dolls = Vec::new();
    // The default body's pelvis hangs at the height of the stout one's.
    let place = scene.placement.position;
    let higher = DVec3::new(0.0, -0.002, 0.06);
    for (name, avatar, place) in [("default", default, higher), ("stout", stout, place)] {
        scene.avatar = avatar;
        scene.placement.position = place;
        dolls.push(play(runner, &scene, name)?);
    }
    // One scale for both.
    let snapshots = dolls.iter().flat_map(|d| &d.run.snapshots);
    let largest = longest(snapshots.flat_map(|s| s.displacement.iter().copied()));
    scene.output.legend_mm = Some(1e3 * largest);
    for doll in &dolls {
        let strip = runner.strip(&scene, &doll.avatar, &doll.run);
        page.picture(doll.name, strip, format!("the {} body", doll.name));
    }
    let mut swings = Curves::new("Pelvis, away from the bar", "time (s)", "way (mm)");
    let title = "Kinetic and gravitational energy since the start";
    let mut energies = Curves::new(title, "time (s)", "energy (J)");
    for doll in &dolls {
        swings = swings.line(doll.name, doll.swing.iter().copied());
        let start = doll.energy[0].1;
        energies = energies.line(doll.name, doll.energy.iter().map(|(t, e)| (*t, e - start)));
    }
    page.curves(swings);
    page.curves(energies);
    check(&scene, &dolls, &mut page);
    Ok(page)
}

/// Plays the scene with the body that it has now.
fn play(runner: &Runner, scene: &Scene, name: &'static str) -> Result<Ragdoll> {
    let avatar = runner.avatar_of(scene)?;
    let run = runner.play(scene, &avatar)?;
    let (times, states) = (&run.recording.times, &run.recording.states);
    let pelvis = |s: &State| 1e3 * (s.frames[0].position - states[0].frames[0].position).y;
    let swing = times.iter().zip(states).map(|(t, s)| (*t, pelvis(s)));
    let step = scene.settings.time_step;
    let energy = states.windows(2).zip(&times[1..]).map(|(s, t)| {
        let now = mechanics(&avatar, &s[0], &s[1], step, scene.gravity());
        (*t, now.energy())
    });
    Ok(Ragdoll {
        name,
        swing: swing.collect(),
        energy: energy.collect(),
        avatar,
        run,
    })
}

fn check(scene: &Scene, dolls: &[Ragdoll], page: &mut Page) {
    let bar = &scene.colliders[0].motion.y;
    let (touch, leave) = (bar[0][0], bar[bar.len() - 1][0]);
    for Ragdoll {
        name, run, energy, ..
    } in dolls
    {
        // What the bar has done by the time it has gone is all there is.
        let after: Vec<f64> = energy.iter().filter(|e| e.0 > leave).map(|e| e.1).collect();
        let least = energy.iter().fold(f64::INFINITY, |m, e| m.min(e.1));
        let most = energy.iter().fold(f64::NEG_INFINITY, |m, e| m.max(e.1));
        let rise = after.iter().fold(0.0, |a: f64, e| a.max(e - after[0]));
        page.check(
            format!("energy that the {name} body gains when the bar has gone, of its range"),
            rise / (most - least),
            "",
            Bound::AtMost(0.02),
        );
        page.check_intact(&format!(" of the {name} body"), &run.report);
    }
    let pushed = |doll: &Ragdoll| -> Vec<f64> {
        let swing = doll.swing.iter().filter(|s| s.0 > touch);
        swing.map(|s| s.1).collect()
    };
    let [default, stout] = [&dolls[0], &dolls[1]].map(pushed);
    let far = |swing: &[f64]| swing.iter().fold(0.0, |a: f64, s| a.max(s.abs()));
    let apart = default.iter().zip(&stout).map(|(a, b)| (a - b).abs());
    page.check(
        "the pelvis is pushed by",
        far(&default).min(far(&stout)),
        "mm",
        Bound::AtLeast(50.0),
    );
    page.check(
        "the two swings differ by",
        apart.fold(0.0, f64::max),
        "mm",
        Bound::AtLeast(5.0),
    );
}
