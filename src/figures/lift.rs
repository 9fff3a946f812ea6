//! A hand that lifts a dynamic object.

use super::{Bound, Curves, Figure, Page, Studio};
use crate::Result;
use crate::load::Scene;
use crate::model::{Avatar, Frame, State};
use glam::DVec3;

/// See [`draw`].
pub const FIGURE: Figure = Figure {
    name: "lift",
    title: "A hand lifts a tube",
    paper: "figure 11",
    draw,
};

/// For how long it is held, s.
const HELD: f64 = 2.0;

/// Fingers close around a tube from poses that come in as a stream, the hand lifts it, and friction holds it; without
/// friction it slips through.
fn draw(studio: &Studio) -> Result<Page> {
    let scene = studio.scene("lift")?;
    let mut page = Page::new(
        "A hand closes around a dynamic tube and lifts it off the table. The poses arrive as a stream; the tube is a \
         rigid body in the hand's own Newton system, so fingers and tube push each other, and only friction carries \
         its weight. The same without friction leaves it behind.",
    );
    let avatar = studio.avatar_of(&scene)?;
    let run = studio.play(&scene, &avatar)?;
    page.picture(
        "lift",
        studio.strip(&scene, &avatar, &run),
        "standing, grasped, lifted, and after two seconds in the air",
    );
    let (times, states) = (&run.recording.times, &run.recording.states);
    let heights = |states: &[State]| -> Vec<f64> {
        let tube = |s: &State| s.frames[avatar.body_frame(0)].position.z;
        let first = tube(&states[0]);
        states.iter().map(|s| 1e3 * (tube(s) - first)).collect()
    };
    let lifted = heights(states);
    let end = times[times.len() - 1];
    let held: Vec<usize> = (0..times.len())
        .filter(|&i| times[i] >= end - HELD)
        .collect();
    let places: Vec<DVec3> = (held.iter())
        .map(|&i| 1e3 * in_the_hand(&avatar, &states[i]))
        .collect();
    let creep = places
        .iter()
        .map(|p| p.distance(places[0]))
        .fold(0.0, f64::max);

    let slippery = without_friction(&scene);
    let slippery_avatar = studio.avatar_of(&slippery)?;
    let slid = heights(&studio.play(&slippery, &slippery_avatar)?.recording.states);
    let along = |heights: &[f64]| -> Vec<(f64, f64)> {
        times.iter().copied().zip(heights.iter().copied()).collect()
    };
    page.curves(
        Curves::new("Height of the tube above where it stood", "time (s)", "mm")
            .line("with friction", along(&lifted))
            .line("without", along(&slid)),
    );
    let least = |heights: &[f64]| {
        held.iter()
            .map(|&i| heights[i])
            .fold(f64::INFINITY, f64::min)
    };
    let most = |heights: &[f64]| held.iter().map(|&i| heights[i]).fold(0.0, f64::max);
    page.check(
        "held above the table for 2 s",
        least(&lifted),
        "mm",
        Bound::AtLeast(50.0),
    );
    page.check("creep in the hand in 2 s", creep, "mm", Bound::AtMost(3.0));
    page.check(
        "without friction, lifted",
        most(&slid),
        "mm",
        Bound::AtMost(20.0),
    );
    page.check_intact("", &run.report);
    Ok(page)
}

/// Where the tube is, seen from the wrist, m.
fn in_the_hand(avatar: &Avatar, state: &State) -> DVec3 {
    let (wrist, tube): (Frame, Frame) = (state.frames[0], state.frames[avatar.body_frame(0)]);
    wrist.inverse_transform(tube.position)
}

fn without_friction(scene: &Scene) -> Scene {
    let mut scene = scene.clone();
    scene.bodies.iter_mut().for_each(|b| b.friction = 0.0);
    scene
}
