//! A character that is ready to be shown: baked, with its scene, its paint, and what is looked up once.

use super::request::Request;
use crate::draw::Look;
use glam::DVec3;
use std::path::Path;
use std::sync::Arc;
use supple::Result;
use supple::file::read_avatar;
use supple::model::Avatar;
use supple_bake::bake;
use supple_bake::math::NearestPoint;
use supple_pictures::tissue_depths;
use supple_scene::{AvatarSource, Playback, Scene, TrackedMotion, load_avatar, own_clip};

/// A character and what happens to it.
#[derive(Debug)]
pub struct Character {
    /// What it is called.
    pub name: String,
    /// It, dressed for its scene; rigid bodies are not in it.
    pub avatar: Arc<Avatar>,
    /// What drives and touches it.
    pub scene: Scene,
    /// What happens, as a sentence.
    pub does: String,
    /// When it begins again, s; of a clip that repeats it is none.
    pub round: Option<f64>,
    /// Whether it then goes on from where it is, as one that sways does; a scene is put back to its start.
    pub sways: bool,
    /// How its file paints it.
    pub look: Look,
    /// The skin vertex nearest to each handle.
    pub handles: Vec<u32>,
    /// Depth of the tissue under each skin vertex, m.
    pub depths: Vec<f64>,
    /// What is to be known of it, a sentence each.
    pub notes: Vec<String>,
}

impl Character {
    /// Reads, bakes, with `fine` handles if they are asked for, and prepares; `progress` hears the phases of a bake.
    ///
    /// # Errors
    /// What reading and baking say, with file, field and cure.
    pub fn load(
        request: &Request,
        fine: bool,
        cache: Option<&Path>,
        progress: &mut dyn FnMut(usize),
    ) -> Result<Self> {
        let (mut source, scene) = request.source()?;
        if fine && source.body_source().is_some() {
            source.set_fine_handles()?;
        }
        let mut avatar = avatar_of(&source, cache, progress).map_err(|e| match request {
            Request::File(path) => e.of_file(path),
            _ => e,
        })?;
        let mut notes = Vec::new();
        let name = request.name();
        let (mut scene, own) = match scene {
            Some(mut scene) => {
                let own = !scene.is_idle();
                notes.extend(let_go(&mut scene));
                let bodies = std::mem::take(&mut scene.bodies);
                scene.dress(&mut avatar)?;
                (Scene { bodies, ..scene }, own)
            }
            None => (Scene::of_avatar(&name, source.clone()), false),
        };
        let (does, round) = match (own, request.motion()) {
            (true, _) => (format!("scene {}", scene.name), Some(scene.duration())),
            (false, Some(motion)) => {
                let round = play(&mut scene, &avatar, TrackedMotion::of_file(motion))?;
                let file = motion.file_name().unwrap_or_default().to_string_lossy();
                (format!("follows {file}"), round)
            }
            (false, None) => {
                let (clip, note) = own_clip(&source)?;
                notes.extend(note);
                show(&mut scene, &avatar, clip, &mut notes)
            }
        };
        let places = &avatar.skin.position;
        let search = NearestPoint::new(places);
        let nearest = |handle: &DVec3| search.nearest(*handle).map_or(0, |(v, _)| v);
        Ok(Self {
            look: Look::new(&avatar.appearance),
            handles: avatar.handles.iter().map(nearest).collect(),
            depths: tissue_depths(&avatar, places),
            avatar: Arc::new(avatar),
            name,
            sways: scene.motion.is_none() && !own,
            scene,
            does,
            round,
            notes,
        })
    }
}

/// The avatar of a source, from the cache where it is there.
fn avatar_of(
    source: &AvatarSource,
    cache: Option<&Path>,
    progress: &mut dyn FnMut(usize),
) -> Result<Avatar> {
    match (source, cache) {
        (AvatarSource::Baked(path), _) => read_avatar(path),
        (_, Some(cache)) => load_avatar(source, cache, &mut |_, phase| progress(phase)),
        (_, None) => {
            let (body, recipe) = source.body()?;
            Ok(bake(&body, &recipe, progress)?.0)
        }
    }
}

/// Lets it play its clip, or stand: what it does, and when it begins again, s.
fn show(
    scene: &mut Scene,
    avatar: &Avatar,
    clip: Option<TrackedMotion>,
    notes: &mut Vec<String>,
) -> (String, Option<f64>) {
    let plain = scene.clone();
    match clip.map(|clip| play(scene, avatar, clip)) {
        Some(Ok(round)) => return ("plays its clip".into(), round),
        // A character whose clip is of other bones is shown all the same.
        Some(Err(e)) => notes.push(format!("its clip is left out: {e}")),
        None => {}
    }
    *scene = plain;
    let round = scene.stand(avatar);
    ("stands and sways".into(), Some(round))
}

/// Lets it follow a motion, again and again: without a break where the motion can, else from the start after so many seconds.
fn play(scene: &mut Scene, avatar: &Avatar, motion: TrackedMotion) -> Result<Option<f64>> {
    scene.show(avatar, Some(motion), None)?;
    let mut again = scene.motion.clone();
    again.iter_mut().for_each(|motion| motion.repeat = true);
    let opens = |motion: &TrackedMotion| {
        Playback::open(motion, &avatar.character(), avatar.up, scene.up()).is_ok()
    };
    if again.as_ref().is_some_and(opens) {
        scene.motion = again;
        return Ok(None);
    }
    Ok(Some(scene.duration()))
}

/// Bodies are a world's here, where they move freely: pins and targets of them are left out.
fn let_go(scene: &mut Scene) -> Option<String> {
    let bodies: Vec<String> = scene.bodies.iter().map(|body| body.name.clone()).collect();
    let before = scene.pins.len() + scene.targets.len();
    scene.pins.retain(|pin| !bodies.contains(&pin.bone));
    scene
        .targets
        .retain(|target| !bodies.contains(&target.bone));
    let moved = before != scene.pins.len() + scene.targets.len();
    moved.then(|| format!("bodies move freely here: {}", bodies.join(", ")))
}
