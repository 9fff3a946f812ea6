//! The baked file: an avatar in tagged sections, each with a version of its own.
//!
//! | bytes | what |
//! |---|---|
//! | 0..8 | `SUPPLE\r\n`: a text-mode copy breaks it |
//! | 8..12 | version of this frame, little endian |
//! | 12..16 | CRC-32 of everything else after the magic |
//! | 16..24 | length of the sections, little endian |
//! | 24.. | sections: a tag of four letters, a version (u32), a length (u64), so many bytes |
//!
//! A reader passes over sections that it does not know, so that a later `supple` may add some, and one that is not there
//! leaves its default (`parts` states it). What a step reads is apart from what only drawing, reports, further bakes
//! and the full space read: [`Parts::Step`] writes the one without the other.

mod parts;
mod sections;
mod sparse_columns;
mod version_1;
pub(crate) mod whole;

pub use sections::Section;
use whole::write_whole;

use crate::model::Avatar;
use crate::{Error, Result};
use std::fs::File;
use std::io::Read;
use std::path::Path;

/// A larger file is not read: 1 GiB, a hundred times a detailed body.
const MOST_BYTES: u64 = 1 << 30;

/// How much of an avatar goes into a file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Parts {
    /// What a step and drawing read, but for images. [`Avatar::layer`] stays empty: no det F over tets, no full space; and
    /// [`Avatar::appearance`]: a host has the character's own.
    Step,
    /// Everything.
    #[default]
    All,
}

/// What a baked file holds.
#[derive(Clone, Debug, PartialEq)]
pub struct AvatarFile {
    /// The avatar.
    pub avatar: Avatar,
    /// Sections of other crates and of later versions, as they are.
    pub others: Vec<Section>,
}

impl AvatarFile {
    /// `avatar` and nothing else.
    pub fn new(avatar: Avatar) -> Self {
        Self {
            avatar,
            others: Vec::new(),
        }
    }

    /// The bytes of the file. The same avatar gives the same bytes.
    ///
    /// # Errors
    /// [`Error::Invalid`] where the avatar is not valid, has bodies, or is too large for a file.
    pub fn to_bytes(&self, parts: Parts) -> Result<Vec<u8>> {
        self.avatar.validate()?;
        if !self.avatar.bodies.is_empty() {
            let problem = "are no part of a baked file; write the avatar before it gets them";
            return Err(Error::invalid("bodies", problem));
        }
        if self.avatar.fine.slots > 0 {
            let problem = "are no part of a baked file; write the avatar before it gets them";
            return Err(Error::invalid("fine.slots", problem));
        }
        let mut all = parts::of_avatar(&self.avatar, parts)?;
        all.extend(self.others.iter().cloned());
        let bytes = sections::join(&all);
        if bytes.len() as u64 > MOST_BYTES {
            let problem = format!(
                "{} bytes are too many for a baked file; use a coarser mesh",
                bytes.len()
            );
            return Err(Error::invalid("avatar", problem));
        }
        Ok(bytes)
    }

    /// What the `bytes` of a file hold, the avatar validated in full; `path` names it in errors.
    ///
    /// # Errors
    /// [`Error::Format`] where they are not a whole, unharmed file.
    pub fn from_bytes(bytes: &[u8], path: &Path) -> Result<Self> {
        let mut others = sections::split(bytes, path)?;
        let avatar = parts::to_avatar(&mut others, path)?;
        avatar.validate().map_err(|e| e.of_file(path))?;
        Ok(Self { avatar, others })
    }

    /// Writes the file: beside `path` first, then renamed, so that no half file is ever seen.
    ///
    /// # Errors
    /// As [`AvatarFile::to_bytes`], and [`Error::Io`].
    pub fn write(&self, parts: Parts, path: impl AsRef<Path>) -> Result<()> {
        write_whole(path, self.to_bytes(parts)?)
    }

    /// Reads a file.
    ///
    /// # Errors
    /// As [`AvatarFile::from_bytes`], and [`Error::Io`].
    pub fn read(path: impl AsRef<Path>) -> Result<Self> {
        let path = path.as_ref();
        let io = |source| Error::io(path, source);
        let file = File::open(path).map_err(io)?;
        let mut bytes = Vec::new();
        // One byte more than allowed tells a file that is too long from one that just fits.
        file.take(MOST_BYTES + 1)
            .read_to_end(&mut bytes)
            .map_err(io)?;
        if bytes.len() as u64 > MOST_BYTES {
            let problem = format!("more than {MOST_BYTES} bytes");
            return Err(Error::format(path, "length", problem));
        }
        Self::from_bytes(&bytes, path)
    }
}

/// The avatar of a baked file.
///
/// # Errors
/// As [`AvatarFile::read`].
pub fn read_avatar(path: impl AsRef<Path>) -> Result<Avatar> {
    Ok(AvatarFile::read(path)?.avatar)
}

/// Writes the baked file of `avatar`, all of it.
///
/// # Errors
/// As [`AvatarFile::write`].
pub fn write_avatar(avatar: &Avatar, path: impl AsRef<Path>) -> Result<()> {
    AvatarFile::new(avatar.clone()).write(Parts::All, path)
}
