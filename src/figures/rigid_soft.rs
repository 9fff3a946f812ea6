//! Contact on a skeleton without tissue, and with it.

use super::{Bound, Figure, Page, Studio};
use crate::Result;
use crate::bake::without_tissue;
use crate::export::SceneRun;
use crate::load::Scene;
use crate::model::Frame;
use std::sync::Arc;

/// See [`draw`].
pub const FIGURE: Figure = Figure {
    name: "rigid_soft",
    title: "Rigid against soft press",
    paper: "figure 3",
    draw,
};

/// The same press twice: on the skeleton alone, whose skin cannot yield, and with the soft layer.
fn draw(studio: &Studio) -> Result<Page> {
    let mut scene = studio.scene(studio.pick("finger_press", "hand_press"))?;
    scene.steps = scene.step_at(scene.measure.full_press);
    scene.output.panels.truncate(3);
    let soft = studio.avatar_of(&scene)?;
    let rigid = Arc::new(without_tissue(&soft));
    let free = Scene {
        colliders: Vec::new(),
        ..scene.clone()
    };
    let free = studio.play(&free, &rigid)?;
    let mut page = Page::new(
        "The same press twice. Without a soft layer the skin follows its bones, and the skeleton takes the whole \
         contact: its joints give way. With the soft layer the tissue yields where it is touched, and the bones \
         stay nearer to where nothing touched them.",
    );
    let mut bones = Vec::new();
    for (name, avatar, yields) in [
        ("without tissue", &rigid, Bound::AtMost(0.0)),
        ("with tissue", &soft, Bound::AtLeast(studio.pick(0.5, 2.0))),
    ] {
        let run = studio.play(&scene, avatar)?;
        page.picture(
            if yields.holds(0.0) { "rigid" } else { "soft" },
            studio.strip(&scene, avatar, &run),
            format!("{}, {name}", scene.name),
        );
        let skin = run.report.full_press_displacement_mm;
        page.check(format!("skin yields {name}"), skin, "mm", yields);
        bones.push(1e3 * moved(&run, &free));
    }
    let (rigid, soft) = (bones[0], bones[1]);
    page.check(
        "bones give way without tissue",
        rigid,
        "mm",
        Bound::AtLeast(1.0),
    );
    page.check(
        "bones give way with tissue",
        soft,
        "mm",
        Bound::AtMost(0.9 * rigid),
    );
    Ok(page)
}

/// How far the joint that contact moved farthest stands at the end from where it stands without, m.
fn moved(run: &SceneRun, free: &SceneRun) -> f64 {
    let last = |run: &SceneRun| {
        run.recording
            .states
            .last()
            .map(|s| s.frames.clone())
            .unwrap_or_default()
    };
    let apart = |(a, b): (&Frame, &Frame)| a.position.distance(b.position);
    last(run)
        .iter()
        .zip(&last(free))
        .map(apart)
        .fold(0.0, f64::max)
}
