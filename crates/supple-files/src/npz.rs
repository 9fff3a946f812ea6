//! NumPy's archives, `.npz`: zip files of `.npy` arrays.

use super::arrays::Arrays;
use super::npy;
use std::io::{Cursor, Read, Write};
use std::path::Path;
use supple::{Error, Result};
use zip::CompressionMethod;
use zip::result::ZipResult;
use zip::write::SimpleFileOptions;

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

/// An archive of these arrays' `.npy` files, by name.
pub(crate) fn pack(arrays: &[(&str, Vec<u8>)]) -> ZipResult<Vec<u8>> {
    pack_by(CompressionMethod::Deflated, arrays)
}

/// [`pack`] without compression: what is large and hardly repeats.
pub(crate) fn pack_whole(arrays: &[(&str, Vec<u8>)]) -> ZipResult<Vec<u8>> {
    pack_by(CompressionMethod::Stored, arrays)
}

fn pack_by(method: CompressionMethod, arrays: &[(&str, Vec<u8>)]) -> ZipResult<Vec<u8>> {
    let mut zip = zip::ZipWriter::new(Cursor::new(Vec::new()));
    for (key, bytes) in arrays {
        let options = SimpleFileOptions::default()
            .compression_method(method)
            .last_modified_time(zip::DateTime::DEFAULT)
            .unix_permissions(0o644)
            // Beyond 4 GiB lengths take 8 bytes.
            .large_file(u32::try_from(bytes.len()).is_err());
        zip.start_file(format!("{key}.npy"), options)?;
        zip.write_all(bytes)?;
    }
    Ok(zip.finish()?.into_inner())
}
