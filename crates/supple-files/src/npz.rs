//! NumPy's archives, `.npz`: zip files of `.npy` arrays.

use super::arrays::Arrays;
use super::npy;
use std::io::{Cursor, Read};
use std::path::Path;
use supple::{Error, Result};

/// Largest archive content that is read, bytes.
const LARGEST_ARCHIVE: u64 = 1 << 30;

/// Whether `bytes` begin as a zip archive does.
pub(crate) fn is_archive(bytes: &[u8]) -> bool {
    bytes.starts_with(b"PK")
}

/// Whether any of these arrays is in an archive.
pub(crate) fn holds_any(bytes: &[u8], names: &[&str]) -> bool {
    let zip = zip::ZipArchive::new(Cursor::new(bytes));
    let held = |zip: zip::ZipArchive<_>| {
        let file = |name: &&str| zip.index_for_name(&format!("{name}.npy")).is_some();
        names.iter().any(file)
    };
    zip.is_ok_and(held)
}

/// Reads those of the `wanted` arrays that are in an archive's `bytes`; `path` names it in errors.
pub(crate) fn parse(bytes: &[u8], path: &Path, wanted: &[&str]) -> Result<Arrays> {
    let broken = |field: &str, problem: String| Error::format(path, field, problem);
    let mut zip = zip::ZipArchive::new(Cursor::new(bytes))
        .map_err(|e| broken("archive", format!("is no .npz archive: {e}")))?;
    let mut arrays = Arrays::of_file(path);
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
            let problem = format!("{size} bytes: more than {LARGEST_ARCHIVE} in all");
            broken(key, problem)
        })?;
        let mut content = Vec::new();
        member
            .take(size)
            .read_to_end(&mut content)
            .map_err(|e| broken(key, format!("cannot be unpacked: {e}")))?;
        let item = npy::parse(&content, arrays.room()).map_err(|e| broken(key, e))?;
        arrays.insert(key, item);
    }
    Ok(arrays)
}
