//! A hand that lifts a dynamic object.

use super::{Bound, Figure, Page, Runner};
use glam::DVec3;
use supple::Result;
use supple::model::{Avatar, State};
use supple_files::Recording;
use supple_pictures::Curves;

/// See [`draw`].
pub const FIGURE: Figure = Figure {
    name: "lift",
    title: "A hand lifts a tube",
    paper: "figure 11",
    draw,
};

/// For how long it is held, s.
const HELD: f64 = 2.0;

/// A friction that still has to hold.
const LESS: f64 = 0.7;

/// Where a tube that fell off the table is no longer drawn, mm.
const GONE: f64 = -100.0;

/// Fingers and thumb close around a tube from poses that come in as a stream, the hand lifts it, and friction holds it,
/// also where there is less of it; without friction it slips through.
fn draw(runner: &Runner) -> Result<Page> {
    let scene = runner.scene("lift")?;
    let friction = scene.bodies[0].friction;
    let mut page = Page::new(format!(
        "A hand closes around a dynamic tube and lifts it off the table, with one Newton iteration a step. The poses \
         arrive as a stream; the tube is a rigid body in the hand's own Newton system, so fingers and tube push each \
         other, and only friction carries its weight (μ = {friction}). It has some to spare, and without any the tube \
         is pushed over and off the table.",
    ));
    let mut chart = Curves::new("Height of the tube above where it stood", "time (s)", "mm");
    for (k, friction) in [friction, LESS, 0.0].into_iter().enumerate() {
        let mut scene = scene.clone();
        scene.bodies.iter_mut().for_each(|b| b.friction = friction);
        let avatar = runner.avatar_of(&scene)?;
        let run = runner.play(&scene, &avatar)?;
        if k == 0 {
            page.picture(
                "lift",
                runner.strip(&scene, &avatar, &run),
                "standing, grasped, lifted, and after two seconds in the air",
            );
        }
        let grip = Grip::of(&avatar, &run.recording);
        let heights = grip.heights.iter().copied();
        let heights = run.recording.times.iter().copied().zip(heights);
        chart = chart.line(
            &format!("μ = {friction}"),
            heights.take_while(|(_, height)| *height > GONE),
        );
        if friction == 0.0 {
            page.check(
                "without friction, lifted",
                grip.highest,
                "mm",
                Bound::AtMost(20.0),
            );
            continue;
        }
        let with = format!(", μ = {friction}");
        page.check(
            format!("held above the table for 2 s{with}"),
            grip.lowest,
            "mm",
            Bound::AtLeast(50.0),
        );
        page.check(
            format!("creep in the hand in 2 s{with}"),
            grip.creep,
            "mm",
            Bound::AtMost(3.0),
        );
        page.check_intact(&with, &run.report);
    }
    page.curves(chart);
    Ok(page)
}

/// How the tube is held.
struct Grip {
    /// Its height above where it stood, mm.
    heights: Vec<f64>,
    /// Least and most of them in the last [`HELD`] seconds, mm.
    lowest: f64,
    highest: f64,
    /// How far it strays in the hand meanwhile, mm.
    creep: f64,
}

impl Grip {
    fn of(avatar: &Avatar, recording: &Recording) -> Self {
        let (times, states) = (&recording.times, &recording.states);
        let tube = |s: &State| s.frames[avatar.body_frame(0)].position;
        let first = tube(&states[0]).z;
        let end = times[times.len() - 1];
        let held: Vec<usize> = (0..times.len())
            .filter(|&i| times[i] >= end - HELD)
            .collect();
        // Seen from the wrist.
        let place = |&i: &usize| states[i].frames[0].inverse_transform(tube(&states[i]));
        let places: Vec<DVec3> = held.iter().map(place).collect();
        let strays = places.iter().map(|p| 1e3 * p.distance(places[0]));
        let heights: Vec<f64> = states.iter().map(|s| 1e3 * (tube(s).z - first)).collect();
        let meanwhile = || held.iter().map(|&i| heights[i]);
        Self {
            lowest: meanwhile().fold(f64::INFINITY, f64::min),
            highest: meanwhile().fold(f64::NEG_INFINITY, f64::max),
            creep: strays.fold(0.0, f64::max),
            heights,
        }
    }
}
