//! The baked file with the report of its bake: one more section of the engine's.

use crate::report::{BakeCost, BakeReport};
use std::path::Path;
use supple::file::{AvatarFile, Parts, Section};
use supple::model::Avatar;
use supple::{Error, Result};

const TAG: [u8; 4] = *b"rept";
const VERSION: u32 = 4;

/// What a baked file holds.
#[derive(Clone, Debug, PartialEq)]
pub struct Baked {
    /// The avatar.
    pub avatar: Avatar,
    /// What its bake did, without its cost.
    pub report: Option<BakeReport>,
}

/// The file of `avatar`. The report's cost is left out, so that the same bake gives the same bytes.
///
/// # Errors
/// [`Error::Invalid`] of a report that cannot be written.
pub fn baked_file(avatar: &Avatar, report: Option<&BakeReport>) -> Result<AvatarFile> {
    let section = |report: &BakeReport| -> Result<Section> {
        let report = BakeReport {
            cost: BakeCost::default(),
            ..report.clone()
        };
        let content = postcard::to_allocvec(&report)
            .map_err(|e| Error::invalid("report", format!("cannot be written: {e}")))?;
        Ok(Section {
            tag: TAG,
            version: VERSION,
            content,
        })
    };
    Ok(AvatarFile {
        avatar: avatar.clone(),
        others: report.map(section).transpose()?.into_iter().collect(),
    })
}

/// The bytes of the baked file of `avatar` and `report`.
///
/// # Errors
/// As [`AvatarFile::to_bytes`].
pub fn to_bytes(avatar: &Avatar, report: Option<&BakeReport>) -> Result<Vec<u8>> {
    baked_file(avatar, report)?.to_bytes(Parts::All)
}

/// What a baked file's `bytes` hold; `path` names it in errors.
///
/// # Errors
/// As [`AvatarFile::from_bytes`]. A report of another version is passed over: it is for reading only.
pub fn from_bytes(bytes: &[u8], path: &Path) -> Result<Baked> {
    with_report(AvatarFile::from_bytes(bytes, path)?, path)
}

/// Writes the baked file of `avatar` and `report`.
///
/// # Errors
/// As [`AvatarFile::write`].
pub fn write_baked(avatar: &Avatar, report: &BakeReport, path: impl AsRef<Path>) -> Result<()> {
    baked_file(avatar, Some(report))?.write(Parts::All, path)
}

/// Reads a baked file.
///
/// # Errors
/// As [`AvatarFile::read`].
pub fn read_baked(path: impl AsRef<Path>) -> Result<Baked> {
    let path = path.as_ref();
    with_report(AvatarFile::read(path)?, path)
}

fn with_report(file: AvatarFile, path: &Path) -> Result<Baked> {
    let known = |s: &&Section| s.tag == TAG && s.version == VERSION;
    let report = (file.others.iter().find(known)).map(|section| {
        postcard::from_bytes(&section.content)
            .map_err(|e| Error::format(path, "section rept", format!("{e}; bake it again")))
    });
    Ok(Baked {
        avatar: file.avatar,
        report: report.transpose()?,
    })
}
