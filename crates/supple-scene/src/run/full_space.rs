//! A scene's full-space run, kept in a folder: it takes minutes to hours, and what is reduced is measured
//! against it again and again.

use super::{SceneRun, run_scene};
use crate::avatar_source::AvatarSource;
use crate::fingerprint::Fingerprint;
use crate::scene::Scene;
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use supple::internal::write_whole;
use supple::model::Avatar;
use supple::potential::{CpuPotential, Potential};
use supple::sim::Simulation;
use supple::{Error, Result};
use supple_bake::SparseCholesky;

/// What [`run_full_space`] gives.
pub struct FullSpaceRun {
    /// The avatar in its full space: its handles are the nodes of the soft layer that no bone holds.
    pub avatar: Arc<Avatar>,
    /// The run, timed when it was made.
    pub run: SceneRun,
    /// The file that it was read from, if an earlier run had been kept.
    pub kept: Option<PathBuf>,
}

/// Plays `scene` with every node of `avatar`'s soft layer solved for: f64, sparse Newton. `avatar` has the tissue that
/// the scene asks for. Where a folder is given, the run is kept there under a name made from everything it depends on:
/// scene, files that the scene names, avatar in its full space, and this program. It is then read where it is there.
///
/// # Errors
/// As [`run_scene`], [`supple_bake::full_space`], [`SparseCholesky::new`]; [`Error::Io`] of the folder. A damaged file is made
/// again.
pub fn run_full_space(
    scene: &Scene,
    avatar: &Avatar,
    folder: Option<&Path>,
    progress: &mut dyn FnMut(usize),
) -> Result<FullSpaceRun> {
    let avatar = Arc::new(supple_bake::full_space(avatar)?);
    let folder = folder.filter(|_| !reads_a_stream(scene));
    let path = match folder {
        Some(folder) => Some(folder.join(format!("{}.run", fingerprint(scene, &avatar)?))),
        None => None,
    };
    if let Some(path) = &path
        && let Some(run) = read(path)
    {
        let kept = Some(path.clone());
        return Ok(FullSpaceRun { avatar, run, kept });
    }
    let potential = CpuPotential::new(avatar.clone(), 1)?;
    let solver = Box::new(SparseCholesky::new(potential.pattern())?);
    let mut simulation = Simulation::with_solver(&avatar, potential, scene.settings, solver)?;
    let run = run_scene(scene, &avatar, &mut simulation, progress)?;
    if let Some(path) = &path {
        write(&run, path)?;
    }
    Ok(FullSpaceRun {
        avatar,
        run,
        kept: None,
    })
}

fn reads_a_stream(scene: &Scene) -> bool {
    let motion = scene.motion.as_ref();
    motion.is_some_and(|motion| motion.file == Path::new("-"))
}

/// A hash of all that the run depends on. Avatars that differ in their reduced basis alone share it.
fn fingerprint(scene: &Scene, avatar: &Avatar) -> Result<Fingerprint> {
    let mut hash = Fingerprint::new();
    let scene = Scene {
        avatar: AvatarSource::Baked(PathBuf::new()),
        ..scene.clone()
    };
    let value = serde_json::to_value(&scene)
        .map_err(|e| Error::invalid("scene", format!("cannot be written: {e}")))?;
    hash.add_json("scene", &value)?;
    add_named_files(&value, &mut hash)?;
    hash.add_binary("avatar", avatar)?;
    Ok(hash)
}

/// Adds the content of every file that a string in `value` names, whichever key it stands under.
fn add_named_files(value: &Value, hash: &mut Fingerprint) -> Result<()> {
    match value {
        Value::String(text) if Path::new(text).is_file() => hash.add_file(Path::new(text)),
        Value::Array(values) => values.iter().try_for_each(|v| add_named_files(v, hash)),
        Value::Object(map) => map.values().try_for_each(|v| add_named_files(v, hash)),
        _ => Ok(()),
    }
}

/// CRC-32 of the payload, the payload (postcard). Written beside it and renamed: a run that is cut off leaves no half
/// file.
fn write(run: &SceneRun, path: &Path) -> Result<()> {
    let payload = postcard::to_allocvec(run)
        .map_err(|e| Error::invalid("run", format!("cannot be written: {e}")))?;
    let mut bytes = crc32fast::hash(&payload).to_le_bytes().to_vec();
    bytes.extend(payload);
    if let Some(folder) = path.parent() {
        fs::create_dir_all(folder).map_err(|e| Error::io(folder, e))?;
    }
    write_whole(path, bytes)
}

/// The run in the file at `path`; none where there is no whole one.
fn read(path: &Path) -> Option<SceneRun> {
    let bytes = fs::read(path).ok()?;
    let (sum, payload) = bytes.split_first_chunk()?;
    let whole = u32::from_le_bytes(*sum) == crc32fast::hash(payload);
    whole.then(|| postcard::from_bytes(payload).ok()).flatten()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::parse_scene;
    use supple::sim::StepReport;
    use supple_bake::{HandleRegion, Recipe, bake};
    use supple_samples::Limb;

    /// A sphere that touches a limb small enough to be solved in an instant.
    const SCENE: &str = r#"
        name = "tiny"
        steps = 4
        [avatar]
        sample = "limb_s"
        [[pins]]
        bone = "bone"
        [[colliders]]
        name = "ball"
        shape = { shape = "sphere", radius = 0.03 }
        motion = { x = [[0.0, 0.1]], z = [[0.0, 0.072], [0.04, 0.060]] }
        [output]
        panels = [{ time = 0.02, caption = "touch" }]
    "#;

    fn limb(handles: usize) -> Avatar {
        let limb = Limb {
            stations: 6,
            layers: 2,
            sectors: 8,
            ..Limb::S
        };
        let recipe = Recipe {
            handles: vec![HandleRegion {
                count: Some(handles),
                ..HandleRegion::default()
            }],
            // By bounce it would follow from the frequency in the reduced tissue, and so from the handles.
            damping_time: Some(0.002),
            ..Recipe::default()
        };
        bake(&limb.body().unwrap(), &recipe, &mut |_| {}).unwrap().0
    }

    #[test]
    fn a_kept_run_is_the_run_and_belongs_to_its_scene_and_avatar() {
        let folder = tempfile::tempdir().unwrap();
        let scene = parse_scene(SCENE, Path::new("tiny.toml")).unwrap();
        let mut steps = 0;
        let mut play = |scene: &Scene, avatar: &Avatar| {
            steps = 0;
            let run = run_full_space(scene, avatar, Some(folder.path()), &mut |s| steps = s);
            (run.unwrap(), steps)
        };
        let avatar = limb(8);
        let (first, made) = play(&scene, &avatar);
        assert!(first.kept.is_none() && made == 4);
        // Touched: so light a tissue may have left the ball again when a step ends.
        let strained = |s: &StepReport| s.instances[0].energies.elastic != 0.0;
        assert!(first.run.steps.iter().any(strained));
        let (again, made) = play(&scene, &avatar);
        assert!(again.kept.is_some() && made == 0);
        assert_eq!(again.run.report, first.run.report);
        assert_eq!(again.run.steps, first.run.steps);
        assert_eq!(again.run.recording.states, first.run.recording.states);
        assert_eq!(again.run.snapshots[0].skin, first.run.snapshots[0].skin);

        // The reduced basis is no part of it; scene and tissue are.
        assert!(play(&scene, &limb(9)).0.kept.is_some());
        let mut other = scene.clone();
        other.colliders[0].stiffness = Some(2e8);
        assert!(play(&other, &avatar).0.kept.is_none());
        let mut denser = avatar.clone();
        denser.density *= 2.0;
        assert!(play(&scene, &denser).0.kept.is_none());

        // A damaged file is made again.
        let path = again.kept.unwrap();
        let mut bytes = fs::read(&path).unwrap();
        let middle = bytes.len() / 2;
        bytes[middle] ^= 1;
        fs::write(&path, bytes).unwrap();
        assert!(play(&scene, &avatar).0.kept.is_none());
        assert!(play(&scene, &avatar).0.kept.is_some());
    }
}
