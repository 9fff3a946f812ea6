//! Maps painted on a skin, as the recipes of [`crate::load::AvatarSource`] name them.

use crate::load::npy::encode_f64;
use crate::{Error, Result};
use std::path::Path;

/// Writes a number for each skin vertex to a `.npy` file.
///
/// # Errors
/// [`Error::Io`].
pub fn write_painted(map: &[f64], path: impl AsRef<Path>) -> Result<()> {
    let path = path.as_ref();
    std::fs::write(path, encode_f64(&[map.len()], map)).map_err(|e| Error::io(path, e))
}
