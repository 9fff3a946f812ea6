//! Medit's `.meshb` (GMF): keywords by number, each with the place of the next.
//!
//! Version 1 has numbers of 4 bytes, version 2 reals of 8, version 3 also places of 8, version 4 also integers
//! of 8.

use super::TetFile;
use super::draft::Draft;
use super::medit::{mark, refusal, tet_label};
use super::words::Words;
use glam::DVec3;
use std::path::Path;
use supple::Result;

/// Keywords by GMF's numbers.
const DIMENSION: i32 = 3;
const VERTICES: i32 = 4;
const TRIANGLES: i32 = 6;
const TETRAHEDRA: i32 = 8;
const PRISMS: i32 = 9;
const HEXAHEDRA: i32 = 10;
const END: i32 = 54;

/// Whether `bytes` begin as such a file: a 1, whose bytes tell their order, and the version.
pub(super) fn is_binary(bytes: &[u8]) -> bool {
    let Some(start) = bytes.first_chunk::<8>() else {
        return false;
    };
    matches!(
        start,
        [1, 0, 0, 0, 1..=4, 0, 0, 0] | [0, 0, 0, 1, 0, 0, 0, 1..=4]
    )
}

struct Gmf<'a> {
    words: Words<'a>,
    version: i32,
}

pub(super) fn parse(bytes: &[u8], path: &Path) -> Result<TetFile> {
    let mut words = Words::new(bytes, path);
    words.binary = true;
    words.big_endian = bytes.first() == Some(&0);
    words.binary_i32()?;
    let version = words.binary_i32()?;
    let mut gmf = Gmf { words, version };
    let mut draft = Draft::default();
    let mut next_node = 1;
    while gmf.words.left() > 0 {
        let keyword = gmf.words.binary_i32()?;
        if keyword == END {
            break;
        }
        let next = gmf.place()?;
        match keyword {
            DIMENSION if gmf.words.binary_i32()? != 3 => {
                return Err(gmf.words.fault("a mesh in three dimensions is needed"));
            }
            VERTICES => {
                for _ in 0..gmf.int()? {
                    let [x, y, z] = [(); 3].map(|()| gmf.real());
                    let place = DVec3::new(x?, y?, z?);
                    gmf.int()?;
                    // A number that counts up is new.
                    let _ = draft.node(next_node, place);
                    next_node += 1;
                }
            }
            TETRAHEDRA => {
                for _ in 0..gmf.int()? {
                    let [a, b, c, d] = [(); 4].map(|()| gmf.int());
                    let nodes = [a? as u64, b? as u64, c? as u64, d? as u64];
                    let label = tet_label(&mut draft, gmf.int()?);
                    draft.tet(nodes, label);
                }
            }
            TRIANGLES => {
                for _ in 0..gmf.int()? {
                    let [a, b, c] = [(); 3].map(|()| gmf.int());
                    let nodes = [a? as u64, b? as u64, c? as u64];
                    mark(&mut draft, nodes, gmf.int()?);
                }
            }
            PRISMS | HEXAHEDRA => {
                let name = if keyword == PRISMS {
                    "Prisms"
                } else {
                    "Hexahedra"
                };
                return Err(gmf.words.fault(refusal(name)));
            }
            _ => {}
        }
        // The last keyword may point nowhere.
        if next == 0 {
            break;
        }
        gmf.words.jump(next)?;
    }
    draft.finish(path)
}

impl Gmf<'_> {
    fn int(&mut self) -> Result<i64> {
        match self.version {
            4 => self.words.binary_u64().map(|n| n as i64),
            _ => self.words.binary_i32().map(i64::from),
        }
    }

    fn real(&mut self) -> Result<f64> {
        match self.version {
            1 => self.words.binary_f32().map(f64::from),
            _ => self.words.binary_f64(),
        }
    }

    fn place(&mut self) -> Result<u64> {
        match self.version {
            1 | 2 => self.words.binary_i32().map(|n| n as u32 as u64),
            _ => self.words.binary_u64(),
        }
    }
}
