//! What a hand does.

use super::{alone, differing, drag, empty, keep, limb, middle, with_options};
use supple::model::Frame;
use supple_samples::Sample;
use supple_view::{Button, Command, Event, Key, Options, Picture, Request, Tool, ValueMap};

#[test]
fn a_grab_pulls_flesh_and_lets_it_go() {
    let _turn = alone();
    let Some(mut view) = limb(false) else { return };
    let Some(mut alone) = limb(false) else { return };
    let from = middle();
    drag(&mut view, from, [from[0], from[1] - 90.0], Button::Primary);
    view.run(0.4);
    // The same time without a grab: it sways by itself.
    alone.run(10.0 / 60.0 + 0.4);
    let before = alone.picture().unwrap();
    let held = view.picture().unwrap();
    keep(&held, "grabbed");
    let moved = differing(&before, &held);
    let pull = view.app.pull();
    let displaced = view.app.stage().unwrap().measures.last().displacement;
    assert!(
        moved > 500 && pull > 0.2 && displaced > 2e-3,
        "{moved} pixels, {pull} N, {displaced} m"
    );
    view.handle(Event::Button(Button::Primary, false));
    view.run(1.0);
    assert_eq!(view.app.pull(), 0.0);
    let left = view.app.stage().unwrap().measures.last().displacement;
    assert!(left < 0.1 * displaced, "{left} m of {displaced} m are left");
}

/// A finger that stands on its knuckle's side.
#[test]
fn a_grab_bends_bones_that_come_back() {
    let _turn = alone();
    let Some(mut view) = empty(false) else { return };
    view.show(Request::Sample(Sample::Finger)).unwrap();
    let bones = |view: &super::Offscreen| {
        let stage = view.app.stage().unwrap();
        stage.world.instance(stage.me).unwrap().frames().to_vec()
    };
    let moved = |a: &[Frame], b: &[Frame]| {
        let apart = |(a, b): (&Frame, &Frame)| a.position.distance(b.position);
        a.iter().zip(b).map(apart).fold(0.0, f64::max)
    };
    let before = bones(&view);
    let from = middle();
    drag(
        &mut view,
        from,
        [from[0] + 20.0, from[1] - 120.0],
        Button::Primary,
    );
    view.run(0.3);
    keep(&view.picture().unwrap(), "bent");
    assert!(view.app.pull() > 0.5, "{} N", view.app.pull());
    let far = moved(&before, &bones(&view));
    assert!(far > 1e-3, "{far} m");
    view.handle(Event::Button(Button::Primary, false));
    view.run(1.5);
    let left = moved(&before, &bones(&view));
    // It sways by itself.
    assert!(left < 0.3 * far, "{left} m of {far} m");
}

#[test]
fn a_softer_tissue_gives_way_further_to_the_same_pull() {
    let _turn = alone();
    let Some(mut view) = limb(false) else { return };
    let mut displaced = |softness: f64| {
        view.app.ask(Command::Reset);
        view.app.controls.softness = softness;
        view.app.controls.pull = 20.0;
        let from = middle();
        drag(&mut view, from, [from[0], from[1] - 60.0], Button::Primary);
        view.run(0.5);
        let displaced = view.app.stage().unwrap().measures.last().displacement;
        view.handle(Event::Button(Button::Primary, false));
        displaced
    };
    let (firm, soft) = (displaced(1.0), displaced(3.0));
    assert!(soft > 1.5 * firm, "{soft} m, {firm} m");
}

#[test]
fn a_ball_on_the_cursor_is_pressed_in_by_the_wheel_and_colours_what_it_presses() {
    let _turn = alone();
    let Some(mut view) = limb(false) else { return };
    view.app.controls.map = ValueMap::Pressure;
    view.app.controls.width = 0.03;
    view.handle(Event::Key(Key::Num2, true));
    assert_eq!(view.app.controls.tool, Tool::Ball);
    view.handle(Event::Moved(middle()));
    view.run(0.2);
    let force = |view: &super::Offscreen| view.app.stage().unwrap().measures.last().force;
    let stands = force(&view);
    let hovering = view.picture().unwrap();
    keep(&hovering, "hovering");
    for _ in 0..26 {
        view.handle(Event::Wheel(1.0));
        view.run(1.0 / 60.0);
    }
    view.run(0.4);
    let pressed = view.picture().unwrap();
    keep(&pressed, "pressed");
    let presses = force(&view);
    // Red to violet around the ball, which hides the most of it.
    let [x, y] = middle().map(|n| n as u32);
    let around = (x - 60..x + 60).flat_map(|x| (y - 60..y + 60).map(move |y| (x, y)));
    let red = |picture: &Picture| {
        let of = |&(x, y): &(u32, u32)| {
            let [r, g, _] = picture.at(x, y);
            i32::from(r) > i32::from(g) + 40
        };
        around.clone().filter(of).count()
    };
    let (before, after) = (red(&hovering), red(&pressed));
    assert!(before == 0 && after > 60, "{before}, {after} pixels");
    assert!(presses > stands + 2.0, "{presses} N");
    let stage = view.app.stage().unwrap();
    let most = stage.shown.pressures.iter().copied().fold(0.0, f64::max);
    assert!(most > 1e3, "{most} Pa");
    // Out again.
    for _ in 0..30 {
        view.handle(Event::Wheel(-1.0));
        view.run(1.0 / 60.0);
    }
    view.run(0.5);
    // It stands on the ground all the same.
    assert!(force(&view) < stands + 1.0, "{} N", force(&view));
    view.handle(Event::Key(Key::Num1, true));
    view.run(0.1);
    assert!(differing(&hovering, &view.picture().unwrap()) > 300);
}

#[test]
fn thrown_balls_fly_hit_and_are_gone_after_a_reset() {
    let _turn = alone();
    let Some(mut view) = limb(false) else { return };
    view.app.pace.paused = true;
    let before = view.picture().unwrap();
    view.app.pace.paused = false;
    view.run(0.1);
    let stands = view.app.stage().unwrap().measures.last().displacement;
    view.handle(Event::Moved(middle()));
    view.handle(Event::Key(Key::B, true));
    view.run(0.05);
    let flying = view.picture().unwrap();
    keep(&flying, "thrown");
    assert!(differing(&before, &flying) > 300);
    let mut most = 0.0f64;
    for _ in 0..40 {
        view.run(1.0 / 60.0);
        most = most.max(view.app.stage().unwrap().measures.last().displacement);
    }
    assert!(most > stands + 2e-4, "{most} m");
    view.handle(Event::Key(Key::R, true));
    view.run(0.05);
    assert!(view.app.notice().is_none(), "{:?}", view.app.notice());
    assert!(differing(&before, &view.picture().unwrap()) < 400);
}

/// With a ball in the air, and something on the cursor that is no part of it.
#[test]
fn a_moment_is_kept_and_restored() {
    let _turn = alone();
    let Some(mut view) = limb(false) else { return };
    let skin = |view: &super::Offscreen| view.app.stage().unwrap().shown.positions.clone();
    view.handle(Event::Moved(middle()));
    view.handle(Event::Key(Key::B, true));
    view.handle(Event::Key(Key::Num3, true));
    view.run(0.05);
    view.handle(Event::Key(Key::K, true));
    view.handle(Event::Key(Key::Space, true));
    view.handle(Event::Key(Key::Num1, true));
    view.run(0.02);
    let (kept, seen) = (skin(&view), view.picture().unwrap());
    view.handle(Event::Key(Key::Space, true));
    view.run(0.5);
    assert_ne!(kept, skin(&view));
    view.handle(Event::Key(Key::Space, true));
    view.handle(Event::Key(Key::L, true));
    view.run(0.02);
    let again = view.picture().unwrap();
    keep(&again, "restored");
    assert_eq!(kept, skin(&view));
    // The notice is in the panel.
    let different = differing(&seen, &again);
    assert!(different < 50, "{different} pixels");
    // The ball is there, and not only drawn.
    view.handle(Event::Key(Key::Space, true));
    view.run(0.1);
    assert!(differing(&again, &view.picture().unwrap()) > 300);
    assert!(view.app.notice().is_none_or(|notice| !notice.wrong));
}

/// A scene of a fifth of a second begins again; what was thrown and held then is gone, and may come again.
#[test]
fn a_scene_begins_again_whatever_is_on_the_cursor() {
    let _turn = alone();
    let Some(mut view) = empty(false) else { return };
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("short.toml");
    let scene = r#"
        name = "short"
        steps = 20
        avatar.sample = "limb_s"
        pins = [{ bone = "bone", motion.z = [[0.0, 0.0], [0.2, 0.02]] }]
        bodies = [{ name = "die", shape = { shape = "box", half_extents = [0.01, 0.01, 0.01] }, position = [0.1, 0.0, 0.2] }]
    "#;
    std::fs::write(&path, scene).unwrap();
    view.show(Request::File(path)).unwrap();
    assert_eq!(view.app.stage().unwrap().character.does, "scene short");
    view.handle(Event::Moved(middle()));
    view.handle(Event::Key(Key::Num2, true));
    view.handle(Event::Key(Key::B, true));
    view.run(0.1);
    for _ in 0..4 {
        view.handle(Event::Moved(middle()));
        view.run(0.15);
    }
    keep(&view.picture().unwrap(), "again");
    let stage = view.app.stage().unwrap();
    assert!(view.app.notice().is_none(), "{:?}", view.app.notice());
    assert_eq!(stage.rounds, 3, "{} s", stage.time);
    assert!(stage.time < 0.2001, "{} s", stage.time);
}

/// Baked with fine handles, a grab wakes them, as many as may be, and flesh gives way further to the same pull.
#[test]
fn a_grab_wakes_fine_handles() {
    let _turn = alone();
    let mut pulled = Vec::new();
    for budget in [0, 12] {
        let fine = with_options(Options {
            fine_handles: true,
            ..Options::default()
        });
        let Some(mut view) = fine else { return };
        view.show(Request::Sample(Sample::LimbS)).unwrap();
        view.app.controls.fine_handles = budget;
        let from = middle();
        drag(&mut view, from, [from[0], from[1] - 90.0], Button::Primary);
        view.run(0.5);
        let stage = view.app.stage().unwrap();
        // As many as may, or all that are near.
        let awake = stage.awake();
        assert!(awake <= budget && 2 * awake >= budget, "{awake}");
        pulled.push(stage.measures.last().displacement / view.app.pull());
        keep(&view.picture().unwrap(), &format!("fine_{budget}"));
        view.app.ask(Command::WriteGlb);
        view.run(0.1);
        let told = view.app.notice().unwrap();
        assert!(!told.wrong, "{}", told.text);
    }
    assert!(pulled[1] > 1.03 * pulled[0], "{pulled:?} m/N");
}
