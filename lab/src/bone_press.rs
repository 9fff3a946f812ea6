//! The bone press benchmark: what a reduced model makes of a deep, narrow press, and what it costs.

mod modes;

use super::press::{Pressed, limb_recipe, press, press_full_space, relative_error};
use super::{Bound, Figure, Page, Runner};
use glam::DVec3;
use std::sync::Arc;
use supple::Result;
use supple::collider::{Collider, Shape};
use supple::internal::cpu::{min_det_f, skin_displacement};
use supple::model::{Avatar, Frame, Integrator, State};
use supple::potential::CpuPotential;
use supple::sim::{Pin, Settings, Simulation, SolverMode};
use supple_bake::{HandleCandidates, HandleRegion, Recipe, Truncation, bake};
use supple_pictures::Curves;
use supple_samples::Limb;
use supple_scene::{Scene, SceneRun};

/// See [`draw`].
pub const FIGURE: Figure = Figure {
    name: "bone_press",
    title: "Bone press: error, time and handles",
    paper: "",
    draw,
};

/// m; the published forces are those of the last three.
const DEPTHS: [f64; 4] = [0.003, 0.006, 0.009, 0.012];
/// N, of the converged full-space solution on mesh S at 6, 9 and 12 mm.
const PUBLISHED_FORCES: [f64; 3] = [4.3, 9.1, 15.9];

/// The benchmark's coefficient.
const FRICTION: f64 = 0.5;

/// Other engines on this benchmark, on four shared CPU cores, as published with it.
const OTHERS: [[&str; 3]; 5] = [
    [
        "MuJoCo 4 flex",
        "M",
        "99 ms; on S 12 ms, where it diverges under full press",
    ],
    ["Rapier 0.36 soft bodies", "M", "259 to 290 ms"],
    ["Rapier 0.36 soft bodies", "S", "27 to 37 ms, 30 % error"],
    ["Newton 1.8 VBD", "M", "467 ms, 57 % error"],
    [
        "Newton 1.8 VBD",
        "S",
        "122 to 219 ms, 7 % error at the latter",
    ],
];

/// The sphere's way over the limb, to one and a half of its dents' radius: lowest and highest corner, m.
const REGION: [[f64; 3]; 2] = [[0.06, -0.037, -0.002], [0.18, 0.037, 0.045]];

fn draw(runner: &Runner) -> Result<Page> {
    let mut page = Page::new(
        "A sphere of 3 cm presses 12 mm into a soft limb around a bone, slides 4 cm along it and lets go. Error is \
         that of the skin's displacement at full press against the full space (every node free, solved to \
         convergence), relative, L2. The committed scenes and their full space are played with a friction of 0.5, as the benchmark has it; time, error and \
         smallest det F of a line are of one run. Handles inside the volume and how much of the basis is kept \
         decide it.",
    );
    let mut lines = Vec::new();
    let meshes: &[(&str, Limb, &[&str])] = runner.pick(
        &[("S", Limb::S, &["bone_press_s"])],
        &[
            ("S", Limb::S, &["bone_press_s"]),
            ("M", Limb::M, &["bone_press_m", "bone_press_m_82"]),
        ],
    );
    for (name, limb, scenes) in meshes {
        let mesh = Mesh::new(runner, name, *limb, scenes[0])?;
        lines.push(mesh.full_space_line());
        mesh.study(&mut page)?;
        for (k, scene) in scenes.iter().enumerate() {
            lines.push(mesh.committed(&mut page, scene, k == 0)?);
        }
    }
    lines.extend(OTHERS.map(|[engine, mesh, result]| {
        let mut line = vec![mesh.to_string(), engine.to_string()];
        line.extend(["–", "–", result, "–", "–", "–"].map(String::from));
        line
    }));
    page.table(
        "The committed scenes, the full space, and other engines on the same benchmark (as published with it)",
        &[
            "mesh",
            "what",
            "handles",
            "error",
            "ms a step in contact, median",
            "force at 12 mm (N)",
            "smallest det F",
            "residual (mm)",
        ],
        lines,
    );
    Ok(page)
}

/// A mesh with its truth.
struct Mesh<'a> {
    runner: &'a Runner,
    name: &'a str,
    limb: Limb,
    /// In equilibrium without friction, at [`DEPTHS`].
    truth: Pressed,
    /// The full space played with friction, in the gallery.
    played: Option<SceneRun>,
}

impl<'a> Mesh<'a> {
    fn new(runner: &'a Runner, name: &'a str, limb: Limb, scene: &str) -> Result<Self> {
        let mut scene = rough(runner.scene(scene)?);
        let avatar = runner.avatar_of(&scene)?;
        let truth = press_full_space(&avatar, &DEPTHS)?;
        let mut played = None;
        if !runner.small() {
            scene.name = format!("bone_press_{}", name.to_lowercase());
            scene.steps = scene.step_at(scene.measure.full_press);
            scene.settings.solver = SolverMode::Converged {
                tolerance: 1e-7,
                max_iterations: 100,
            };
            scene.output.panels.truncate(2);
            scene.output.record_every = scene.steps;
            played = Some(runner.play_full_space(&scene, &avatar)?.1);
        }
        Ok(Self {
            runner,
            name,
            limb,
            truth,
            played,
        })
    }

    /// The converged skin at full press with friction, where it was played.
    fn skin(&self) -> Option<&[DVec3]> {
        let last = self.played.as_ref().and_then(|run| run.snapshots.last());
        last.map(|shot| &shot.displacement[..])
    }

    fn full_space_line(&self) -> Vec<String> {
        let report = self.played.as_ref().map(|run| &run.report);
        let told = |f: fn(&supple_scene::Report) -> String| report.map_or("–".into(), f);
        vec![
            self.name.into(),
            "full space, converged".into(),
            told(|r| r.handles.to_string()),
            "0 %".into(),
            told(|r| format!("{:.0}", r.ms_per_step_in_contact.median)),
            format!("{:.2}", self.truth.force()),
            told(|r| format!("{:.3}", r.det_f())),
            "–".into(),
        ]
    }

    /// Error, force and time over the number of handles, in equilibrium.
    fn study(&self, page: &mut Page) -> Result<()> {
        let name = self.name;
        let counts: &[usize] = self.runner.pick(&[40, 120][..], &[40, 82, 160, 320][..]);
        let axes = |y| Curves::new(&format!("Mesh {name}"), "handles", y);
        let mut errors = axes("error (%)");
        let mut times = axes("ms a step at full press").logarithmic();
        let mut forces = Curves::new(&format!("Mesh {name}"), "depth (mm)", "force (N)");
        let of = |p: &Pressed| {
            DEPTHS
                .map(|d| 1e3 * d)
                .into_iter()
                .zip(p.forces.clone())
                .collect::<Vec<_>>()
        };
        forces = forces.dots("full space", of(&self.truth));
        if name == "S" {
            let published = [6.0, 9.0, 12.0].into_iter().zip(PUBLISHED_FORCES);
            forces = forces.dots("published", published);
            for (force, published) in self.truth.forces[1..].iter().zip(PUBLISHED_FORCES) {
                page.check(
                    format!("full space, where {published} N are published"),
                    *force,
                    "N",
                    Bound::Within(0.95 * published, 1.05 * published),
                );
            }
        }
        let mut rows = Vec::new();
        for candidates in [HandleCandidates::Skin, HandleCandidates::Volume] {
            for truncation in [Truncation::default(), LOOSE, Truncation::OFF] {
                let of_candidates = match candidates {
                    HandleCandidates::Skin => "skin",
                    _ => "volume",
                };
                let line = format!("{of_candidates}, {}", kept(truncation));
                let (mut of_error, mut of_time) = (Vec::new(), Vec::new());
                for &count in counts {
                    // Whole columns at hundreds of handles are seconds a step.
                    if truncation == Truncation::OFF && count > 160 {
                        continue;
                    }
                    let avatar = self.reduced(candidates, count, truncation)?;
                    let pressed = press(&avatar, &DEPTHS)?;
                    let error = 100.0 * pressed.relative_error(&self.truth);
                    let ms = step_ms(&avatar, &pressed.state)?;
                    of_error.push((count as f64, error));
                    of_time.push((count as f64, ms));
                    rows.push(vec![
                        count.to_string(),
                        of_candidates.into(),
                        kept(truncation).into(),
                        format!("{error:.1} %"),
                        format!("{ms:.2}"),
                        format!("{:.2}", pressed.force()),
                        format!("{:.3}", min_det_f(&avatar, &pressed.state)),
                    ]);
                }
                if candidates == HandleCandidates::Volume {
                    let [first, last] = [of_error[0].1, of_error[of_error.len() - 1].1];
                    page.check(
                        format!("{name}: error of the most handles over the fewest, {line}"),
                        last / first,
                        "",
                        Bound::AtMost(0.9),
                    );
                }
                errors = errors.dots(&line, of_error);
                times = times.dots(&line, of_time);
            }
        }
        page.curves(errors);
        page.curves(times);
        page.curves(forces);
        page.table(
            &format!(
                "Mesh {name} in equilibrium, one spacing of handles over the sphere's whole way; time of one \
                 iteration a step"
            ),
            &["handles", "where", "basis", "error", "ms a step", "force (N)", "smallest det F"],
            rows,
        );
        Ok(())
    }

    fn reduced(
        &self,
        candidates: HandleCandidates,
        count: usize,
        truncation: Truncation,
    ) -> Result<Arc<Avatar>> {
        let few = count / 5;
        let within = HandleRegion {
            candidates,
            within: Some(REGION),
            count: Some(count - few),
            ..HandleRegion::default()
        };
        let elsewhere = HandleRegion {
            candidates,
            count: Some(few),
            ..HandleRegion::default()
        };
        let recipe = Recipe {
            handles: vec![within, elsewhere],
            truncation,
            ..limb_recipe()
        };
        Ok(Arc::new(bake(&self.limb.body()?, &recipe, &mut |_| {})?.0))
    }

    /// A committed scene, played as the benchmark has it: its line of the table. Time, error and det F are of one run.
    /// The accurate one's error is checked.
    fn committed(&self, page: &mut Page, scene: &str, accurate: bool) -> Result<Vec<String>> {
        let mut scene = rough(self.runner.scene(scene)?);
        if self.runner.small() {
            scene.steps = scene.step_at(scene.measure.full_press);
            scene
                .output
                .panels
                .retain(|p| p.time <= scene.measure.full_press);
        }
        let avatar = self.runner.avatar_of(&scene)?;
        let run = self.runner.play(&scene, &avatar)?;
        let at_press = &run.recording.states[scene.step_at(scene.measure.full_press)];
        let displacement = skin_displacement(&avatar, at_press);
        let error = self
            .skin()
            .map(|truth| 100.0 * relative_error(&displacement, truth));
        let told = error.map_or("–".into(), |error| format!("{error:.1} %"));
        let report = &run.report;
        let what = |what: &str| format!("{}: {what}", scene.name);
        if accurate {
            // A test has no run of the full space: its error is that of equilibrium, where there is no friction.
            let error = match error {
                Some(error) => error,
                None => 100.0 * press(&avatar, &DEPTHS)?.relative_error(&self.truth),
            };
            page.check(what("error"), error, "%", Bound::AtMost(10.0));
        }
        page.check(
            what("smallest det F"),
            report.det_f(),
            "",
            Bound::AtLeast(0.0),
        );
        page.check(
            what("penetration"),
            report.max_penetration_mm,
            "mm",
            Bound::AtMost(1.0),
        );
        page.check(
            what("iterations a step"),
            report.iterations,
            "",
            Bound::AtMost(2.0),
        );
        if !self.runner.small() {
            let residual = report.residual_displacement_mm;
            page.check(what("residual"), residual, "mm", Bound::AtMost(1e-3));
            modes::compare(self.runner, page, &scene, &avatar, &run)?;
        }
        page.picture(
            &scene.name,
            self.runner.strip(&scene, &avatar, &run),
            format!(
                "{}: {} handles, error {told}",
                scene.name,
                avatar.handles.len()
            ),
        );
        // From 0.25 to 1.5 s: the benchmark's own measure.
        let timed = scene.step_at(0.25)..scene.step_at(1.5).min(run.steps.len());
        let ms = median(run.steps[timed].iter().map(|s| s.timings.step));
        Ok(vec![
            self.name.into(),
            format!("scene {}", scene.name),
            avatar.handles.len().to_string(),
            told,
            format!("{ms:.2}"),
            format!("{:.2}", report.contact_force_n),
            format!("{:.3}", report.det_f()),
            match self.runner.small() {
                true => "–".into(),
                false => format!("{:.5}", report.residual_displacement_mm),
            },
        ])
    }
}

/// The scene with the benchmark's friction.
fn rough(mut scene: Scene) -> Scene {
    for collider in &mut scene.colliders {
        collider.friction = FRICTION;
    }
    scene
}

/// Less is cut off than by default.
const LOOSE: Truncation = Truncation {
    enabled: true,
    below: 0.005,
    above: 0.02,
    ..Truncation::OFF
};

fn kept(truncation: Truncation) -> &'static str {
    match truncation {
        Truncation { enabled: false, .. } => "whole",
        LOOSE => "little truncated",
        _ => "truncated",
    }
}

/// Median time of a step of one iteration from the pressed state, ms.
fn step_ms(avatar: &Arc<Avatar>, pressed: &State) -> Result<f64> {
    const STEPS: usize = 9;
    let potential = CpuPotential::new(avatar.clone(), 1)?;
    let settings = Settings {
        integrator: Integrator::BackwardEuler,
        solver: SolverMode::OneIteration,
        ..Settings::default()
    };
    let mut simulation = Simulation::new(avatar, potential, settings)?;
    let instance = &mut simulation.instances_mut()[0];
    instance.set_state(pressed.clone());
    let frame = pressed.frames[0];
    instance.pins.push(Pin { bone: 0, frame });
    let ball = Shape::Sphere { radius: 0.03 };
    let at_depth = Frame {
        position: DVec3::new(0.1, 0.0, 0.07 - DEPTHS[DEPTHS.len() - 1]),
        ..Frame::IDENTITY
    };
    instance.colliders.push(Collider::new(ball, at_depth));
    let mut times = Vec::new();
    for _ in 0..STEPS {
        times.push(simulation.step_blocking()?.timings.step);
    }
    Ok(median(times.into_iter()))
}

/// The middle value; 0 of none.
fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut sorted: Vec<f64> = values.collect();
    sorted.sort_by(f64::total_cmp);
    sorted.get(sorted.len() / 2).copied().unwrap_or(0.0)
}
