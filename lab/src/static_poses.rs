//! Static poses: the data-driven shape, kept exactly.

use super::measure::longest;
use super::poses::{Pose, body_poses, hand_poses, random_pose};
use super::{Bound, Figure, Page, Runner};
use glam::{DMat3, DVec3};
use std::sync::Arc;
use supple::Result;
use supple::internal::cpu::posed_skin;
use supple::internal::math::{Random, rotation_exp, rotation_log};
use supple::model::{Avatar, Integrator, PoseBlend, State, Surface};
use supple::potential::CpuPotential;
use supple::sim::{Settings, Simulation, SolverMode};
use supple::skeleton::Tracking;
use supple_bake::ParametricModel;
use supple_pictures::{Camera, ColourScale, Legend, Mesh, Panel};
use supple_samples::Sample;

/// See [`draw`].
pub const FIGURE: Figure = Figure {
    name: "static_poses",
    title: "Static poses, and a posed contact",
    paper: "figures 2 and 6",
    draw,
};

/// A sample in poses.
struct Posed {
    name: &'static str,
    avatar: Arc<Avatar>,
    model: ParametricModel,
    poses: Vec<Pose>,
    /// Where the camera looks, and what is up.
    view: DVec3,
    up: DVec3,
    size: [usize; 2],
}

/// Poses with and without pose blend shapes; the simulated skin against the parametric model's; a contact in a pose.
fn draw(runner: &Runner) -> Result<Page> {
    let mut page = Page::new(
        "Nothing touches these: bones are drawn to a pose by springs and simulated until they rest, and the skin is \
         that of the data-driven model, with its pose blend shapes (below) and without them (above).",
    );
    let count = runner.pick(3, 50);
    let hand = hand(runner)?;
    compare(runner, &hand, count, &mut page)?;
    if !runner.small() {
        compare(runner, &body(runner)?, count, &mut page)?;
        contact(runner, &mut page)?;
    }
    Ok(page)
}

fn hand(runner: &Runner) -> Result<Posed> {
    let avatar = runner.sample(Sample::Hand)?;
    Ok(Posed {
        name: "hand",
        model: supple_samples::hand()?.model,
        poses: hand_poses(&avatar.skeleton),
        avatar,
        view: DVec3::new(-0.35, -1.0, 0.75),
        up: DVec3::Z,
        size: [420, 380],
    })
}

fn body(runner: &Runner) -> Result<Posed> {
    let avatar = runner.sample(Sample::Body)?;
    Ok(Posed {
        name: "body",
        model: supple_samples::body()?.model,
        poses: body_poses(&avatar.skeleton),
        avatar,
        view: DVec3::new(-0.55, -0.15, -1.0),
        up: DVec3::Y,
        size: [420, 520],
    })
}

/// Pictures of the poses, and the skin's distance from the model's over them and `count` random ones.
fn compare(runner: &Runner, posed: &Posed, count: usize, page: &mut Page) -> Result<()> {
    let Posed {
        name,
        avatar,
        model,
        ..
    } = posed;
    let mut plain = avatar.as_ref().clone();
    plain.skin.pose_blend = PoseBlend::default();
    plain.cubature.pose_blend = PoseBlend::default();
    let mut random = Random::new(2021);
    let named = posed.poses.iter().map(|p| p.local.clone());
    let locals: Vec<Vec<DMat3>> = named
        .chain((0..count).map(|_| random_pose(&avatar.skeleton, &mut random)))
        .collect();
    let (mut error, mut phi) = (0.0f64, 0.0f64);
    let mut shown = Vec::new();
    for (k, local) in locals.iter().enumerate() {
        let state = at_rest(avatar, local)?;
        let skin = posed_skin(avatar, &state);
        let wanted = model.evaluate(&[], local, DVec3::ZERO);
        // Relative to the root, which is where it was drawn to.
        let shift = state.frames[0].position - avatar.skeleton.joints[0];
        error = error.max(longest(
            skin.positions
                .iter()
                .zip(&wanted)
                .map(|(a, b)| *a - shift - *b),
        ));
        phi = phi.max(longest(state.handles.iter().copied()));
        if k < posed.poses.len() {
            shown.push((posed_skin(&plain, &state), skin));
        }
        runner.progress(&format!("poses of the {name}"), k + 1, locals.len());
    }
    let blend = compared(runner, posed, shown, page);
    let what = format!(
        "{name}: skin off the parametric model over {} poses",
        locals.len()
    );
    page.check(what, error, "m", Bound::AtMost(1e-6));
    page.check(
        format!("{name}: longest handle displacement"),
        phi,
        "m",
        Bound::AtMost(1e-6),
    );
    let what = format!("{name}: most that pose blend shapes move the skin");
    page.check(what, 1e3 * blend, "mm", Bound::AtLeast(1.0));
    Ok(())
}

/// Adds pictures of skins without and with pose blend shapes, one of [`Posed::poses`] each; the latter are coloured by
/// how far the blend shapes move them. Gives the farthest, m.
fn compared(
    runner: &Runner,
    posed: &Posed,
    shown: Vec<(Surface, Surface)>,
    page: &mut Page,
) -> f64 {
    let moved: Vec<Vec<f64>> = (shown.iter())
        .map(|(plain, skin)| {
            let pairs = plain.positions.iter().zip(&skin.positions);
            pairs.map(|(a, b)| 1e3 * a.distance(*b)).collect()
        })
        .collect();
    let scale = ColourScale::of(moved.iter().flatten().copied());
    let (mut above, mut below) = (Vec::new(), Vec::new());
    for (((plain, skin), moved), pose) in shown.into_iter().zip(moved).zip(&posed.poses) {
        let [width, height] = posed.size;
        let aspect = width as f64 / height as f64;
        let camera = Camera::framing(&skin.positions, posed.view, posed.up, aspect);
        let panel = |mesh: Mesh, shapes: &str| Panel {
            image: runner.picture(&[mesh], camera, posed.size),
            caption: format!("{}, {shapes}", pose.name),
        };
        above.push(panel(Mesh::new(plain, scale.colour(0.0)), "without"));
        below.push(panel(Mesh::coloured(skin, scale.colours(moved)), "with"));
    }
    let columns = above.len();
    above.append(&mut below);
    let legend = Legend {
        title: "moved by pose blend shapes (mm)".into(),
        scale,
    };
    let sheet = runner.sheet(above, columns, Some(legend));
    let caption = format!(
        "{}: without pose blend shapes above, with them below",
        posed.name
    );
    page.picture(posed.name, sheet, caption);
    1e-3 * scale.high
}

/// The state in which `avatar` rests when springs draw every bone to the pose `local`, without gravity; it comes from
/// the bind pose, in quarters of the way.
fn at_rest(avatar: &Arc<Avatar>, local: &[DMat3]) -> Result<State> {
    let settings = Settings {
        // Long steps: what swings at ω comes to 1/(1 + ω²h²) of it in each, at 2 Hz to a fifteenth.
        time_step: 0.3,
        integrator: Integrator::BackwardEuler,
        solver: SolverMode::CONVERGED,
        ..Settings::default()
    };
    let potential = CpuPotential::new(avatar.clone(), 1)?;
    let mut simulation = Simulation::new(avatar, potential, settings)?;
    let skeleton = &avatar.skeleton;
    simulation.instances_mut()[0].gravity = DVec3::ZERO;
    for part in [0.25, 0.5, 0.75, 1.0, 1.0, 1.0, 1.0] {
        let turned: Vec<DMat3> = (local.iter())
            .map(|r| rotation_exp(part * rotation_log(*r)))
            .collect();
        let frames = skeleton.forward_kinematics(&turned, skeleton.joints[0]);
        let instance = &mut simulation.instances_mut()[0];
        for (j, parent) in skeleton.parents.iter().enumerate() {
            if parent.is_some() {
                instance.bending[j].rest_rotation = turned[j];
            }
        }
        let targets = frames.iter().enumerate().map(|(j, f)| Tracking::new(j, *f));
        instance.targets = targets.collect();
        // From rest: what it had of velocity is no part of the answer.
        instance.set_state(instance.state.clone());
        simulation.step_blocking()?;
    }
    Ok(simulation.instances()[0].state.clone())
}

/// The body in a pose, a ball in its belly.
fn contact(runner: &Runner, page: &mut Page) -> Result<()> {
    let scene = runner.scene("posed_contact")?;
    let avatar = runner.avatar_of(&scene)?;
    let run = runner.play(&scene, &avatar)?;
    page.text(
        "In a pose that the blend shapes serve (the arms are bent), a ball is pushed into the belly. The dent is in \
         the unposed shape (inset) as in the posed one, and the spine gives way: the contact acts on bones and tissue.",
    );
    page.picture(
        "contact",
        runner.strip(&scene, &avatar, &run),
        "a posed contact; insets: the unposed shape",
    );
    let r = &run.report;
    page.check(
        "contact: unposed displacement",
        r.full_press_displacement_mm,
        "mm",
        Bound::AtLeast(5.0),
    );
    page.check(
        "contact: force",
        r.contact_force_n,
        "N",
        Bound::AtLeast(1.0),
    );
    let chest = avatar.skeleton.find("spine3").unwrap_or(0);
    let states = &run.recording.states;
    let (first, pressed) = (
        &states[scene.step_at(scene.measure.settled)],
        &states[scene.step_at(scene.measure.full_press)],
    );
    let (way, _) = first.frames[chest].motion_to(&pressed.frames[chest]);
    page.check(
        "contact: the chest gives way",
        1e3 * way.length(),
        "mm",
        Bound::AtLeast(0.5),
    );
    page.check_intact(", contact", r);
    Ok(())
}
