//! Bakes kept in a folder, so that none is made twice.

use super::{AvatarSource, read_avatar_source};
use crate::bake::{bake, read_avatar, write_baked};
use crate::model::Avatar;
use crate::{Error, Result};
use std::path::Path;

/// The avatar of `source`: read where it is baked, baked once where it is not. A bake is kept in the folder `cache`
/// under a name made from everything it depends on; `progress` hears the body's name and the number of phases done.
///
/// # Errors
/// What reading and baking say, [`Error::Io`] of the folder. A damaged file in it is baked again.
pub fn load_avatar(
    source: &AvatarSource,
    cache: &Path,
    progress: &mut dyn FnMut(&str, usize),
) -> Result<Avatar> {
    if let Some(path) = &source.file {
        return read_avatar(path);
    }
    let path = cache.join(format!("{:016x}.supple", fingerprint(source)?));
    if path.exists()
        && let Ok(avatar) = read_avatar(&path)
    {
        return Ok(avatar);
    }
    std::fs::create_dir_all(cache).map_err(|e| Error::io(cache, e))?;
    let (body, recipe) = source.body()?;
    let name = body.name.clone();
    let (avatar, report) = bake(&body, &recipe, &mut |phase| progress(&name, phase))?;
    // Written beside it and renamed: a bake that is cut off leaves no half file.
    write_baked(&avatar, &report, &path)?;
    Ok(avatar)
}
/// A hash of the source's text, of the files it names, and of this very program.
fn fingerprint(source: &AvatarSource) -> Result<u64> {
    let mut hash = Fnv(0xcbf2_9ce4_8422_2325);
    hash.add(env!("CARGO_PKG_VERSION").as_bytes());
    if let Some(program) = std::env::current_exe().ok().and_then(|p| p.metadata().ok()) {
        hash.add(format!("{} {:?}", program.len(), program.modified().ok()).as_bytes());
    }
    hash.add_source(source)?;
    Ok(hash.0)
}

/// FNV-1a, 64 bits (Fowler, Noll, Vo 1991).
struct Fnv(u64);

impl Fnv {
    fn add(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.0 = (self.0 ^ u64::from(*byte)).wrapping_mul(0x100_0000_01b3);
        }
    }

    fn add_source(&mut self, source: &AvatarSource) -> Result<()> {
        let text = serde_json::to_string(source)
            .map_err(|e| Error::invalid("avatar", format!("cannot be written: {e}")))?;
        self.add(text.as_bytes());
        for path in source.files() {
            self.add(&std::fs::read(path).map_err(|e| Error::io(path, e))?);
        }
        match &source.recipe {
            None => Ok(()),
            Some(path) => self.add_source(&read_avatar_source(path)?),
        }
    }
}
