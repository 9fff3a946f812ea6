//! What a press does with every node free, kept from run to run.
//!
//! A kept state is where Newton's method starts, not what is believed: it is iterated until it converges again, which takes one
//! iteration or two where it holds still.

use super::presses::Press;
use crate::press::{Pressed, press_full_space_along};
use glam::DVec3;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use supple::internal::write_whole;
use supple::model::{Avatar, State};
use supple::{Error, Result};

/// The press in the full space, and the smallest det F over all tets.
#[derive(Clone, Debug)]
pub struct Truth {
    pub pressed: Pressed,
    pub min_det_f: f64,
}

#[derive(Serialize, Deserialize)]
struct Kept {
    handles: Vec<DVec3>,
}

/// The truth of `press` on `avatar`, in ten load steps from rest or in one from what the folder `cache` keeps.
///
/// # Errors
/// Whatever a step says; [`Error::Io`] of the folder.
pub fn truth(avatar: &Avatar, press: &Press, cache: &Path) -> Result<Truth> {
    let path = kept_at(avatar, press, cache)?;
    let kept = std::fs::read(&path)
        .ok()
        .and_then(|bytes| serde_json::from_slice::<Kept>(&bytes).ok());
    let start = kept.map(|kept| State {
        frames: avatar.rest_state().frames,
        handles: kept.handles,
        awake: Vec::new(),
    });
    let frames = press.frames();
    let frames = match start {
        Some(_) => &frames[frames.len() - 1..],
        None => &frames[..],
    };
    let (pressed, min_det_f) =
        press_full_space_along(avatar, press.shape(), frames, start.as_ref())?;
    if start.is_none() {
        let folder = path.parent().unwrap_or(Path::new(""));
        std::fs::create_dir_all(folder).map_err(|e| Error::io(folder, e))?;
        let kept = Kept {
            handles: pressed.state.handles.clone(),
        };
        let json = serde_json::to_vec(&kept)
            .map_err(|e| Error::invalid("truth", format!("cannot be written: {e}")))?;
        write_whole(&path, json)?;
    }
    Ok(Truth { pressed, min_det_f })
}

/// The file of a press: FNV-1a (Fowler, Noll, Vo 1991) of all that it depends on but the program.
fn kept_at(avatar: &Avatar, press: &Press, cache: &Path) -> Result<PathBuf> {
    let layer = &avatar.layer;
    let shape = (&layer.mesh, &layer.tissue_fraction, &layer.bone_of_node);
    let tissue = (&avatar.material, &layer.tissue, avatar.density);
    let text = serde_json::to_string(&(shape, &layer.skin_embedding, tissue, press))
        .map_err(|e| Error::invalid("press", format!("cannot be written: {e}")))?;
    let hash = text.bytes().fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x100_0000_01b3)
    });
    Ok(cache.join("presses").join(format!("{hash:016x}.json")))
}
