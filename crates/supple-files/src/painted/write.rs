//! Maps painted on a skin, as the recipes of [`supple_scene::AvatarSource`] name them.

use crate::npy::encode_f64;
use std::path::Path;
use supple::{Error, Result};

/// Writes a number for each skin vertex to a `.npy` file.
///
/// # Errors
/// [`Error::Io`].
pub fn write_painted(map: &[f64], path: impl AsRef<Path>) -> Result<()> {
    let path = path.as_ref();
    std::fs::write(path, encode_f64(&[map.len()], map)).map_err(|e| Error::io(path, e))
}
