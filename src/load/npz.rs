//! NumPy's archives, `.npz`: zip files of `.npy` arrays.

use super::npy::{Array, parse};
use crate::{Error, Result};
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufReader, Read};
use std::path::{Path, PathBuf};

/// Largest archive content that is read, bytes.
const LARGEST_ARCHIVE: u64 = 1 << 30;

/// The arrays of an `.npz` archive.
pub(crate) struct Archive {
    path: PathBuf,
    arrays: BTreeMap<String, Array>,
}

impl Archive {
    /// Reads those of the `wanted` arrays that are in the archive at `path`.
    pub fn read(path: &Path, wanted: &[&str]) -> Result<Self> {
        let io = |e| Error::io(path, e);
        let broken = |field: &str, problem: String| Error::format(path, field, problem);
        let file = BufReader::new(File::open(path).map_err(io)?);
        let mut zip = zip::ZipArchive::new(file)
            .map_err(|e| broken("archive", format!("is no .npz archive: {e}")))?;
        let mut arrays = BTreeMap::new();
        let mut room = LARGEST_ARCHIVE;
        for &key in wanted {
            let Some(index) = zip.index_for_name(&format!("{key}.npy")) else {
                continue;
            };
            let member = zip
                .by_index(index)
                .map_err(|e| broken(key, format!("cannot be unpacked: {e}")))?;
            let size = member.size();
            room = room.checked_sub(size).ok_or_else(|| {
                broken(
                    key,
                    format!("{size} bytes: more than {LARGEST_ARCHIVE} in all"),
                )
            })?;
            let mut bytes = Vec::new();
            member
                .take(size)
                .read_to_end(&mut bytes)
                .map_err(|e| broken(key, format!("cannot be unpacked: {e}")))?;
            arrays.insert(key.to_string(), parse(&bytes).map_err(|e| broken(key, e))?);
        }
        Ok(Self {
            path: path.to_path_buf(),
            arrays,
        })
    }

    /// An [`Error::Format`] of array `key`.
    pub fn broken(&self, key: &str, problem: impl Into<String>) -> Error {
        Error::format(&self.path, key, problem)
    }

    /// The array `key`, if it is there; all of its numbers must be finite.
    pub fn get(&self, key: &str) -> Result<Option<&Array>> {
        let array = self.arrays.get(key);
        if let Some(at) = array.and_then(|a| a.numbers.iter().position(|v| !v.is_finite())) {
            return Err(self.broken(key, format!("element {at} is not finite")));
        }
        Ok(array)
    }

    /// The array `key`, whose shape must be `shape`; `None` stands for any length.
    pub fn expect(&self, key: &str, shape: &[Option<usize>]) -> Result<&Array> {
        let array = self.get(key)?.ok_or_else(|| {
            let found: Vec<_> = self.arrays.keys().map(String::as_str).collect();
            self.broken(key, format!("is missing; there are {}", found.join(", ")))
        })?;
        let fits = array.shape.len() == shape.len()
            && array
                .shape
                .iter()
                .zip(shape)
                .all(|(found, wanted)| wanted.is_none_or(|w| w == *found));
        if fits && array.texts.is_empty() {
            return Ok(array);
        }
        let wanted: Vec<_> = shape
            .iter()
            .map(|s| s.map_or("any".to_string(), |n| n.to_string()))
            .collect();
        let found = if array.texts.is_empty() {
            format!("shape {:?}", array.shape)
        } else {
            "text".to_string()
        };
        let wanted = wanted.join(", ");
        Err(self.broken(
            key,
            format!("{found}, expected numbers of shape [{wanted}]"),
        ))
    }
}
