//! Names for results that are kept: hashes of everything that they depend on.

use serde::Serialize;
use std::path::Path;
use supple::{Error, Result};

/// FNV-1a, 64 bits (Fowler, Noll, Vo 1991).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Fingerprint(u64);

impl Fingerprint {
    /// Of this very program: another build may give other results.
    pub fn new() -> Self {
        let mut hash = Self(0xcbf2_9ce4_8422_2325);
        hash.add(env!("CARGO_PKG_VERSION").as_bytes());
        if let Some(program) = std::env::current_exe().ok().and_then(|p| p.metadata().ok()) {
            hash.add(format!("{} {:?}", program.len(), program.modified().ok()).as_bytes());
        }
        hash
    }

    pub fn add(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.0 = (self.0 ^ u64::from(*byte)).wrapping_mul(0x100_0000_01b3);
        }
    }

    /// The content of a file.
    pub fn add_file(&mut self, path: &Path) -> Result<()> {
        self.add(&std::fs::read(path).map_err(|e| Error::io(path, e))?);
        Ok(())
    }

    /// `value` as JSON; `field` names it in errors.
    pub fn add_json(&mut self, field: &str, value: &impl Serialize) -> Result<()> {
        let text = serde_json::to_string(value)
            .map_err(|e| Error::invalid(field, format!("cannot be written: {e}")))?;
        self.add(text.as_bytes());
        Ok(())
    }

    /// `value` in binary: for large things.
    pub fn add_binary(&mut self, field: &str, value: &impl Serialize) -> Result<()> {
        postcard::to_io(value, &mut *self)
            .map_err(|e| Error::invalid(field, format!("cannot be written: {e}")))?;
        Ok(())
    }
}

impl std::io::Write for Fingerprint {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.add(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

impl std::fmt::Display for Fingerprint {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{:016x}", self.0)
    }
}
