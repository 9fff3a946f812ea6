//! Contact on a skeleton without tissue, and with it.

use super::{Bound, Figure, Page, Runner};
use std::sync::Arc;
use supple::Result;
use supple_bake::without_tissue;
use supple_scene::{Scene, SceneRun};

/// See [`draw`].
pub const FIGURE: Figure = Figure {
    name: "rigid_soft",
    title: "Rigid against soft press",
    paper: "figure 3",
    draw,
};

/// The same press twice: on the skeleton alone, whose skin cannot yield, and with the soft layer.
fn draw(runner: &Runner) -> Result<Page> {
    let mut scene = runner.scene(runner.pick("finger_press", "hand_press"))?;
    scene.steps = scene.step_at(scene.measure.full_press);
    scene.output.panels.truncate(3);
    let soft = runner.avatar_of(&scene)?;
    let rigid = Arc::new(without_tissue(&soft));
    let free = Scene {
        colliders: Vec::new(),
        ..scene.clone()
    };
    let free = runner.play(&free, &rigid)?;
    let mut page = Page::new(
        "The same press twice. Without a soft layer the skin follows its bones, and the skeleton takes the whole \
         contact: its joints give way. With the soft layer the tissue yields where it is touched, and the bones \
         stay nearer to where nothing touched them.",
    );
    let [rigid_run, soft_run] = [&rigid, &soft].map(|avatar| runner.play(&scene, avatar));
    let (rigid_run, soft_run) = (rigid_run?, soft_run?);
    // One scale for both.
    scene.output.legend_mm = Some(soft_run.report.full_press_displacement_mm);
    for (name, what, avatar, run) in [
        ("rigid", "without tissue", &rigid, &rigid_run),
        ("soft", "with tissue", &soft, &soft_run),
    ] {
        let picture = runner.strip(&scene, avatar, run);
        page.picture(name, picture, format!("{}, {what}", scene.name));
    }
    let yields = |run: &SceneRun| run.report.full_press_displacement_mm;
    let (none, most) = (Bound::AtMost(0.0), Bound::AtLeast(runner.pick(0.5, 2.0)));
    page.check("skin yields without tissue", yields(&rigid_run), "mm", none);
    page.check("skin yields with tissue", yields(&soft_run), "mm", most);
    let (rigid, soft) = (moved(&rigid_run, &free), moved(&soft_run, &free));
    let (much, less) = (Bound::AtLeast(1.0), Bound::AtMost(0.9e3 * rigid));
    page.check("bones give way without tissue", 1e3 * rigid, "mm", much);
    page.check("bones give way with tissue", 1e3 * soft, "mm", less);
    Ok(page)
}

/// How far the joint that contact moved farthest stands at the end from where it stands without, m.
fn moved(run: &SceneRun, free: &SceneRun) -> f64 {
    let (pressed, free) = (run.recording.states.last(), free.recording.states.last());
    let pairs = pressed.zip(free).into_iter();
    pairs
        .flat_map(|(a, b)| a.frames.iter().zip(&b.frames))
        .map(|(a, b)| a.position.distance(b.position))
        .fold(0.0, f64::max)
}
