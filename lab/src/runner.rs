//! What figures are made with: avatars, scenes, runs.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use supple::model::Avatar;
use supple::potential::CpuPotential;
use supple::sim::Simulation;
use supple::{Error, Result};
use supple_pictures::{
    Camera, Image, Legend, Mesh, Panel, Plane, Strip, View, from_srgb, picture_strip, render,
};
use supple_samples::Sample;
use supple_scene::{
    AvatarSource, Scene, SceneRun, load_avatar, read_scene, run_full_space, run_scene,
};

/// How much a figure may cost.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Size {
    /// Seconds and at most 200 steps a scene: a test.
    Small,
    /// Minutes: the gallery.
    Full,
}

/// Which presses are drawn where places are drawn.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SeededPresses {
    /// The same seed draws the same places.
    pub seed: u64,
    /// How many on each body; the figure's own number where it is not given.
    pub count: Option<usize>,
    /// On which bodies: samples by name (`limb_s`, `limb_m`, `hand`, `body`) or characters' files; the figure's own where there
    /// is none.
    pub bodies: Vec<String>,
}

impl Default for SeededPresses {
    fn default() -> Self {
        Self {
            seed: 1,
            count: None,
            bodies: Vec::new(),
        }
    }
}

/// Something that takes a while.
#[derive(Clone, Copy, Debug)]
pub struct Progress<'a> {
    /// What is done: a bake, a scene.
    pub what: &'a str,
    /// Parts that are done.
    pub done: usize,
    /// All parts.
    pub of: usize,
}

/// An avatar, once it is there.
type Slot = Arc<Mutex<Option<Arc<Avatar>>>>;

/// Runs what figures ask for. Figures may be drawn in parallel with one runner.
pub struct Runner {
    /// How much a figure may cost.
    pub size: Size,
    /// Where figures press that draw their places.
    pub presses: SeededPresses,
    scenes: PathBuf,
    cache: PathBuf,
    progress: Box<dyn Fn(Progress<'_>) + Send + Sync>,
    avatars: Mutex<HashMap<String, Slot>>,
}

impl Runner {
    /// A runner that reads scenes from the folder `scenes`, and keeps bakes and long runs in the folder `cache`.
    pub fn new(
        size: Size,
        scenes: impl Into<PathBuf>,
        cache: impl Into<PathBuf>,
        progress: impl Fn(Progress<'_>) + Send + Sync + 'static,
    ) -> Self {
        Self {
            size,
            presses: SeededPresses::default(),
            scenes: scenes.into(),
            cache: cache.into(),
            progress: Box::new(progress),
            avatars: Mutex::default(),
        }
    }

    /// Whether this is a test.
    pub fn small(&self) -> bool {
        self.size == Size::Small
    }

    /// `small` in a test, `full` in the gallery.
    pub fn pick<T>(&self, small: T, full: T) -> T {
        match self.size {
            Size::Small => small,
            Size::Full => full,
        }
    }

    /// Where bakes and long runs are kept.
    pub fn cache(&self) -> &Path {
        &self.cache
    }

    /// Says how far something is.
    pub fn progress(&self, what: &str, done: usize, of: usize) {
        (self.progress)(Progress { what, done, of });
    }

    /// The committed scene `name`, with every step recorded; drawn quickly in a test.
    ///
    /// # Errors
    /// As [`read_scene`].
    pub fn scene(&self, name: &str) -> Result<Scene> {
        let mut scene = read_scene(self.scenes.join(name).with_extension("toml"))?;
        scene.output.record_every = 1;
        scene.output.draft = self.small();
        Ok(scene)
    }

    /// Names of all committed scenes, in order.
    ///
    /// # Errors
    /// [`Error::Io`] where the folder cannot be read.
    pub fn scenes(&self) -> Result<Vec<String>> {
        let entries = std::fs::read_dir(&self.scenes).map_err(|e| Error::io(&self.scenes, e))?;
        let mut names = Vec::new();
        for entry in entries {
            let path = entry.map_err(|e| Error::io(&self.scenes, e))?.path();
            if path.extension().is_some_and(|e| e == "toml") {
                names.extend(path.file_stem().map(|n| n.to_string_lossy().into_owned()));
            }
        }
        names.sort_unstable();
        Ok(names)
    }

    /// The avatar of `source`, baked once for all figures.
    ///
    /// # Errors
    /// As [`load_avatar`].
    pub fn avatar(&self, source: &AvatarSource) -> Result<Arc<Avatar>> {
        let key = serde_json::to_string(source)
            .map_err(|e| Error::invalid("avatar", format!("cannot be written: {e}")))?;
        let slot = unpoisoned(&self.avatars).entry(key).or_default().clone();
        let mut slot = unpoisoned(&slot);
        if let Some(avatar) = &*slot {
            return Ok(avatar.clone());
        }
        let phases = supple_bake::PHASES.len();
        let mut progress =
            |name: &str, phase| self.progress(&format!("baking {name}"), phase, phases);
        let avatar = Arc::new(load_avatar(source, &self.cache, &mut progress)?);
        *slot = Some(avatar.clone());
        Ok(avatar)
    }

    /// A sample baked by its own recipe.
    ///
    /// # Errors
    /// As [`Runner::avatar`].
    pub fn sample(&self, sample: Sample) -> Result<Arc<Avatar>> {
        self.avatar(&AvatarSource::of_sample(sample))
    }

    /// The avatar of `scene`, of the tissue that the scene asks for.
    ///
    /// # Errors
    /// As [`Runner::avatar`].
    pub fn avatar_of(&self, scene: &Scene) -> Result<Arc<Avatar>> {
        let mut avatar = self.avatar(&scene.avatar)?;
        let own = scene.material.is_some() || scene.damping_time.is_some();
        if own || !scene.bodies.is_empty() || !scene.limits.is_empty() {
            scene.dress(Arc::make_mut(&mut avatar))?;
        }
        Ok(avatar)
    }

    /// Plays `scene` with `avatar` by the f64 evaluation.
    ///
    /// # Errors
    /// As [`run_scene`].
    pub fn play(&self, scene: &Scene, avatar: &Arc<Avatar>) -> Result<SceneRun> {
        let potential = CpuPotential::new(avatar.clone(), 1)?;
        let mut simulation = Simulation::new(avatar, potential, scene.settings)?;
        self.run(scene, avatar, &mut simulation)
    }

    /// The same with every node of the soft layer solved for, and the avatar in that space.
    ///
    /// # Errors
    /// As [`run_full_space`].
    pub fn play_full_space(
        &self,
        scene: &Scene,
        avatar: &Arc<Avatar>,
    ) -> Result<(Arc<Avatar>, SceneRun)> {
        let what = format!("{}, full space", scene.name);
        let mut progress = |step| self.progress(&what, step, scene.steps);
        let found = run_full_space(scene, avatar, Some(&self.cache), &mut progress)?;
        Ok((found.avatar, found.run))
    }

    fn run(
        &self,
        scene: &Scene,
        avatar: &Avatar,
        simulation: &mut Simulation<CpuPotential>,
    ) -> Result<SceneRun> {
        run_scene(scene, avatar, simulation, &mut |step| {
            self.progress(&scene.name, step, scene.steps);
        })
    }

    /// A picture of `meshes` of `width` × `height` pixels; a quarter of that in a test.
    pub fn picture(&self, meshes: &[Mesh], camera: Camera, [width, height]: [usize; 2]) -> Image {
        self.opened_picture(meshes, camera, [width, height], None)
    }

    /// The same with the meshes that have a cut colour opened by `clip`.
    pub fn opened_picture(
        &self,
        meshes: &[Mesh],
        camera: Camera,
        [width, height]: [usize; 2],
        clip: Option<Plane>,
    ) -> Image {
        let view = View {
            clip,
            ..match self.size {
                Size::Full => View::new(camera, width, height),
                Size::Small => View::new(camera, width / 4, height / 4).draft(),
            }
        };
        render(meshes, &view)
    }

    /// Panels on one sheet, so many in a row (0: all), over a legend.
    pub fn sheet(&self, panels: Vec<Panel>, columns: usize, legend: Option<Legend>) -> Image {
        let strip = Strip {
            panels,
            columns,
            legend,
            ..Strip::default()
        };
        strip.compose(from_srgb(View::BACKGROUND))
    }

    /// The panels that `scene` asks for, side by side.
    pub fn strip(&self, scene: &Scene, avatar: &Avatar, run: &SceneRun) -> Image {
        picture_strip(scene, avatar, &run.snapshots)
    }
}

/// What a figure that panicked left is as good as before: a slot is written in one go.
fn unpoisoned<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
