//! Tet meshes, one file a format.
//!
//! | file | format |
//! |---|---|
//! | `.node` and `.ele` (and `.face`, where it is there) | TetGen: [`tetgen`] |
//! | `.msh` | Gmsh 2.2 and 4.1, text and binary: [`gmsh`] |
//! | `.mesh`, `.meshb` | Medit, text and binary: [`medit`], [`medit_binary`] |
//! | other text | nodes, tets, pinned and surface nodes: [`read_tet_mesh`] |
//!
//! **Labels.** A file may label its tets (a region attribute, a physical volume, a reference) and its surfaces (a
//! boundary marker, a physical surface, a reference). A label is the physical name where there is one and
//! else the number as a text, for surfaces with `surface:` before it. What a label that is a bone's name, or
//! that a recipe's table of regions maps to one, marks is bone: tets are left out of the tissue, and
//! the nodes where they meet it, like the nodes of a surface, are held by that bone. A surface
//! labelled `skin` is the skin; without one, the skin is the outside of all tets.

mod bone;
mod checks;
mod draft;
mod embed;
mod gmsh;
mod gmsh_2;
mod gmsh_4;
mod layer;
mod medit;
mod medit_binary;
mod plain;
mod tetgen;
mod words;
mod write;

pub use layer::TetLayer;
pub use plain::{TetMeshFile, parse_tet_mesh, read_tet_mesh};
pub use tetgen::parse_tetgen;
pub use write::write_tet_mesh;

use super::file::read_bytes;
use std::path::Path;
use supple::model::TetMesh;
use supple::{Error, Result};

/// Label of the nodes of the skin.
pub const SKIN: &str = "skin";

/// Label of the nodes that the only bone holds.
pub const BONE: &str = "bone";

/// A tet mesh with what its file labels; see [`read_tets`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TetFile {
    /// All nodes that are in a tet, and the tets, positively oriented.
    pub mesh: TetMesh,
    /// The file's labels, in the order of their first use.
    pub labels: Vec<String>,
    /// Label of each tet, if it has one.
    pub tet_labels: Vec<Option<u32>>,
    /// Nodes on labelled surfaces with their labels, rising; a node may have several.
    pub marks: Vec<(u32, u32)>,
}

/// Reads the tet mesh at `path`; the format is that of its content or extension. TetGen's files are
/// known by any of their names.
///
/// # Errors
/// [`Error::Io`] where a file cannot be read, [`Error::Format`] with the line or byte where it is broken:
/// elements that are no linear tets, a node that is not there, a flat or repeated tet, a face of
/// three tets.
pub fn read_tets(path: impl AsRef<Path>) -> Result<TetFile> {
    let path = path.as_ref();
    let extension = path.extension().unwrap_or_default();
    if ["node", "ele", "face"]
        .iter()
        .any(|e| extension.eq_ignore_ascii_case(e))
    {
        return tetgen::read(path);
    }
    parse_tets(&read_bytes(path)?, path)
}

/// Reads a tet mesh that is one file from its `bytes`; `path` names it in errors. See [`read_tets`].
pub fn parse_tets(bytes: &[u8], path: &Path) -> Result<TetFile> {
    let start = bytes.trim_ascii_start();
    let called = |name: &str| {
        path.extension()
            .is_some_and(|e| e.eq_ignore_ascii_case(name))
    };
    let begins = |word: &str| start.starts_with(word.as_bytes());
    if called("msh") || begins("$MeshFormat") || begins("$Comments") {
        gmsh::parse(bytes, path)
    } else if medit_binary::is_binary(bytes) {
        medit_binary::parse(bytes, path)
    } else if called("mesh") || begins("MeshVersionFormatted") {
        medit::parse(bytes, path)
    } else {
        let text = std::str::from_utf8(bytes).map_err(|e| {
            let at = format!("byte {}", e.valid_up_to());
            Error::format(
                path,
                at,
                "is neither text nor a binary format that is known",
            )
        })?;
        let file = parse_tet_mesh(text, path)?;
        let pinned = file.pinned.iter().map(|n| (*n, 0));
        let surface = file.surface.iter().map(|n| (*n, 1));
        let mut marks: Vec<(u32, u32)> = pinned.chain(surface).collect();
        marks.sort_unstable();
        Ok(TetFile {
            tet_labels: vec![None; file.mesh.tets.len()],
            mesh: file.mesh,
            labels: vec![BONE.into(), SKIN.into()],
            marks,
        })
    }
}
