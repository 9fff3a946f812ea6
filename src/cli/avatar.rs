//! Avatars of scenes: read where they are baked, baked once where they are not.

use super::{make_folder, progress};
use crate::bake::{bake, read_avatar, write_baked};
use crate::load::{AvatarSource, read_avatar_source};
use crate::model::Avatar;
use crate::{Error, Result};
use std::path::Path;

/// The avatar of `source`. A bake is kept in `cache` under a name made from everything it depends on.
pub fn load(source: &AvatarSource, cache: &Path) -> Result<Avatar> {
    if let Some(path) = &source.file {
        return read_avatar(path);
    }
    let path = cache.join(format!("{:016x}.supple", fingerprint(source)?));
    if path.exists() {
        match read_avatar(&path) {
            Ok(avatar) => return Ok(avatar),
            Err(e) => eprintln!("baking again: {e}"),
        }
    }
    make_folder(cache)?;
    let (body, recipe) = source.body()?;
    let (avatar, report) = bake(&body, &recipe, &mut progress::baking(&body.name))?;
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
