//! Gmsh's `.msh`, versions 2.2 and 4.1, text and binary: <https://gmsh.info/doc/texinfo/gmsh.html#MSH-file-format>.
//!
//! A tet's label is its first physical volume, by name if it has one, else the number of its elementary volume;
//! a triangle's is its physical surface, and triangles without one are not read.

use super::draft::Draft;
use super::words::Words;
use super::{TetFile, gmsh_2, gmsh_4};
use std::collections::HashMap;
use std::path::Path;
use supple::{Error, Result};

/// Elements that are read, by Gmsh's number of their type.
pub(super) const TRIANGLE: u64 = 2;
/// See [`TRIANGLE`].
pub(super) const TET: u64 = 4;

/// What a reader of either version fills.
pub(super) struct Gmsh<'a> {
    pub words: Words<'a>,
    pub draft: Draft,
    /// Names of physical groups, by dimension and number.
    names: HashMap<(u8, i64), String>,
    /// Physical groups of entities, by dimension and number (version 4).
    pub groups: HashMap<(u8, i64), i64>,
}

pub(super) fn parse(bytes: &[u8], path: &Path) -> Result<TetFile> {
    let mut gmsh = Gmsh {
        words: Words::new(bytes, path),
        draft: Draft::default(),
        names: HashMap::new(),
        groups: HashMap::new(),
    };
    let mut version = None;
    while let Some(word) = gmsh.words.peek() {
        let section = String::from_utf8_lossy(word).into_owned();
        gmsh.words.word("a section")?;
        let known = match (section.as_str(), version) {
            ("$MeshFormat", None) => {
                version = Some(gmsh.format()?);
                true
            }
            ("$PhysicalNames", _) => {
                gmsh.physical_names()?;
                true
            }
            ("$Entities", Some(4)) => gmsh_4::entities(&mut gmsh).map(|()| true)?,
            ("$Nodes", Some(2)) => gmsh_2::nodes(&mut gmsh).map(|()| true)?,
            ("$Nodes", Some(4)) => gmsh_4::nodes(&mut gmsh).map(|()| true)?,
            ("$Elements", Some(2)) => gmsh_2::elements(&mut gmsh).map(|()| true)?,
            ("$Elements", Some(4)) => gmsh_4::elements(&mut gmsh).map(|()| true)?,
            ("$Nodes" | "$Elements" | "$Entities", None) => {
                return Err(gmsh.words.fault("$MeshFormat must come first"));
            }
            _ => false,
        };
        let Some(name) = section.strip_prefix('$') else {
            let shown: String = section.chars().take(20).collect();
            return Err(gmsh
                .words
                .fault(format!("a section should begin here, not `{shown}`")));
        };
        let end = format!("$End{name}");
        if !known {
            gmsh.words.skip_past(end.as_bytes())?;
        } else if gmsh.words.word(&end)? != end.as_bytes() {
            return Err(gmsh
                .words
                .fault(format!("{end} should stand here: correct the counts")));
        }
    }
    if version.is_none() {
        return Err(Error::format(path, "$MeshFormat", "is missing"));
    }
    gmsh.draft.finish(path)
}

impl Gmsh<'_> {
    /// The version's first digit.
    fn format(&mut self) -> Result<u8> {
        let words = &mut self.words;
        let version = words.word("the version")?;
        let major = match version {
            b"2.2" | b"2.1" | b"2" => 2,
            b"4.1" => 4,
            other => {
                let shown = String::from_utf8_lossy(&other[..other.len().min(8)]).into_owned();
                let problem = format!("version {shown} is not read: save as 2.2 or 4.1");
                return Err(words.fault(problem));
            }
        };
        let binary: u8 = words.value("0 (text) or 1 (binary)")?;
        let size: u8 = words.value("the size of a number")?;
        if binary > 1 || size != 8 {
            return Err(words.fault("numbers of 8 bytes, in text or binary, are read"));
        }
        if binary == 1 {
            words.end_line();
            words.binary = true;
            // A 1, whose bytes tell their order.
            words.big_endian = match words.binary_i32()? {
                1 => false,
                0x0100_0000 => true,
                _ => return Err(words.fault("the byte order's 1 is not there")),
            };
        }
        Ok(major)
    }

    /// Text in both forms.
    fn physical_names(&mut self) -> Result<()> {
        let count: u64 = self.words.value("the number of physical names")?;
        for _ in 0..count {
            let dimension = self.words.value("a physical group's dimension")?;
            let group = self.words.value("a physical group's number")?;
            let name = self.words.quoted()?;
            self.names.insert((dimension, group), name);
        }
        Ok(())
    }

    /// A number of 32 bits in binary files.
    pub fn int(&mut self, what: &str) -> Result<i64> {
        if self.words.binary {
            self.words.binary_i32().map(i64::from)
        } else {
            self.words.value(what)
        }
    }

    /// A number of 64 bits in binary files.
    pub fn size(&mut self, what: &str) -> Result<u64> {
        if self.words.binary {
            self.words.binary_u64()
        } else {
            self.words.value(what)
        }
    }

    pub fn real(&mut self, what: &str) -> Result<f64> {
        if self.words.binary {
            self.words.binary_f64()
        } else {
            self.words.value(what)
        }
    }

    /// Adds an element of this type: a tet or a triangle; others have no part in the tissue.
    pub fn element(&mut self, kind: u64, nodes: &[u64], label: Option<u32>) {
        match (kind, nodes, label) {
            (TET, &[a, b, c, d], _) => self.draft.tet([a, b, c, d], label),
            (TRIANGLE, _, Some(label)) => {
                nodes.iter().for_each(|&node| self.draft.mark(node, label));
            }
            _ => {}
        }
    }

    /// The label of elements of this type in physical group `group` (0: none) and entity `entity`.
    pub fn label(&mut self, kind: u64, group: i64, entity: i64) -> Option<u32> {
        let dimension = match kind {
            TET => 3,
            TRIANGLE if group != 0 => 2,
            _ => return None,
        };
        let number = if group == 0 {
            entity
        } else {
            group.saturating_abs()
        };
        let name = match self.names.get(&(dimension, number)).filter(|_| group != 0) {
            Some(name) => name.clone(),
            None if dimension == 2 => format!("surface:{number}"),
            None => number.to_string(),
        };
        Some(self.draft.label(&name))
    }

    /// How many nodes an element of this type has.
    ///
    /// # Errors
    /// Where it is a volume other than a linear tet, or not known.
    pub fn node_count(&self, kind: u64) -> Result<usize> {
        let count = match kind {
            15 => 1,
            1 => 2,
            TRIANGLE => 3,
            3 | TET => 4,
            // Surfaces and lines of higher order come with volumes that are refused.
            8 => 3,
            9 => 6,
            10 => 9,
            16 => 8,
            5 | 6 | 7 | 12 | 13 | 14 | 17 | 18 | 19 => {
                let problem = "holds hexahedra, prisms or pyramids: only tets are read, mesh again without them";
                return Err(self.words.fault(problem));
            }
            11 | 29 | 30 | 31 => {
                let problem = "holds tets of higher order: only linear ones are read, set Mesh.ElementOrder to 1";
                return Err(self.words.fault(problem));
            }
            other => {
                return Err(self
                    .words
                    .fault(format!("element type {other} is not known")));
            }
        };
        Ok(count)
    }
}
