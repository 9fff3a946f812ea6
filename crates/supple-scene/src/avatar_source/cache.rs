//! Bakes kept in a folder, so that none is made twice.

use super::{AvatarSource, read_avatar_source};
use crate::fingerprint::Fingerprint;
use std::path::Path;
use supple::file::read_avatar;
use supple::model::Avatar;
use supple::{Error, Result};
use supple_bake::{bake, write_baked};

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
    if let AvatarSource::Baked(path) = source {
        return read_avatar(path);
    }
    let path = cache.join(format!("{}.supple", fingerprint(source)?));
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
fn fingerprint(source: &AvatarSource) -> Result<Fingerprint> {
    let mut hash = Fingerprint::new();
    add_source(source, &mut hash)?;
    Ok(hash)
}

fn add_source(source: &AvatarSource, hash: &mut Fingerprint) -> Result<()> {
    hash.add_json("avatar", source)?;
    (source.files().into_iter()).try_for_each(|path| hash.add_file(path))?;
    match source {
        AvatarSource::Recipe(path) => add_source(&read_avatar_source(path)?, hash),
        _ => Ok(()),
    }
}
