//! What evaluates the potential, and a scene played on it.

use super::terminal::{bar, tell};
use std::sync::Arc;
use supple::gpu::{AdapterChoice, GpuDevice};
use supple::model::Avatar;
use supple::potential::{CpuPotential, GpuOptions, GpuPotential, Potential};
use supple::sim::{Settings, Simulation};
use supple::{Error, GpuError, Result};
use supple_files::Series;
use supple_scene::{Breakdown, Scene, SceneRun, run_scene, run_scene_as_series};

/// What evaluates the potential.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Backend {
    /// A real GPU, else (where allowed) a software one, else the CPU.
    Auto,
    /// A GPU, or an error.
    Gpu,
    /// The f64 evaluation.
    Cpu,
}

/// Which backend a command takes.
#[derive(clap::Args)]
pub struct BackendFlags {
    /// What evaluates the potential.
    #[arg(long, value_enum, default_value = "auto")]
    pub backend: Backend,
    /// Let a software adapter stand in for a GPU.
    #[arg(long)]
    pub allow_software: bool,
}

impl BackendFlags {
    /// Plays `scene`, and says on stderr on which backend; every step is kept in `series` where one is asked for. Returns the
    /// avatar that the run is of as well: on the CPU it has room for fine handles.
    pub fn simulate(
        &self,
        scene: &Scene,
        avatar: Avatar,
        series: Option<&mut Series>,
    ) -> Result<(Arc<Avatar>, SceneRun)> {
        if let Some(gpu) = self.open_gpu()? {
            tell(format_args!(
                "backend: gpu, {} ({})",
                gpu.adapter.name, gpu.adapter.backend
            ));
            let options = GpuOptions {
                colliders: scene.collider_count().max(1),
                ..GpuOptions::default()
            };
            if !avatar.fine.is_empty() && scene.settings.fine_handles > 0 {
                tell(format_args!(
                    "note: fine handles sleep on the GPU; --backend cpu wakes them"
                ));
            }
            let avatar = Arc::new(avatar);
            let (device, queue) = (&gpu.device, &gpu.queue);
            let potential = GpuPotential::new(device, queue, avatar.clone(), 1, options)?;
            let mut simulation = Simulation::new(&avatar, potential, scene.settings)?;
            let mut run = play(scene, &avatar, &mut simulation, series)?;
            time_stages(simulation.potential_mut(), &mut run.report.breakdown_ms)?;
            run.report.backend = "gpu".into();
            return Ok((avatar, run));
        }
        let (asked, baked) = (scene.settings.fine_handles, avatar.fine.len());
        if asked > baked && asked != Settings::default().fine_handles {
            tell(format_args!(
                "note: fine_handles = {asked}, but the avatar was baked with {baked}"
            ));
        }
        let avatar = Arc::new(avatar.with_fine_slots(asked)?);
        let potential = CpuPotential::new(avatar.clone(), 1)?;
        tell(format_args!("backend: cpu{}", self.why_cpu()));
        let mut simulation = Simulation::new(&avatar, potential, scene.settings)?;
        let mut run = play(scene, &avatar, &mut simulation, series)?;
        run.report.backend = "cpu".into();
        Ok((avatar, run))
    }

    /// Why the CPU was taken where nobody asked for it.
    fn why_cpu(&self) -> &'static str {
        match self.backend {
            Backend::Auto => " (no hardware GPU was found; --allow-software takes a software one)",
            _ => "",
        }
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
    series: Option<&mut Series>,
) -> Result<SceneRun> {
    let bar = bar(scene.steps, &scene.name);
    let mut progress = |step: usize| bar.set_position(step as u64);
    let run = match series {
        None => run_scene(scene, avatar, simulation, &mut progress),
        Some(series) => {
            run_scene_as_series(scene, avatar, simulation, &mut progress).map(|(run, recorded)| {
                *series = recorded;
                run
            })
        }
    };
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
