//! `supple play`.

use super::backend::BackendFlags;
use super::body_flags::BodyFlags;
use super::glb_flags::GlbFlags;
use super::make_folder;
use super::motion_flags::{MotionFlags, from_file};
use super::simulate::tell_motion;
use super::simulate_report::{print_play, warn_of_the_implausible};
use super::terminal::{baking_if_needed, bar, print, print_json, tell, to_json};
use serde::Serialize;
use std::path::{Path, PathBuf};
use supple::Result;
use supple::internal::write_whole;
use supple::model::Avatar;
use supple_pictures::picture_animation;
use supple_scene::{Report, Scene, SceneRun, Showing, load_avatar, own_clip};

/// Arguments of `supple play`.
#[derive(clap::Args)]
pub struct Arguments {
    /// A character (.glb, .gltf, .vrm, .npz, .pkl, .obj, tets), a baked file, or a recipe.
    file: PathBuf,
    #[command(flatten)]
    body: BodyFlags,
    /// A motion to follow in place of the character's own: .bvh, .npz (AMASS), .glb, .vrma, .jsonl, .js;
    /// `-` reads poses as JSON lines from standard input.
    #[arg(long, value_name = "FILE")]
    motion: Option<PathBuf>,
    #[command(flatten)]
    of_motion: MotionFlags,
    /// How long [default: the clip, 8 s at most].
    #[arg(long)]
    seconds: Option<f64>,
    #[command(flatten)]
    glb: GlbFlags,
    #[command(flatten)]
    backend: BackendFlags,
    /// No animated picture: only the GLB file and the report.
    #[arg(long)]
    no_pictures: bool,
    /// Write the report to stdout as JSON.
    #[arg(long)]
    json: bool,
    /// Where results go [default: out/<FILE>.play].
    #[arg(short, long)]
    output: Option<PathBuf>,
    /// Where bakes are kept.
    #[arg(long, default_value = "out/cache")]
    cache: PathBuf,
}

/// What is told of it.
#[derive(Serialize)]
struct Told<'a> {
    showing: &'a Showing,
    #[serde(flatten)]
    report: &'a Report,
}

impl Arguments {
    /// Bakes if needed, plays, and writes `play.png`, `avatar.glb` and `report.json`.
    pub fn run(self) -> Result<()> {
        let source = self.body.source(&self.file)?;
        let (own, note) = own_clip(&source)?;
        if let Some(note) = note {
            tell(format_args!("note: {note}"));
        }
        let motion = from_file(own, self.motion.as_ref());
        let motion = self.of_motion.apply(motion)?;
        let stem = self.file.file_stem().unwrap_or_default().to_string_lossy();
        let mut scene = Scene::of_avatar(&stem, source);
        let avatar = load_avatar(&scene.avatar, &self.cache, &mut baking_if_needed())?;
        let showing = scene.show(&avatar, motion, self.seconds)?;
        tell(format_args!("{stem}: {showing}"));
        let (avatar, run) = self.backend.simulate(&scene, avatar, None)?;
        tell_motion(&run);
        let folder = self.output.clone();
        let folder =
            folder.unwrap_or_else(|| Path::new("out").join(format!("{}.play", scene.name)));
        make_folder(&folder)?;
        self.glb.write(&avatar, &run.recording, &folder)?;
        let told = Told {
            showing: &showing,
            report: &run.report,
        };
        write_whole(folder.join("report.json"), to_json(&told)?)?;
        warn_of_the_implausible(&run.report);
        // Last: it takes longest, and all else is there by then.
        if !self.no_pictures {
            draw(&scene, &avatar, &run, &folder.join("play.png"))?;
        }
        if self.json {
            return print_json(&told);
        }
        print_play(&run.report);
        let folder = folder.display();
        if !self.no_pictures {
            print(format_args!("\n{folder}/play.png moves in a browser"));
        }
        print(format_args!(
            "{folder}/avatar.glb opens in any viewer of glTF"
        ));
        Ok(())
    }
}

fn draw(scene: &Scene, avatar: &Avatar, run: &SceneRun, path: &Path) -> Result<()> {
    let frame_time = match &scene.output.panels[..] {
        [first, second, ..] => second.time - first.time,
        _ => 1.0,
    };
    let count = run.snapshots.len();
    tell(format_args!("drawing {count} pictures"));
    let bar = bar(count, "drawing");
    let mut progress = |drawn| bar.set_position(drawn as u64);
    let animation = picture_animation(scene, avatar, &run.snapshots, frame_time, &mut progress);
    bar.finish_and_clear();
    animation.write_png(path)
}
