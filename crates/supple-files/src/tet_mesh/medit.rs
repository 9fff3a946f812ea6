//! Medit's `.mesh`, the text form: keywords, each with a count and its lines.
//!
//! Nodes are numbered from 1; the reference at the end of each line is the label, 0 for none.

use super::TetFile;
use super::draft::Draft;
use super::words::Words;
use glam::DVec3;
use std::path::Path;
use supple::Result;

pub(super) fn parse(bytes: &[u8], path: &Path) -> Result<TetFile> {
    let mut words = Words::new(bytes, path);
    let mut draft = Draft::default();
    let mut next_node = 1;
    while let Some(word) = words.peek() {
        words.word("a keyword")?;
        match word {
            b"MeshVersionFormatted" => {
                words.value::<u32>("the version")?;
            }
            b"Dimension" => {
                if words.value::<u32>("the dimension")? != 3 {
                    return Err(words.fault("a mesh in three dimensions is needed"));
                }
            }
            b"Vertices" => {
                for _ in 0..words.value::<u64>("the number of vertices")? {
                    let [x, y, z] = [(); 3].map(|()| words.value("a vertex's x, y, z"));
                    let place = DVec3::new(x?, y?, z?);
                    words.value::<i64>("a vertex's reference")?;
                    // A number that counts up is new.
                    let _ = draft.node(next_node, place);
                    next_node += 1;
                }
            }
            b"Tetrahedra" => {
                for _ in 0..words.value::<u64>("the number of tets")? {
                    let [a, b, c, d] = [(); 4].map(|()| words.value("a tet's vertex"));
                    let label = tet_label(&mut draft, words.value("a tet's reference")?);
                    draft.tet([a?, b?, c?, d?], label);
                }
            }
            b"Triangles" => {
                for _ in 0..words.value::<u64>("the number of triangles")? {
                    let [a, b, c] = [(); 3].map(|()| words.value("a triangle's vertex"));
                    let reference = words.value("a triangle's reference")?;
                    mark(&mut draft, [a?, b?, c?], reference);
                }
            }
            b"End" => break,
            other => {
                let name = String::from_utf8_lossy(&other[..other.len().min(32)]).into_owned();
                if is_refused(&name) {
                    return Err(words.fault(refusal(&name)));
                }
                if !name.starts_with(|c: char| c.is_ascii_alphabetic()) {
                    let problem =
                        format!("a keyword should stand here, not `{name}`: correct the counts");
                    return Err(words.fault(problem));
                }
                // Other keywords' numbers are of no use here.
                while words.peek().is_some_and(|w| !w[0].is_ascii_alphabetic()) {
                    words.word("a number")?;
                }
            }
        }
    }
    draft.finish(path)
}

/// Volumes that are no linear tets.
pub(super) fn is_refused(keyword: &str) -> bool {
    matches!(keyword, "Hexahedra" | "Prisms" | "Pyramids" | "Wedges")
        || keyword.starts_with("TetrahedraP")
}

pub(super) fn refusal(keyword: &str) -> String {
    format!("{keyword} are not read: mesh again with linear tets only")
}

pub(super) fn tet_label(draft: &mut Draft, reference: i64) -> Option<u32> {
    (reference != 0).then(|| draft.label(&reference.to_string()))
}

pub(super) fn mark(draft: &mut Draft, nodes: [u64; 3], reference: i64) {
    if reference != 0 {
        let label = draft.label(&format!("surface:{reference}"));
        nodes.iter().for_each(|&node| draft.mark(node, label));
    }
}
