//! Tetrahedral meshes as text, as [`crate::tet_mesh::plain::read_tet_mesh`] reads them.

use crate::tet_mesh::plain::TetMeshFile;
use std::fmt::Write;
use std::path::Path;
use supple::Result;
use supple::internal::write_whole;

/// Writes the mesh with its pinned and surface nodes to `path`, with every digit.
pub fn write_tet_mesh(file: &TetMeshFile, path: impl AsRef<Path>) -> Result<()> {
    let TetMeshFile {
        mesh,
        pinned,
        surface,
    } = file;
    let counts = [
        mesh.nodes.len(),
        mesh.tets.len(),
        pinned.len(),
        surface.len(),
    ];
    let mut text = String::new();
    // Writing to a String cannot fail.
    let _ = writeln!(text, "{}", joined(&counts));
    for node in &mesh.nodes {
        let _ = writeln!(text, "{}", joined(&node.to_array()));
    }
    for tet in &mesh.tets {
        let _ = writeln!(text, "{}", joined(tet));
    }
    for list in [pinned, surface] {
        let _ = writeln!(text, "{}", joined(list));
    }
    write_whole(path, text)
}

fn joined(values: &[impl ToString]) -> String {
    let texts: Vec<_> = values.iter().map(ToString::to_string).collect();
    texts.join(" ")
}
