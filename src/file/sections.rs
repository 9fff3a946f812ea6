//! Bytes to sections and back.

use crate::{Error, Result};
use serde::{Deserialize, Serialize};
use std::path::Path;

const MAGIC: [u8; 8] = *b"SUPPLE\r\n";
/// Raised when the frame around the sections changes; files of other versions are refused.
const VERSION: u32 = 4;
const HEADER: usize = 24;
/// Tag, version, length.
const SECTION_HEADER: usize = 16;

/// A part of a baked file that a reader may pass over.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Section {
    /// Four letters.
    pub tag: [u8; 4],
    /// Of its content.
    pub version: u32,
    /// Its content.
    pub content: Vec<u8>,
}

/// A file of `sections`.
pub(super) fn join(sections: &[Section]) -> Vec<u8> {
    let mut bytes = vec![0; HEADER];
    for section in sections {
        bytes.extend(section.tag);
        bytes.extend(section.version.to_le_bytes());
        bytes.extend((section.content.len() as u64).to_le_bytes());
        bytes.extend(&section.content);
    }
    let length = (bytes.len() - HEADER) as u64;
    bytes[..8].copy_from_slice(&MAGIC);
    bytes[8..12].copy_from_slice(&VERSION.to_le_bytes());
    bytes[16..24].copy_from_slice(&length.to_le_bytes());
    let sum = checksum(&bytes);
    bytes[12..16].copy_from_slice(&sum.to_le_bytes());
    bytes
}

/// The sections of a file's `bytes`.
///
/// # Errors
/// [`Error::Format`] where they are not a whole, unharmed file of this version.
pub(super) fn split(bytes: &[u8], path: &Path) -> Result<Vec<Section>> {
    let fail = |field: &str, problem: String| Err(Error::format(path, field, problem));
    if bytes.get(..MAGIC.len()) != Some(&MAGIC) {
        let problem = "not a baked avatar; make one with `supple bake`";
        return fail("magic", problem.into());
    }
    let Some((header, mut payload)) = bytes.split_at_checked(HEADER) else {
        return fail("header", "the file is cut short; bake it again".into());
    };
    let cure = match word(header, 8) {
        VERSION => None,
        version if version > VERSION => Some("update supple"),
        _ => Some("bake it again"),
    };
    if let Some(cure) = cure {
        let version = word(header, 8);
        let problem = format!("{version}, this build reads {VERSION}; {cure}");
        return fail("version", problem);
    }
    let length = long_word(header, 16);
    if payload.len() as u64 != length {
        let problem = format!(
            "{} bytes of {length}: cut short or added to; bake it again",
            payload.len()
        );
        return fail("payload", problem);
    }
    if checksum(bytes) != word(header, 12) {
        return fail("checksum", "the file was damaged; bake it again".into());
    }
    let mut sections: Vec<Section> = Vec::new();
    while !payload.is_empty() {
        let found = payload.split_at_checked(SECTION_HEADER);
        let content = found.and_then(|(head, rest)| {
            let length = usize::try_from(long_word(head, 8)).ok()?;
            let (content, rest) = rest.split_at_checked(length)?;
            Some((head, content, rest))
        });
        let Some((head, content, rest)) = content else {
            return fail("payload", "a section is cut short; bake it again".into());
        };
        let tag = [head[0], head[1], head[2], head[3]];
        if sections.iter().any(|s| s.tag == tag) {
            let problem = "is there twice; bake it again";
            return fail(&tag_name(tag), problem.into());
        }
        sections.push(Section {
            tag,
            version: word(head, 4),
            content: content.to_vec(),
        });
        payload = rest;
    }
    Ok(sections)
}

/// How errors name a section.
pub(super) fn tag_name(tag: [u8; 4]) -> String {
    format!("section {}", tag.escape_ascii())
}

fn word(bytes: &[u8], at: usize) -> u32 {
    u32::from_le_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]])
}

fn long_word(bytes: &[u8], at: usize) -> u64 {
    u64::from(word(bytes, at)) | u64::from(word(bytes, at + 4)) << 32
}

/// CRC-32 of everything but the magic and the checksum itself.
fn checksum(bytes: &[u8]) -> u32 {
    let mut hasher = crc32fast::Hasher::new();
    hasher.update(&bytes[8..12]);
    hasher.update(&bytes[16..]);
    hasher.finalize()
}
