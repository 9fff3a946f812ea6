//! Maps painted on a skin, as the recipes of [`supple_scene::AvatarSource`] name them.

use crate::npy::encode_f64;
use std::path::Path;
use supple::Result;
use supple::internal::write_whole;

/// Writes a number for each skin vertex to a `.npy` file.
///
/// # Errors
/// [`supple::Error::Io`].
pub fn write_painted(map: &[f64], path: impl AsRef<Path>) -> Result<()> {
    write_whole(path, encode_f64(&[map.len()], map))
}
