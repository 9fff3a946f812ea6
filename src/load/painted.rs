//! Maps painted on a skin, from NumPy files.

use super::arrays::Arrays;
use super::file::read_bytes;
use super::{npy, npz};
use crate::{Error, Result};
use std::path::Path;

/// The numbers of a `.npy` file, or of the array `name` of a `.npz` archive.
///
/// # Errors
/// [`Error::Io`], [`Error::Format`] where it is no such file, no list of numbers, or not finite.
pub(super) fn read_painted(path: &Path, name: &str) -> Result<Vec<f64>> {
    let bytes = read_bytes(path)?;
    let arrays = if npz::is_archive(&bytes) {
        npz::parse(&bytes, path, &[name])?
    } else {
        let mut arrays = Arrays::of_file(path);
        let item = npy::parse(&bytes, arrays.room()).map_err(|e| Error::format(path, name, e))?;
        arrays.insert(name, item);
        arrays
    };
    (arrays.expect(name, &[None])).map(|array| array.numbers.clone())
}
