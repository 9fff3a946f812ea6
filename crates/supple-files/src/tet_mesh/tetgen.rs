//! TetGen's files: <https://wias-berlin.de/software/tetgen/fformats.html>.
//!
//! `.node` has the nodes, from number 0 or 1 on, with attributes (not read) and boundary markers; `.ele` the
//! tets with, as their first attribute, the region; `.face`, which may be missing, the marked facets.

use super::TetFile;
use super::draft::Draft;
use super::words::Words;
use crate::file::read_bytes;
use glam::DVec3;
use std::path::Path;
use supple::Result;

/// Most attributes of a node or tet.
const MOST_ATTRIBUTES: u32 = 256;

/// Reads the mesh whose `.node`, `.ele` and perhaps `.face` lie beside each other; `path` is one of them.
pub(super) fn read(path: &Path) -> Result<TetFile> {
    let (nodes, tets) = (path.with_extension("node"), path.with_extension("ele"));
    let faces = path.with_extension("face");
    let faces = faces.exists().then(|| read_bytes(&faces)).transpose()?;
    parse_tetgen(
        &read_bytes(&nodes)?,
        &read_bytes(&tets)?,
        faces.as_deref(),
        path,
    )
}

/// Reads a mesh from the bytes of its `.node`, `.ele` and perhaps `.face` files; `path`, with each extension
/// in turn, names them in errors. See [`super::read_tets`].
pub fn parse_tetgen(
    nodes: &[u8],
    tets: &[u8],
    faces: Option<&[u8]>,
    path: &Path,
) -> Result<TetFile> {
    let mut draft = Draft::default();
    read_nodes(&mut draft, Words::new(nodes, &path.with_extension("node")))?;
    let tets_path = path.with_extension("ele");
    read_tets(&mut draft, Words::new(tets, &tets_path))?;
    if let Some(faces) = faces {
        read_faces(&mut draft, Words::new(faces, &path.with_extension("face")))?;
    }
    draft.finish(&tets_path)
}

fn read_nodes(draft: &mut Draft, mut words: Words) -> Result<()> {
    let count: u64 = words.value("the number of nodes")?;
    let dimension: u32 = words.value("the dimension")?;
    let attributes = attributes(&mut words)?;
    let markers: u32 = words.value("the number of boundary markers (0 or 1)")?;
    if count == 0 {
        return Err(words.fault("the nodes are in another file: name the one that holds them"));
    }
    if dimension != 3 || markers > 1 {
        return Err(words.fault("nodes in three dimensions, with one marker at most, are read"));
    }
    for i in 0..count {
        let id: u64 = words.value("a node's number")?;
        let place = [(); 3].map(|()| words.value("a node's x, y, z"));
        let [x, y, z] = place;
        if !draft.node(id, DVec3::new(x?, y?, z?)) {
            return Err(words.fault(format!("node {id} stands twice")));
        }
        if i == 0 && id > 1 {
            return Err(words.fault("the first node's number is 0 or 1"));
        }
        for _ in 0..attributes {
            words.value::<f64>("a node's attribute")?;
        }
        if markers == 1 {
            mark(draft, &[id], words.value("a node's boundary marker")?);
        }
    }
    end(&mut words)
}

fn read_tets(draft: &mut Draft, mut words: Words) -> Result<()> {
    let count: u64 = words.value("the number of tets")?;
    let corners: u32 = words.value("the number of a tet's nodes")?;
    let attributes = attributes(&mut words)?;
    if corners != 4 {
        let problem = format!("tets of {corners} nodes are not read: mesh without -o2");
        return Err(words.fault(problem));
    }
    for _ in 0..count {
        words.value::<u64>("a tet's number")?;
        let [a, b, c, d] = [(); 4].map(|()| words.value("a tet's node"));
        let mut region = None;
        for k in 0..attributes {
            let attribute: f64 = words.value("a tet's attribute")?;
            if k == 0 {
                region = Some(draft.label(&format!("{attribute}")));
            }
        }
        draft.tet([a?, b?, c?, d?], region);
    }
    end(&mut words)
}

fn read_faces(draft: &mut Draft, mut words: Words) -> Result<()> {
    let count: u64 = words.value("the number of faces")?;
    let markers: u32 = words.value("the number of boundary markers (0 or 1)")?;
    if markers > 1 {
        return Err(words.fault("faces with one marker at most are read"));
    }
    for _ in 0..count {
        words.value::<u64>("a face's number")?;
        let [a, b, c] = [(); 3].map(|()| words.value("a face's node"));
        let nodes = [a?, b?, c?];
        if markers == 1 {
            mark(draft, &nodes, words.value("a face's boundary marker")?);
            // With -nn, the two tets of the face follow; what is no number of a face ends its line.
        }
        words.end_line();
    }
    end(&mut words)
}

fn attributes(words: &mut Words) -> Result<u32> {
    let attributes = words.value("the number of attributes")?;
    if attributes > MOST_ATTRIBUTES {
        let problem = format!("{attributes} attributes are more than {MOST_ATTRIBUTES}");
        return Err(words.fault(problem));
    }
    Ok(attributes)
}

/// Marker 0 is the inside.
fn mark(draft: &mut Draft, nodes: &[u64], marker: i64) {
    if marker != 0 {
        let label = draft.label(&format!("surface:{marker}"));
        nodes.iter().for_each(|&node| draft.mark(node, label));
    }
}

fn end(words: &mut Words) -> Result<()> {
    match words.peek() {
        None => Ok(()),
        Some(_) => Err(words.fault("the file goes on where it should end: correct its counts")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NODES: &str = "# a comment\n5 3 1 1\n 1  0 0 0  0.5 2\n 2  1 0 0  0.5 2 # here too\n 3  0 1 0  0.5 2\n 4  0 0 1  0.5 0\n\n 5  1 1 1  0.5 0\n# Generated by tetgen\n";
    const TETS: &str = "2 4 1\n1  1 3 2 4  7\n2  2 3 4 5  -1\n";

    fn parse(nodes: &str, tets: &str, faces: Option<&str>) -> Result<TetFile> {
        let path = Path::new("mesh.ele");
        parse_tetgen(
            nodes.as_bytes(),
            tets.as_bytes(),
            faces.map(str::as_bytes),
            path,
        )
    }

    #[test]
    fn numbers_from_1_and_from_0_are_one_mesh() {
        let one = parse(NODES, TETS, None).unwrap();
        assert_eq!(one.labels, ["surface:2", "7", "-1"]);
        assert_eq!(one.tet_labels, [Some(1), Some(2)]);
        assert_eq!(one.marks, [(0, 0), (1, 0), (2, 0)]);
        // The first tet was inverted.
        assert_eq!(one.mesh.tets, [[0, 2, 3, 1], [1, 2, 3, 4]]);
        assert!((0..2).all(|t| one.mesh.volume(t) > 0.0));
        let nodes = "5 3 0 0\n0 0 0 0\n1 1 0 0\n2 0 1 0\n3 0 0 1\n4 1 1 1\n";
        let zero = parse(nodes, "2 4 0\n0 0 2 1 3\n1 1 2 3 4\n", None).unwrap();
        assert_eq!(zero.mesh, one.mesh);
    }

    #[test]
    fn marked_faces_mark_their_nodes() {
        let faces = "3 1\n1 1 2 3 9\n2 2 3 4 0\n3 2 4 5 -4 1 2\n";
        let file = parse(NODES, TETS, Some(faces)).unwrap();
        let label = |name: &str| file.labels.iter().position(|l| l == name).unwrap() as u32;
        let of = |name: &str| -> Vec<u32> {
            let marks = file.marks.iter().filter(|m| m.1 == label(name));
            marks.map(|m| m.0).collect()
        };
        assert_eq!(of("surface:9"), [0, 1, 2]);
        assert_eq!(of("surface:-4"), [1, 3, 4]);
    }

    #[test]
    fn broken_files_are_named_with_their_line() {
        let refused = |nodes: &str, tets: &str, hints: [&str; 2]| {
            let error = parse(nodes, tets, None).unwrap_err().to_string();
            assert!(hints.iter().all(|h| error.contains(h)), "{error}");
        };
        let edited = |text: &str, from: &str, to: &str| text.replacen(from, to, 1);
        refused(
            &edited(NODES, "5 3", "6 3"),
            TETS,
            ["mesh.node", "file ends"],
        );
        refused(
            &edited(NODES, "5 3", "4 3"),
            TETS,
            ["mesh.node: line 8", "goes on"],
        );
        refused(
            &edited(NODES, "5 3", "5 2"),
            TETS,
            ["mesh.node: line 2", "three dimensions"],
        );
        refused(
            &edited(NODES, "5 3 1", "5 3 99999"),
            TETS,
            ["mesh.node", "attributes"],
        );
        refused(
            &edited(NODES, "2  1 0", "1  1 0"),
            TETS,
            ["mesh.node: line 4", "twice"],
        );
        refused(
            &edited(NODES, "0 1 0 ", "0 one 0 "),
            TETS,
            ["mesh.node: line 5", "`one`"],
        );
        refused(
            &edited(NODES, "0 1 0 ", "0 inf 0 "),
            TETS,
            ["node 2", "no place"],
        );
        refused("0 3 0 0\n", TETS, ["mesh.node", "another file"]);
        refused(
            NODES,
            &edited(TETS, "2 4", "2 10"),
            ["mesh.ele: line 1", "-o2"],
        );
        refused(
            NODES,
            &edited(TETS, "3 4 5", "3 4 6"),
            ["mesh.ele: tet 1", "node 6"],
        );
        refused(
            NODES,
            &edited(TETS, "3 4 5", "3 4 4"),
            ["mesh.ele: tet 1", "different"],
        );
        refused(NODES, "0 4 0\n", ["mesh.ele: tets", "none"]);
    }
}
