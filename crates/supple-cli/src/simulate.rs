//! `supple simulate`.

use super::make_folder;
use super::terminal::{baking_if_needed, bar, print, print_json, print_table, to_json};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use supple::gpu::{AdapterChoice, GpuDevice};
use supple::model::Avatar;
use supple::potential::{CpuPotential, GpuOptions, GpuPotential, Potential};
use supple::sim::Simulation;
use supple::{Error, GpuError, Result};
use supple_files::write_glb;
use supple_pictures::picture_strip;
use supple_scene::{
    Breakdown, FullSpaceRun, Report, Scene, SceneRun, TrackedMotion, committed_scenes, load_avatar,
    read_scene, run_full_space, run_scene, unpack_scenes,
};

/// What evaluates the potential.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Backend {
    /// A real GPU, else (where allowed) a software one, else the CPU.
    Auto,
    /// A GPU, or an error.
    Gpu,
    /// The f64 evaluation.
    Cpu,
}

/// Arguments of `supple simulate`.
#[derive(clap::Args)]
pub struct Arguments {
    /// A scene file, or the name of a scene that comes with the program: hand_press, body_walk, …
    scene: PathBuf,
    /// What evaluates the potential.
    #[arg(long, value_enum, default_value = "auto")]
    backend: Backend,
    /// Let a software adapter stand in for a GPU.
    #[arg(long)]
    allow_software: bool,
    /// Solve for every node of the soft layer: the reference for accuracy. CPU only.
    #[arg(long, conflicts_with = "allow_software")]
    full_space: bool,
    /// Write the report to stdout as JSON.
    #[arg(long)]
    json: bool,
    /// Where results go [default: out/<scene>].
    #[arg(short, long)]
    output: Option<PathBuf>,
    /// Solve the full space again, and keep nothing of it.
    #[arg(long, requires = "full_space")]
    no_cache: bool,
    /// Where bakes and full-space runs are kept.
    #[arg(long, default_value = "out/cache")]
    cache: PathBuf,
    /// Draw the bones to this motion in place of the scene's own: .bvh, .npz (AMASS), .glb, .jsonl, .js;
    /// `-` reads poses as JSON lines from standard input.
    #[arg(long, value_name = "FILE")]
    motion: Option<PathBuf>,
    /// Frames a second of the motion, in place of what a .bvh or .npz says.
    #[arg(long)]
    rate: Option<f64>,
    /// Only the report: no pictures, no GLB file.
    #[arg(long)]
    no_pictures: bool,
}

impl Arguments {
    /// Simulates and writes `strip.png`, `avatar.glb` and `report.json`.
    pub fn run(self) -> Result<()> {
        if self.full_space && self.backend == Backend::Gpu {
            let problem = "the full space is solved on the CPU; leave --backend gpu out";
            return Err(Error::invalid("--full-space", problem));
        }
        let mut scene = read_scene(self.scene_file()?)?;
        if let Some(file) = &self.motion {
            let file = file.clone();
            scene.motion = Some(match scene.motion.take() {
                Some(motion) => TrackedMotion { file, ..motion },
                None => TrackedMotion::of_file(file),
            });
        }
        if let Some(rate) = self.rate {
            let problem = "is of a motion, and the scene has none: give --motion";
            let motion = scene.motion.as_mut();
            motion
                .ok_or_else(|| Error::invalid("--rate", problem))?
                .rate = Some(rate);
        }
        let mut avatar = load_avatar(&scene.avatar, &self.cache, &mut baking_if_needed())?;
        scene.dress(&mut avatar)?;
        let (avatar, mut run, backend) = if self.full_space {
            let FullSpaceRun { avatar, run, .. } = self.solve_full_space(&scene, &avatar)?;
            (avatar, run, "cpu, full space".into())
        } else {
            let avatar = Arc::new(avatar);
            let (run, backend) = self.simulate(&scene, &avatar)?;
            (avatar, run, backend)
        };
        run.report.backend = backend;
        if let Some(map) = &run.bone_map {
            eprintln!("motion: {}", map.summary());
        }
        for note in &run.report.motion_notes {
            eprintln!("motion: {note}");
        }
        let folder = self
            .output
            .clone()
            .unwrap_or_else(|| Path::new("out").join(&scene.name));
        make_folder(&folder)?;
        if !self.no_pictures {
            picture_strip(&scene, &avatar, &run.snapshots).write_png(&folder.join("strip.png"))?;
            let glb = write_glb(&avatar, &run.recording, folder.join("avatar.glb"))?;
            eprintln!(
                "avatar.glb: {} KiB, {} morphs that miss {:.4} mm at most",
                glb.bytes / 1024,
                glb.morphs,
                1e3 * glb.largest_morph_error
            );
        }
        let path = folder.join("report.json");
        std::fs::write(&path, to_json(&run.report)?).map_err(|e| Error::io(&path, e))?;
        warn_of_the_implausible(&run.report);
        if self.json {
            return print_json(&run.report);
        }
        print_report(&run.report);
        print(format_args!("\nwritten to {}", folder.display()));
        Ok(())
    }

    /// The file of the scene; one that comes with the program is found in any folder.
    fn scene_file(&self) -> Result<PathBuf> {
        if self.scene.exists() || self.scene.extension().is_some() {
            return Ok(self.scene.clone());
        }
        if !committed_scenes().any(|name| self.scene == Path::new(name)) {
            let names: Vec<&str> = committed_scenes().collect();
            let problem = format!(
                "is no file, nor a scene of the program's: {}",
                names.join(", ")
            );
            return Err(Error::format(&self.scene, "scene", problem));
        }
        let scenes = unpack_scenes(&self.cache)?;
        Ok(scenes.join(&self.scene).with_extension("toml"))
    }

    /// Why the CPU was taken where nobody asked for it.
    fn why_cpu(&self) -> &'static str {
        match self.backend {
            Backend::Auto => " (no hardware GPU was found; --allow-software takes a software one)",
            _ => "",
        }
    }

    /// Runs on the chosen backend, and says on stderr which that is.
    fn simulate(&self, scene: &Scene, avatar: &Arc<Avatar>) -> Result<(SceneRun, String)> {
        if let Some(gpu) = self.open_gpu()? {
            eprintln!(
                "backend: gpu, {} ({})",
                gpu.adapter.name, gpu.adapter.backend
            );
            let options = GpuOptions {
                colliders: scene.collider_count().max(1),
                ..GpuOptions::default()
            };
            let (device, queue) = (&gpu.device, &gpu.queue);
            let potential = GpuPotential::new(device, queue, avatar.clone(), 1, options)?;
            let mut simulation = Simulation::new(avatar, potential, scene.settings)?;
            let mut run = play(scene, avatar, &mut simulation)?;
            time_stages(simulation.potential_mut(), &mut run.report.breakdown_ms)?;
            return Ok((run, "gpu".into()));
        }
        let potential = CpuPotential::new(avatar.clone(), 1)?;
        eprintln!("backend: cpu{}", self.why_cpu());
        let mut simulation = Simulation::new(avatar, potential, scene.settings)?;
        Ok((play(scene, avatar, &mut simulation)?, "cpu".into()))
    }

    /// Solves for every node, or takes what an earlier run kept; says on stderr which.
    fn solve_full_space(&self, scene: &Scene, avatar: &Avatar) -> Result<FullSpaceRun> {
        eprintln!("backend: cpu, full space");
        let bar = bar(scene.steps, &scene.name);
        let folder = (!self.no_cache).then_some(&*self.cache);
        let found = run_full_space(scene, avatar, folder, &mut |step| {
            bar.set_position(step as u64);
        });
        bar.finish_and_clear();
        let found = found?;
        if let Some(path) = &found.kept {
            eprintln!(
                "kept from an earlier run: {} (--no-cache would solve again)",
                path.display()
            );
        }
        Ok(found)
    }

    /// The device to run on; `None` means the CPU.
    fn open_gpu(&self) -> Result<Option<GpuDevice>> {
        if self.backend == Backend::Cpu {
            return Ok(None);
        }
        let choice = if self.allow_software {
            AdapterChoice::HardwareElseSoftware
        } else {
            AdapterChoice::Hardware
        };
        match pollster::block_on(GpuDevice::open(choice)) {
            Ok(gpu) => Ok(Some(gpu)),
            Err(Error::Gpu(GpuError::NoAdapter(_))) if self.backend == Backend::Auto => Ok(None),
            Err(e) => Err(e),
        }
    }
}

fn play<P: Potential>(
    scene: &Scene,
    avatar: &Avatar,
    simulation: &mut Simulation<P>,
) -> Result<SceneRun> {
    let bar = bar(scene.steps, &scene.name);
    let run = run_scene(scene, avatar, simulation, &mut |step| {
        bar.set_position(step as u64);
    });
    bar.finish_and_clear();
    run
}

/// Fills in what a step on a GPU cannot tell apart: the cost of its kernels.
fn time_stages(potential: &mut GpuPotential, breakdown: &mut Breakdown) -> Result<()> {
    const REPEATS: usize = 5;
    const HESSIAN: [&str; 2] = ["point_hessian", "hessian"];
    const SKIN: [&str; 3] = ["posed pose_blend", "skin", "normals"];
    let times = pollster::block_on(potential.stage_times(REPEATS))?;
    let submission = times.first().map_or(0.0, |t| t.1);
    breakdown.readback = 1e3 * submission;
    for (name, seconds) in times.iter().skip(1) {
        let ms = 1e3 * (seconds - submission).max(0.0);
        if HESSIAN.contains(name) {
            breakdown.hessian += ms;
        } else if !SKIN.contains(name) {
            breakdown.force += ms;
        }
    }
    Ok(())
}

/// Says on stderr what no body would survive: the run ended, but its results mean little.
fn warn_of_the_implausible(r: &Report) {
    /// Beyond this a joint is torn, mm.
    const TORN: f64 = 10.0;
    if let Some(det) = r.min_det_f.filter(|det| *det <= 0.0) {
        eprintln!(
            "warning: tets were inverted (smallest det F {det:.3}): more handles in the volume, or a gentler press, would help"
        );
    }
    if r.max_joint_gap_mm > TORN {
        eprintln!(
            "warning: a joint came apart by {:.1} mm: a target may be out of reach, or the joint_stiffness too low",
            r.max_joint_gap_mm
        );
    }
}

fn print_report(r: &Report) {
    let ms = &r.breakdown_ms;
    print_table([
        ("backend", format!("{} ({})", r.backend, r.adapter)),
        ("steps", format!("{} of {} s", r.steps, r.time_step)),
        (
            "degrees of freedom",
            format!("{} ({} handles)", r.dofs, r.handles),
        ),
        ("cubature points", r.cubature_points.to_string()),
        (
            "ms a step",
            format!(
                "{:.3} median, {:.3} p95",
                r.ms_per_step.median, r.ms_per_step.p95
            ),
        ),
        (
            "medians of parts",
            format!(
                "evaluation {:.3} (force {:.3}, Hessian {:.3}, readback {:.3}), solve {:.3}, skin {:.3}, \
                 skeleton {:.3}",
                ms.evaluation, ms.force, ms.hessian, ms.readback, ms.solve, ms.skin, ms.skeleton
            ),
        ),
        (
            "smallest det F",
            r.min_det_f
                .map_or("not known: baked without its layer".into(), |det| {
                    format!("{det:.3}")
                }),
        ),
        ("penetration", format!("{:.3} mm", r.max_penetration_mm)),
        ("joint gap", format!("{:.4} mm", r.max_joint_gap_mm)),
        (
            "unposed displacement",
            format!(
                "{:.3} mm at most, {:.3} mm at full press",
                r.max_unposed_displacement_mm, r.full_press_displacement_mm
            ),
        ),
        (
            "residual displacement",
            format!("{:.5} mm", r.residual_displacement_mm),
        ),
    ]);
    if r.first_contact_s.is_some() {
        print_table([
            (
                "at full press",
                format!(
                    "{:.3} N of contact, {:.3} N borne by targets and pins",
                    r.contact_force_n, r.load_n
                ),
            ),
            (
                "ms a step in contact",
                format!("{:.3} median", r.ms_per_step_in_contact.median),
            ),
        ]);
    }
}
