//! Maps painted on a skin, from NumPy files.

use super::arrays::Arrays;
use super::file::read_bytes;
use super::{npy, npz};
use crate::{Error, Result};
use std::path::Path;

/// A number for each of `vertices`, from a `.npy` file or from the array `name` of a `.npz` archive.
///
/// # Errors
/// [`Error::Io`], [`Error::Format`] where it is no such file, of another length, or not finite.
pub(super) fn read_painted(path: &Path, name: &str, vertices: usize) -> Result<Vec<f64>> {
    let bytes = read_bytes(path)?;
    let arrays = if npz::is_archive(&bytes) {
        npz::parse(&bytes, path, &[name])?
    } else {
        let mut arrays = Arrays::of_file(path);
        let item = npy::parse(&bytes, arrays.room()).map_err(|e| Error::format(path, name, e))?;
        arrays.insert(name, item);
        arrays
    };
    if let Some(array) = arrays.get(name)?.filter(|a| a.numbers.len() != vertices) {
        let count = array.numbers.len();
        let problem = format!(
            "holds {count} numbers for a skin of {vertices} vertices: paint the skin as it is read (`supple \
             inspect` tells its size)"
        );
        return Err(Error::format(path, name, problem));
    }
    arrays
        .expect(name, &[Some(vertices)])
        .map(|array| array.numbers.clone())
}
