//! Tagged sections, each with its version.

use super::characters::{FactorsWithoutTension, StoredDriver};
use super::{DRIVERS, Snapshot};
use crate::file::Section;
use crate::model::Avatar;
use crate::potential::TissueFactors;
use crate::{Error, Result};
use serde::Serialize;
use serde::de::DeserializeOwned;

/// Of a section's content, as this build writes it.
fn version(tag: [u8; 4]) -> u32 {
    match tag {
        DRIVERS => 2,
        _ => 1,
    }
}

/// CRC-32 of an avatar as it was handed in.
pub(super) fn checksum(avatar: &Avatar) -> Result<u32> {
    let bytes = postcard::to_stdvec(avatar).map_err(|e| Error::invalid("avatar", e.to_string()))?;
    Ok(crc32fast::hash(&bytes))
}

pub(super) fn section(tag: [u8; 4], content: &impl Serialize) -> Result<Section> {
    let written = postcard::to_stdvec(content);
    Ok(Section {
        tag,
        version: version(tag),
        content: written.map_err(|e| Error::invalid("snapshot", e.to_string()))?,
    })
}

/// [`read`], if it is there.
pub(super) fn read_optional<T: DeserializeOwned>(
    snapshot: &Snapshot,
    tag: [u8; 4],
) -> Result<Option<T>> {
    let there = snapshot.sections.iter().any(|s| s.tag == tag);
    there.then(|| read(snapshot, tag)).transpose()
}

/// The drivers, of either version.
pub(super) fn read_drivers(snapshot: &Snapshot) -> Result<Vec<StoredDriver<TissueFactors>>> {
    let before = (snapshot.sections.iter()).any(|s| s.tag == DRIVERS && s.version == 1);
    if !before {
        return read(snapshot, DRIVERS);
    }
    let drivers: Vec<StoredDriver<FactorsWithoutTension>> = read_version(snapshot, DRIVERS, 1)?;
    Ok(drivers.into_iter().map(Into::into).collect())
}

pub(super) fn read<T: DeserializeOwned>(snapshot: &Snapshot, tag: [u8; 4]) -> Result<T> {
    read_version(snapshot, tag, version(tag))
}

pub(super) fn read_version<T: DeserializeOwned>(
    snapshot: &Snapshot,
    tag: [u8; 4],
    known: u32,
) -> Result<T> {
    let field = format!("snapshot.{}", tag.escape_ascii());
    let found = snapshot.sections.iter().find(|s| s.tag == tag);
    let section = found.ok_or_else(|| Error::invalid(field.clone(), "is missing"))?;
    if section.version != known {
        let version = section.version;
        let problem = format!("version {version}; this build reads {known}");
        return Err(Error::invalid(field, problem));
    }
    let read = postcard::take_from_bytes(&section.content);
    match read {
        Ok((content, [])) => Ok(content),
        Ok(_) => Err(Error::invalid(field, "has bytes left over: it is damaged")),
        Err(e) => Err(Error::invalid(field, format!("is damaged: {e}"))),
    }
}

pub(super) fn damaged() -> Error {
    Error::invalid("snapshot", "is damaged: its sections do not fit each other")
}
