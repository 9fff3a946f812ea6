//! The baked file.
//!
//! | bytes | what |
//! |---|---|
//! | 0..8 | `SUPPLE\r\n`: a text-mode copy breaks it |
//! | 8..12 | version, little endian |
//! | 12..16 | CRC-32 of the version, the length and the payload |
//! | 16..24 | length of the payload, little endian |
//! | 24.. | the [`Avatar`] and, if there is one, its [`BakeReport`], postcard |

use super::report::{BakeCost, BakeReport};
use crate::model::Avatar;
use crate::{Error, Result};
use std::fs::{self, File};
use std::io::{Read, Write};
use std::path::Path;

const MAGIC: [u8; 8] = *b"SUPPLE\r\n";
/// Raised when the payload's layout changes; files of other versions are refused.
const VERSION: u32 = 3;
const HEADER: usize = 24;
/// A larger file is not read: 1 GiB, a hundred times a detailed body.
const MOST_BYTES: u64 = 1 << 30;

/// What a baked file holds.
#[derive(Clone, Debug, PartialEq)]
pub struct Baked {
    /// The avatar.
    pub avatar: Avatar,
    /// What its bake did, without its cost.
    pub report: Option<BakeReport>,
}

/// The bytes of the baked file of `avatar`. The report's cost is left out, so that the same bake gives the same
/// bytes.
///
/// # Errors
/// [`Error::Invalid`] where the avatar is not valid, or too large for a file.
pub fn to_bytes(avatar: &Avatar, report: Option<&BakeReport>) -> Result<Vec<u8>> {
    avatar.validate()?;
    if !avatar.bodies.is_empty() {
        let problem = "are no part of a baked file; write the avatar before it gets them";
        return Err(Error::invalid("bodies", problem));
    }
    let report = report.map(|r| BakeReport {
        cost: BakeCost::default(),
        ..r.clone()
    });
    let bytes = postcard::to_extend(&(avatar, report), vec![0; HEADER])
        .map_err(|e| Error::invalid("avatar", format!("cannot be written: {e}")));
    let mut bytes = bytes?;
    let length = (bytes.len() - HEADER) as u64;
    if bytes.len() as u64 > MOST_BYTES {
        let problem = format!("{length} bytes are too many for a baked file; use a coarser mesh");
        return Err(Error::invalid("avatar", problem));
    }
    bytes[..8].copy_from_slice(&MAGIC);
    bytes[8..12].copy_from_slice(&VERSION.to_le_bytes());
    bytes[16..24].copy_from_slice(&length.to_le_bytes());
    let sum = checksum(&bytes);
    bytes[12..16].copy_from_slice(&sum.to_le_bytes());
    Ok(bytes)
}

/// What a baked file's `bytes` hold, the avatar validated in full; `path` names it in errors.
///
/// # Errors
/// [`Error::Format`] where they are not a whole, unharmed file of this version.
pub fn from_bytes(bytes: &[u8], path: &Path) -> Result<Baked> {
    let fail = |field: &str, problem: String| Err(Error::format(path, field, problem));
    if bytes.get(..MAGIC.len()) != Some(&MAGIC) {
        return fail(
            "magic",
            "not a baked avatar; make one with `supple bake`".into(),
        );
    }
    let Some((header, payload)) = bytes.split_at_checked(HEADER) else {
        return fail("header", "the file is cut short; bake it again".into());
    };
    let word = |at: usize| {
        u32::from_le_bytes([header[at], header[at + 1], header[at + 2], header[at + 3]])
    };
    let length = u64::from(word(16)) | u64::from(word(20)) << 32;
    match word(8) {
        VERSION => {}
        newer if newer > VERSION => {
            return fail(
                "version",
                format!("{newer}, this build reads {VERSION}; update supple"),
            );
        }
        older => {
            return fail(
                "version",
                format!("{older}, this build reads {VERSION}; bake it again"),
            );
        }
    }
    if payload.len() as u64 != length {
        let problem = format!(
            "{} bytes of {length}: cut short or added to; bake it again",
            payload.len()
        );
        return fail("payload", problem);
    }
    if checksum(bytes) != word(12) {
        return fail("checksum", "the file was damaged; bake it again".into());
    }
    match postcard::take_from_bytes::<(Avatar, Option<BakeReport>)>(payload) {
        Ok(((avatar, report), [])) => match avatar.validate() {
            Ok(()) => Ok(Baked { avatar, report }),
            Err(Error::Invalid { field, problem }) => fail(&field, problem),
            Err(other) => Err(other),
        },
        Ok((_, rest)) => fail("payload", format!("{} bytes too many", rest.len())),
        Err(e) => fail("payload", format!("{e}; bake it again")),
    }
}

/// [`write_baked`] without a report.
///
/// # Errors
/// As [`write_baked`].
pub fn write_avatar(avatar: &Avatar, path: impl AsRef<Path>) -> Result<()> {
    write(avatar, None, path.as_ref())
}

/// Writes the baked file of `avatar` and `report`: beside `path` first, then renamed, so that no half file is ever seen.
///
/// # Errors
/// As [`to_bytes`], and [`Error::Io`].
pub fn write_baked(avatar: &Avatar, report: &BakeReport, path: impl AsRef<Path>) -> Result<()> {
    write(avatar, Some(report), path.as_ref())
}

fn write(avatar: &Avatar, report: Option<&BakeReport>, path: &Path) -> Result<()> {
    let bytes = to_bytes(avatar, report)?;
    let mut name = path.file_name().unwrap_or_default().to_owned();
    name.push(format!(".{}.part", std::process::id()));
    let part = path.with_file_name(name);
    let written = File::create(&part)
        .and_then(|mut file| file.write_all(&bytes).and_then(|()| file.sync_all()))
        .and_then(|()| fs::rename(&part, path));
    written.map_err(|source| {
        // The error is the one to tell; a part that cannot be removed is only litter.
        let _ = fs::remove_file(&part);
        Error::io(path, source)
    })
}

/// The avatar of a baked file.
///
/// # Errors
/// As [`read_baked`].
pub fn read_avatar(path: impl AsRef<Path>) -> Result<Avatar> {
    Ok(read_baked(path)?.avatar)
}

/// Reads a baked file.
///
/// # Errors
/// As [`from_bytes`], and [`Error::Io`].
pub fn read_baked(path: impl AsRef<Path>) -> Result<Baked> {
    let path = path.as_ref();
    let io = |source| Error::io(path, source);
    let file = File::open(path).map_err(io)?;
    let mut bytes = Vec::new();
    // One byte more than allowed tells a file that is too long from one that just fits.
    file.take(MOST_BYTES + 1)
        .read_to_end(&mut bytes)
        .map_err(io)?;
    if bytes.len() as u64 > MOST_BYTES {
        return Err(Error::format(
            path,
            "length",
            format!("more than {MOST_BYTES} bytes"),
        ));
    }
    from_bytes(&bytes, path)
}

/// CRC-32 of everything but the magic and the checksum itself.
fn checksum(bytes: &[u8]) -> u32 {
    let mut hasher = crc32fast::Hasher::new();
    hasher.update(&bytes[8..12]);
    hasher.update(&bytes[16..]);
    hasher.finalize()
}
