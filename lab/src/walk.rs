//! A body that tracks a recorded walk.

use super::measure::world_displacement;
use super::spectrum::{Sample, between, peak, spectrum};
use super::{Bound, Figure, Page, Runner};
use glam::DVec3;
use std::path::Path;
use supple::Result;
use supple::model::{Avatar, Frame};
use supple::sim::{Instance, SolverMode};
use supple_pictures::Curves;
use supple_scene::{Driver, Scene, SceneRun, read_motion};

/// See [`draw`].
pub const FIGURE: Figure = Figure {
    name: "walk",
    title: "A body tracks a recorded walk",
    paper: "figure 9",
    draw,
};

/// A recorded walk that is not ours to ship: shown where it lies beside the repository.
const RECORDED: &str = "../shared/assets/motion/cmu_orig_02_01.bvh";

/// Bones whose soft tissue is looked at.
const TRUNK: [&str; 4] = ["pelvis", "spine1", "spine2", "spine3"];

/// Walks by springs on every bone. The joints follow their targets, and the trunk's soft tissue swings up and down
/// once a step.
fn draw(runner: &Runner) -> Result<Page> {
    let mut scene = runner.scene("body_walk")?;
    if runner.small() {
        scene.settings.time_step = 1.0 / 60.0;
        // One iteration of so long a step leaves joints apart by what the bones' turns miss of second order.
        scene.settings.solver = SolverMode::TWO_ITERATIONS;
        scene.steps = 200;
    }
    let mut page = Page::new(
        "Springs draw every bone of the body to a walk, and its soft tissue swings by its inertia alone: nothing \
         touches it. The colours show how far tissue moves from the skinned shape; insets show the same on the \
         reference shape.",
    );
    walked(runner, &scene, "generated", &mut page)?;
    let recorded = Path::new(RECORDED);
    if !runner.small() {
        if recorded.exists() {
            let scene = recorded_scene(scene, recorded)?;
            walked(runner, &scene, "recorded", &mut page)?;
        } else {
            page.text("The recorded walk is not here, and is left out.");
        }
    }
    Ok(page)
}

/// The scene with the motion of `file`, once.
fn recorded_scene(mut scene: Scene, file: &Path) -> Result<Scene> {
    if let Some(motion) = &mut scene.motion {
        motion.file = file.into();
        motion.repeat = false;
        let whole = read_motion(motion)?.map_or(f64::INFINITY, |clip| clip.duration());
        scene.steps = (scene.steps).min((whole / scene.settings.time_step) as usize);
    }
    let end = scene.duration();
    scene.measure.full_press = scene.measure.full_press.min(end);
    for panel in &mut scene.output.panels {
        panel.time = panel.time.min(end);
    }
    Ok(scene)
}

/// Plays `scene` and adds what came of it.
fn walked(runner: &Runner, scene: &Scene, name: &'static str, page: &mut Page) -> Result<()> {
    let avatar = runner.avatar_of(scene)?;
    let targets = targets(scene, &avatar)?;
    let run = runner.play(scene, &avatar)?;
    let caption = format!("{name} walk");
    page.picture(name, runner.strip(scene, &avatar, &run), caption);

    let eased = scene.motion.as_ref().map_or(0.0, |m| m.ease_in);
    let errors: Vec<(f64, [f64; 2])> = (targets.iter())
        .zip(
            run.recording
                .times
                .iter()
                .zip(&run.recording.states)
                .skip(1),
        )
        .map(|(wanted, (time, state))| (*time, errors(wanted, &state.frames)))
        .filter(|(time, _)| *time >= eased)
        .collect();
    let strikes: Vec<f64> = heel_strikes(scene, &avatar, &targets);
    let swing = swing(&avatar, &run);
    let steps = (strikes.len() as f64 - 1.0) / (strikes[strikes.len() - 1] - strikes[0]);

    let at = |time: f64| {
        let k = swing.partition_point(|p| p.0 < time).min(swing.len() - 1);
        (time, swing[k].1)
    };
    page.curves(
        Curves::new(
            &format!("Soft tissue of the trunk, {name} walk"),
            "time (s)",
            "mean displacement upward (mm)",
        )
        .line("trunk", swing.iter().copied().filter(|p| p.0 >= eased))
        .events("heel strikes", strikes.iter().map(|&t| at(t))),
    );
    let samples: Vec<Sample> = (swing.iter().filter(|p| p.0 >= eased))
        .map(|&(at, value)| Sample {
            at,
            value,
            weight: 1.0,
        })
        .collect();
    let waves = spectrum(&samples, between(0.4 * steps, 3.2 * steps, 280));
    let (frequency, amplitude) = peak(&waves);
    page.curves(
        Curves::new("Its waves", "frequency (steps)", "amplitude (mm)")
            .line("trunk", waves.iter().map(|(f, a)| (f / steps, *a))),
    );

    let largest = |k: usize| errors.iter().map(|e| e.1[k]).fold(0.0, f64::max);
    let mut check = |what: &str, value: f64, unit, bound| {
        page.check(format!("{name}: {what}"), value, unit, bound);
    };
    check("steps a second", steps, "1/s", Bound::Within(1.2, 3.0));
    check(
        "largest joint error",
        1e3 * largest(0),
        "mm",
        Bound::AtMost(15.0),
    );
    check(
        "largest rotation error",
        largest(1).to_degrees(),
        "°",
        Bound::AtMost(3.0),
    );
    let whole = (frequency / steps).round();
    check(
        "waves of the largest swing in a step",
        whole,
        "",
        Bound::Within(1.0, 2.0),
    );
    check(
        "off a whole number by",
        (frequency / steps - whole).abs(),
        "",
        Bound::AtMost(0.12),
    );
    let amplitude_at = |f: f64| spectrum(&samples, [f * steps])[0].1;
    check(
        "amplitude of swings in step with the heels, over that of swings half a step off",
        (amplitude_at(1.0) + amplitude_at(2.0)) / (amplitude_at(1.5) + amplitude_at(2.5)),
        "",
        Bound::AtLeast(2.0),
    );
    check(
        "amplitude of the largest swing",
        amplitude,
        "mm",
        Bound::AtLeast(0.1),
    );
    page.check_intact(&format!(", {name}"), &run.report);
    Ok(())
}

/// Where the bones are drawn to at the end of each step.
fn targets(scene: &Scene, avatar: &Avatar) -> Result<Vec<Vec<(usize, Frame)>>> {
    let mut driver = Driver::new(scene, avatar)?;
    let mut instance = Instance::new(avatar, &scene.settings);
    driver.start(avatar, &mut instance);
    driver.launch(avatar, &mut instance);
    (1..=scene.steps)
        .map(|step| {
            driver.drive(step as f64 * scene.settings.time_step, &mut instance)?;
            Ok(instance.targets.iter().map(|t| (t.bone, t.frame)).collect())
        })
        .collect()
}

/// Largest distance (m) and angle (rad) of the bones from their targets.
fn errors(targets: &[(usize, Frame)], frames: &[Frame]) -> [f64; 2] {
    let apart = targets.iter().map(|(bone, target)| {
        let (way, turn) = target.motion_to(&frames[*bone]);
        [way.length(), turn.length()]
    });
    apart.fold([0.0, 0.0], |a, b| [a[0].max(b[0]), a[1].max(b[1])])
}

/// Times at which a heel comes down: where a foot is farthest ahead of the pelvis (Zeni, Richards and Higginson
/// 2008), in the motion that is tracked, s.
fn heel_strikes(scene: &Scene, avatar: &Avatar, targets: &[Vec<(usize, Frame)>]) -> Vec<f64> {
    let h = scene.settings.time_step;
    let eased = scene.motion.as_ref().map_or(0.0, |m| m.ease_in);
    let place = |step: usize, name: &str| {
        let bone = avatar.skeleton.find(name);
        let target = targets[step].iter().find(|(b, _)| Some(*b) == bone);
        target.map_or(DVec3::ZERO, |(_, frame)| frame.position)
    };
    let last = targets.len() - 1;
    let first = ((eased / h) as usize).min(last);
    let way = (place(last, "pelvis") - place(first, "pelvis")).reject_from(DVec3::Z);
    let mut strikes = Vec::new();
    for foot in ["left_ankle", "right_ankle"] {
        let ahead: Vec<f64> = (0..=last)
            .map(|k| (place(k, foot) - place(k, "pelvis")).dot(way.normalize_or_zero()))
            .collect();
        let most = ahead.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let peak = |k: &usize| {
            ahead[*k] >= ahead[k - 1] && ahead[*k] > ahead[k + 1] && ahead[*k] > 0.7 * most
        };
        // The end of step k is at (k + 1) h.
        let peaks = (first.max(1)..last)
            .filter(peak)
            .map(|k| (k + 1) as f64 * h);
        strikes.extend(peaks);
    }
    strikes.sort_by(f64::total_cmp);
    strikes
}

/// Mean upward displacement of the trunk's skin, by area: (s, mm).
fn swing(avatar: &Avatar, run: &SceneRun) -> Vec<(f64, f64)> {
    let trunk: Vec<usize> = TRUNK
        .iter()
        .filter_map(|n| avatar.skeleton.find(n))
        .collect();
    let share: Vec<f64> = (avatar.skin.skinning.iter().zip(&avatar.skin.measure))
        .map(|(row, area)| {
            let of_trunk = row.iter().filter(|w| trunk.contains(&(w.bone as usize)));
            area * of_trunk.map(|w| w.weight).sum::<f64>()
        })
        .collect();
    let total: f64 = share.iter().sum();
    let mean = |state| {
        let moved = world_displacement(avatar, state);
        let up = moved.iter().zip(&share).map(|(d, s)| s * d.z);
        1e3 * up.sum::<f64>() / total
    };
    (run.recording.times.iter().zip(&run.recording.states))
        .map(|(t, state)| (*t, mean(state)))
        .collect()
}
