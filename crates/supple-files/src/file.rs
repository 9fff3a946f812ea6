//! Files in memory.

use std::fs::File;
use std::io::Read;
use std::path::Path;
use supple::{Error, Result};

/// Largest file that any reader takes, bytes.
const LARGEST_FILE: u64 = 1 << 30;

/// The content of the file at `path`.
///
/// # Errors
/// [`Error::Io`] where it cannot be read, [`Error::Format`] where it is larger than 1 GiB.
pub(crate) fn read_bytes(path: &Path) -> Result<Vec<u8>> {
    let io = |source| Error::io(path, source);
    let file = File::open(path).map_err(io)?;
    let mut bytes = Vec::new();
    // One byte more than allowed tells a file that is too long from one that just fits.
    file.take(LARGEST_FILE + 1)
        .read_to_end(&mut bytes)
        .map_err(io)?;
    if bytes.len() as u64 > LARGEST_FILE {
        let problem = format!("is larger than {LARGEST_FILE} bytes: split or coarsen it");
        return Err(Error::format(path, "size", problem));
    }
    Ok(bytes)
}

/// The text of the scene or recipe at `path`; errors where it cannot be read, is larger than 1 GiB, or is no text.
pub fn read_toml_text(path: &Path) -> Result<String> {
    String::from_utf8(read_bytes(path)?).map_err(|_| {
        let problem = "is not a TOML file; a character or a baked avatar is named in one: [avatar] file = \"…\"";
        Error::format(path, "format", problem)
    })
}

/// The text of the file at `path`; errors where it cannot be read, is larger than 1 GiB, or is not UTF-8.
pub fn read_text(path: &Path) -> Result<String> {
    String::from_utf8(read_bytes(path)?).map_err(|e| {
        let at = format!("byte {}", e.utf8_error().valid_up_to());
        Error::format(path, at, "is not text: save it as plain UTF-8")
    })
}
