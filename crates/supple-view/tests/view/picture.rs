//! What is seen of who stands there.

use super::{Picture, SIZE, alone, differing, drag, keep, limb, middle, scene};
use supple_view::{Button, Event, Key, ValueMap};

/// Skin is the reddest thing there.
fn is_skin([r, g, b]: [u8; 3]) -> bool {
    i32::from(r) > i32::from(b) + 25 && r > g
}

fn skin(picture: &Picture) -> usize {
    let [width, height] = scene();
    let places = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    places.filter(|&(x, y)| is_skin(picture.at(x, y))).count()
}

#[test]
fn a_character_stands_on_a_ground_in_its_shadow() {
    let _turn = alone();
    let Some(mut view) = limb(false) else { return };
    view.app.pace.paused = true;
    let picture = view.picture().unwrap();
    keep(&picture, "stands");
    let share = skin(&picture) as f64 / f64::from(scene()[0] * scene()[1]);
    assert!((0.03..0.6).contains(&share), "{share}");
    let [x, y] = middle().map(|n| n as u32);
    assert!(is_skin(picture.at(x, y)), "{:?}", picture.at(x, y));
    // The ground is grey, and darker where the sun does not reach.
    let row = |y: u32| (0..scene()[0]).map(move |x| (x, y));
    let ground = (scene()[1] / 2..scene()[1])
        .flat_map(row)
        .map(|(x, y)| picture.at(x, y));
    let grey = |p: &[u8; 3]| p.iter().max().unwrap() - p.iter().min().unwrap() < 14;
    let greys: Vec<u8> = ground.filter(grey).map(|p| p[1]).collect();
    let shade = |range: std::ops::Range<u8>| greys.iter().filter(|g| range.contains(g)).count();
    let (shadow, light) = (shade(60..115), shade(125..200));
    assert!(shadow > 800 && light > 10_000, "{shadow} {light}");
    // The panel has something to say.
    let panel = (scene()[0] + 8..SIZE[0]).flat_map(|x| (0..SIZE[1]).map(move |y| (x, y)));
    let letters = panel.filter(|&(x, y)| picture.at(x, y)[1] > 130).count();
    assert!(letters > 400, "{letters}");
}

#[test]
fn the_camera_turns_and_comes_near() {
    let _turn = alone();
    let Some(mut view) = limb(false) else { return };
    view.app.pace.paused = true;
    let before = view.picture().unwrap();
    drag(
        &mut view,
        middle(),
        [middle()[0] + 60.0, middle()[1]],
        Button::Secondary,
    );
    view.handle(Event::Button(Button::Secondary, false));
    let turned = view.picture().unwrap();
    assert!(differing(&before, &turned) > 2000);
    view.handle(Event::Wheel(4.0));
    let near = view.picture().unwrap();
    keep(&near, "near");
    assert!(skin(&near) as f64 > 1.3 * skin(&turned) as f64);
}

#[test]
fn time_stands_still_goes_step_by_step_and_back_to_the_start() {
    let _turn = alone();
    let Some(mut view) = limb(false) else { return };
    let time = |view: &super::Offscreen| view.app.stage().unwrap().time;
    view.handle(Event::Key(Key::Space, true));
    view.run(0.2);
    assert_eq!(time(&view), 0.0);
    view.handle(Event::Key(Key::Period, true));
    view.run(0.2);
    assert!((time(&view) - view.app.controls.time_step).abs() < 1e-12);
    view.handle(Event::Key(Key::Space, true));
    view.handle(Event::Key(Key::S, true));
    view.run(1.0);
    assert!((0.15..0.25).contains(&time(&view)), "{}", time(&view));
    let skin = view.app.stage().unwrap().shown.positions.clone();
    view.handle(Event::Key(Key::R, true));
    view.handle(Event::Key(Key::Space, true));
    view.run(0.1);
    assert_eq!(time(&view), 0.0);
    assert_ne!(skin, view.app.stage().unwrap().shown.positions);
}

#[test]
fn values_colour_the_skin_and_handles_are_dots() {
    let _turn = alone();
    let Some(mut view) = limb(false) else { return };
    view.app.pace.paused = true;
    let painted = view.picture().unwrap();
    view.app.controls.map = ValueMap::Depth;
    view.run(0.1);
    let depth = view.picture().unwrap();
    keep(&depth, "depth");
    let stage = view.app.stage().unwrap();
    let depths = &stage.character.depths;
    println!(
        "{:?} {}",
        depths.iter().copied().fold(0.0, f64::max),
        stage.shown.most
    );
    assert!(differing(&painted, &depth) > 2000);
    view.app.controls.map = ValueMap::None;
    view.run(0.1);
    assert!(differing(&painted, &view.picture().unwrap()) < 20);
    view.handle(Event::Key(Key::H, true));
    let dots = view.picture().unwrap();
    let green = |p: [u8; 3]| p[1] > p[0].saturating_add(40) && p[1] > p[2].saturating_add(30);
    let row = |y: u32| (0..scene()[0]).map(move |x| (x, y));
    keep(&dots, "handles");
    let count = (0..scene()[1])
        .flat_map(row)
        .filter(|&(x, y)| green(dots.at(x, y)))
        .count();
    assert!(count > 100, "{count}");
}

/// Colours and shadows of one character, wherever its skin is computed.
#[test]
fn a_world_on_the_device_is_drawn_from_where_its_skin_is() {
    let _turn = alone();
    let (Some(mut on_cpu), Some(mut on_gpu)) = (limb(false), limb(true)) else {
        return;
    };
    let pictures = [&mut on_cpu, &mut on_gpu].map(|view| {
        view.run(0.3);
        view.picture().unwrap()
    });
    keep(&pictures[1], "on_gpu");
    assert!(on_gpu.app.stage().unwrap().world.backend() != "cpu");
    assert!(skin(&pictures[1]) > 5000);
    let different = differing(&pictures[0], &pictures[1]);
    assert!(different < 100, "{different} pixels");
}
