//! Maps painted on a skin, from NumPy files.

use crate::arrays::Arrays;
use crate::file::read_bytes;
use crate::{npy, npz};
use std::path::Path;
use supple::{Error, Result};

/// The numbers of a `.npy` file, or of the array `name` of a `.npz` archive.
///
/// # Errors
/// [`Error::Io`], [`Error::Format`] where it is no such file, no list of numbers, or not finite.
pub fn read_painted(path: &Path, name: &str) -> Result<Vec<f64>> {
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
