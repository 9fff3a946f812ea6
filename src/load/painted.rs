//! Maps painted on a skin, from NumPy files.

use super::npy::{Array, parse};
use super::npz::Archive;
use crate::{Error, Result};
use std::path::Path;

/// Largest file that is read, bytes: a number for each of 30 million vertices.
const LARGEST_FILE: u64 = 1 << 28;

/// A number for each of `vertices`, from a `.npy` file or from the array `name` of a `.npz` archive.
///
/// # Errors
/// [`Error::Io`], [`Error::Format`] where it is no such file, of another length, or not finite.
pub(super) fn read_painted(path: &Path, name: &str, vertices: usize) -> Result<Vec<f64>> {
    let check = |array: &Array| {
        let count = array.numbers.len();
        if count != vertices {
            let problem = format!(
                "holds {count} numbers for a skin of {vertices} vertices: paint the skin as it is read (`supple \
                 inspect` tells its size)"
            );
            return Err(Error::format(path, name, problem));
        }
        if let Some(at) = array.numbers.iter().position(|v| !v.is_finite()) {
            let problem = format!("element {at} is not finite");
            return Err(Error::format(path, name, problem));
        }
        Ok(array.numbers.clone())
    };
    if path.extension().is_some_and(|e| e == "npz") {
        let archive = Archive::read(path, &[name])?;
        return check(archive.expect(name, &[Some(vertices)])?);
    }
    let size = std::fs::metadata(path)
        .map_err(|e| Error::io(path, e))?
        .len();
    if size > LARGEST_FILE {
        let problem = format!("is larger than {LARGEST_FILE} bytes");
        return Err(Error::format(path, name, problem));
    }
    let bytes = std::fs::read(path).map_err(|e| Error::io(path, e))?;
    check(&parse(&bytes).map_err(|e| Error::format(path, name, e))?)
}
