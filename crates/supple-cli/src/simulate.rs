//! `supple simulate`.

use super::backend::{Backend, BackendFlags};
use super::glb_flags::GlbFlags;
use super::make_folder;
use super::motion_flags::{MotionFlags, from_file};
use super::simulate_report::{print_report, warn_of_the_implausible};
use super::terminal::{baking_if_needed, bar, print, print_json, tell, to_json};
use std::path::{Path, PathBuf};
use supple::internal::write_whole;
use supple::model::Avatar;
use supple::{Error, Result};
use supple_files::{Series, write_series};
use supple_pictures::picture_strip;
use supple_scene::{
    FullSpaceRun, Scene, SceneRun, committed_scenes, load_avatar, read_scene, run_full_space,
    unpack_scenes,
};

/// Arguments of `supple simulate`.
#[derive(clap::Args)]
pub struct Arguments {
    /// A scene file, or the name of a scene that comes with the program: hand_press, body_walk, …
    scene: PathBuf,
    #[command(flatten)]
    backend: BackendFlags,
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
    #[command(flatten)]
    of_motion: MotionFlags,
    #[command(flatten)]
    glb: GlbFlags,
    /// Keep every step as NumPy arrays: time, vertices, displacement, contact_force, loads, energies.
    #[arg(long, value_name = "FILE.npz", conflicts_with = "full_space")]
    series: Option<PathBuf>,
    /// Only the report: no pictures, no GLB file.
    #[arg(long)]
    no_pictures: bool,
}

impl Arguments {
    /// Simulates and writes `strip.png`, `avatar.glb` and `report.json`.
    pub fn run(self) -> Result<()> {
        if self.full_space && self.backend.backend == Backend::Gpu {
            let problem = "the full space is solved on the CPU; leave --backend gpu out";
            return Err(Error::invalid("--full-space", problem));
        }
        let mut scene = read_scene(committed_or_file(&self.scene, &self.cache)?)?;
        let motion = from_file(scene.motion.take(), self.motion.as_ref());
        scene.motion = self.of_motion.apply(motion)?;
        let mut avatar = load_avatar(&scene.avatar, &self.cache, &mut baking_if_needed())?;
        if scene.is_idle() {
            let showing = scene.show(&avatar, None, Some(scene.duration()))?;
            tell(format_args!(
                "note: the scene has neither pins, targets, a motion, colliders nor bodies: {showing}"
            ));
        }
        scene.dress(&mut avatar)?;
        // Found out now, not after the run.
        if let Some(folder) = self.series.as_ref().and_then(|path| path.parent()) {
            make_folder(folder)?;
        }
        let mut series = self.series.is_some().then(Series::default);
        scene.settings.report_at_end |= series.is_some();
        let (avatar, run) = if self.full_space {
            let FullSpaceRun {
                avatar, mut run, ..
            } = self.solve_full_space(&scene, &avatar)?;
            run.report.backend = "cpu, full space".into();
            (avatar, run)
        } else {
            self.backend.simulate(&scene, avatar, series.as_mut())?
        };
        tell_motion(&run);
        let folder = self
            .output
            .clone()
            .unwrap_or_else(|| Path::new("out").join(&scene.name));
        make_folder(&folder)?;
        if let (Some(series), Some(path)) = (&series, &self.series) {
            write_series(series, path)?;
        }
        if !self.no_pictures {
            picture_strip(&scene, &avatar, &run.snapshots).write_png(&folder.join("strip.png"))?;
            self.glb.write(&avatar, &run.recording, &folder)?;
        }
        write_whole(folder.join("report.json"), to_json(&run.report)?)?;
        warn_of_the_implausible(&run.report);
        if self.json {
            return print_json(&run.report);
        }
        print_report(&run.report);
        print(format_args!("\nwritten to {}", folder.display()));
        if let Some(path) = &self.series {
            print(format_args!("series in {}", path.display()));
        }
        Ok(())
    }

    /// Solves for every node, or takes what an earlier run kept; says on stderr which.
    fn solve_full_space(&self, scene: &Scene, avatar: &Avatar) -> Result<FullSpaceRun> {
        tell(format_args!("backend: cpu, full space"));
        let bar = bar(scene.steps, &scene.name);
        let folder = (!self.no_cache).then_some(&*self.cache);
        let found = run_full_space(scene, avatar, folder, &mut |step| {
            bar.set_position(step as u64);
        });
        bar.finish_and_clear();
        let found = found?;
        if let Some(path) = &found.kept {
            tell(format_args!(
                "kept from an earlier run: {} (--no-cache would solve again)",
                path.display()
            ));
        }
        Ok(found)
    }
}

/// Says on stderr how the motion was taken.
pub fn tell_motion(run: &SceneRun) {
    if let Some(map) = &run.bone_map {
        tell(format_args!("motion: {}", map.summary()));
    }
    for note in &run.report.motion_notes {
        tell(format_args!("motion: {note}"));
    }
}

/// The file of a scene; one that comes with the program is found in any folder, and unpacked below `cache`.
pub(super) fn committed_or_file(scene: &Path, cache: &Path) -> Result<PathBuf> {
    if scene.exists() || scene.extension().is_some() {
        return Ok(scene.into());
    }
    if !committed_scenes().any(|name| scene == Path::new(name)) {
        let names: Vec<&str> = committed_scenes().collect();
        let problem = format!(
            "is no file, nor a scene of the program's: {}",
            names.join(", ")
        );
        return Err(Error::format(scene, "scene", problem));
    }
    let scenes = unpack_scenes(cache)?;
    Ok(scenes.join(scene).with_extension("toml"))
}
