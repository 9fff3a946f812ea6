//! Tetrahedral meshes as text, the bone press benchmark's format.
//!
//! A line `nodes tets pinned surface` with the four counts; a line `x y z` (m) for each node; a line
//! `a b c d` for each tet; one line with the indices of the pinned nodes and one with those of the
//! surface nodes. Indices start at 0.

use super::checks::{check_topology, is_place, orient, used_nodes};
use crate::file::read_text;
use glam::DVec3;
use std::path::Path;
use supple::model::TetMesh;
use supple::{Error, Result};

/// What such a file holds.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TetMeshFile {
    /// Nodes and positively oriented tets.
    pub mesh: TetMesh,
    /// Nodes held by the bone.
    pub pinned: Vec<u32>,
    /// Nodes of the skin.
    pub surface: Vec<u32>,
}

/// Reads the mesh at `path`. Inverted tets are turned round.
///
/// # Errors
/// [`Error::Io`] where the file cannot be read, [`Error::Format`] with the line where it is broken:
/// a count that the file does not keep, a number that is not one, an index out of range, a flat or
/// repeated tet, a face of three tets, a node of none.
pub fn read_tet_mesh(path: impl AsRef<Path>) -> Result<TetMeshFile> {
    let path = path.as_ref();
    parse_tet_mesh(&read_text(path)?, path)
}

/// Reads a mesh from `text`; `path` names it in errors. See [`read_tet_mesh`].
pub fn parse_tet_mesh(text: &str, path: &Path) -> Result<TetMeshFile> {
    let mut lines = Lines {
        path,
        number: 0,
        lines: text.lines(),
    };
    let [nodes, tets, pinned, surface] = lines.values::<usize, 4>("the four counts")?;
    // The shortest node line has 6 bytes and the shortest tet line 8: no count beyond the text
    // itself makes this reserve memory.
    if nodes > text.len() / 5 || tets > text.len() / 7 || nodes.max(tets) >= u32::MAX as usize / 4 {
        return Err(lines.fault("announces more than the file can hold: correct the counts"));
    }
    let mut mesh = TetMesh {
        nodes: Vec::with_capacity(nodes),
        tets: Vec::with_capacity(tets),
    };
    for _ in 0..nodes {
        let node = DVec3::from_array(lines.values::<f64, 3>("a node's x, y, z")?);
        if !is_place(node) {
            return Err(lines.fault("is no place in metres: mend the coordinates"));
        }
        mesh.nodes.push(node);
    }
    let first_tet_line = lines.number + 1;
    for t in 0..tets {
        let tet = lines.values::<u32, 4>("a tet's four nodes")?;
        mesh.tets.push(tet);
        let repeated = (1..4).any(|i| tet[..i].contains(&tet[i]));
        if repeated || tet.iter().any(|&n| n as usize >= nodes) {
            return Err(lines.fault(format!(
                "needs four different nodes below {nodes}: correct the indices (they start at 0)"
            )));
        }
        orient(&mut mesh, t).map_err(|problem| lines.fault(problem))?;
    }
    let pinned = lines.indices(pinned, nodes, "pinned")?;
    let surface = lines.indices(surface, nodes, "surface")?;
    if let Some(extra) = lines.rest() {
        return Err(extra);
    }
    check_topology(&mesh).map_err(|(tet, problem)| {
        Error::format(path, format!("line {}", first_tet_line + tet), problem)
    })?;
    if let Some(n) = used_nodes(&mesh).iter().position(|used| !used) {
        let problem = format!("node {n} is in no tet: remove it");
        return Err(Error::format(path, "tets", problem));
    }
    Ok(TetMeshFile {
        mesh,
        pinned,
        surface,
    })
}

/// The file's lines with their numbers.
struct Lines<'a> {
    path: &'a Path,
    number: usize,
    lines: std::str::Lines<'a>,
}

impl<'a> Lines<'a> {
    fn fault(&self, problem: impl Into<String>) -> Error {
        Error::format(self.path, format!("line {}", self.number), problem)
    }

    fn next(&mut self, what: &str) -> Result<&'a str> {
        self.number += 1;
        (self.lines.next()).ok_or_else(|| {
            self.fault(format!(
                "the file ends where {what} should stand: complete it or correct the counts"
            ))
        })
    }

    /// Exactly `N` numbers on the next line.
    fn values<T: std::str::FromStr, const N: usize>(&mut self, what: &str) -> Result<[T; N]> {
        let line = self.next(what)?;
        let mut words = line.split_ascii_whitespace();
        let values: Option<Vec<T>> = (words.by_ref().take(N)).map(|w| w.parse().ok()).collect();
        values
            .and_then(|values| values.try_into().ok())
            .filter(|_| words.next().is_none())
            .ok_or_else(|| self.fault(format!("should hold {what} ({N} numbers)")))
    }

    /// A line of `count` different node indices.
    fn indices(&mut self, count: usize, nodes: usize, what: &str) -> Result<Vec<u32>> {
        let line = self.next(&format!("the {what} list"))?;
        let mut seen = vec![false; nodes];
        let mut indices = Vec::with_capacity(count.min(nodes));
        for word in line.split_ascii_whitespace() {
            let index = word.parse::<u32>().ok().filter(|&i| (i as usize) < nodes);
            let Some(index) = index else {
                let shown: String = word.chars().take(20).collect();
                return Err(self.fault(format!(
                    "{what}: `{shown}` is no node: write indices below {nodes}"
                )));
            };
            if std::mem::replace(&mut seen[index as usize], true) {
                return Err(self.fault(format!("{what}: {index} stands twice: remove one")));
            }
            indices.push(index);
        }
        if indices.len() != count {
            return Err(self.fault(format!(
                "{what}: {} indices where the first line announces {count}: correct one of them",
                indices.len()
            )));
        }
        Ok(indices)
    }

    /// The error of the first line that is not blank, if there is one.
    fn rest(&mut self) -> Option<Error> {
        while let Some(line) = self.lines.next() {
            self.number += 1;
            if !line.trim().is_empty() {
                return Some(self.fault("stands after the surface list: correct the counts"));
            }
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use proptest::test_runner::RngSeed;

    const TWO_TETS: &str =
        "5 2 1 3\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 1 1\n0 1 2 3\n1 2 3 4\n0\n1 2 3\n";

    fn parse(text: &str) -> Result<TetMeshFile> {
        parse_tet_mesh(text, Path::new("mesh.txt"))
    }

    #[test]
    fn reads_and_orients() {
        let file = parse(TWO_TETS).unwrap();
        assert_eq!((file.pinned, file.surface), (vec![0], vec![1, 2, 3]));
        assert!((0..2).all(|t| file.mesh.volume(t) > 0.0));
        let turned = parse(&TWO_TETS.replace("0 1 2 3\n1", "0 2 1 3\n1")).unwrap();
        assert_eq!(turned.mesh.tets[0], [0, 2, 3, 1]);
    }

    #[test]
    fn names_the_line_and_the_cure() {
        for (from, to, line, cure) in [
            ("5 2 1 3", "5 2 1", "line 1", "four counts"),
            ("5 2 1 3", "5 999999999 1 3", "line 1", "correct the counts"),
            ("1 0 0\n0 1", "1 nan 0\n0 1", "line 3", "coordinates"),
            ("1 0 0\n0 1", "1 O 0\n0 1", "line 3", "x, y, z"),
            ("0 1 2 3\n1", "0 1 2 9\n1", "line 7", "below 5"),
            ("0 1 2 3\n1", "0 1 2 2\n1", "line 7", "different"),
            ("1 1 1\n", "0.5 0.5 0\n", "line 8", "flat"),
            ("1 2 3 4\n0", "3 1 2 0\n0", "line 8", "repeats"),
            ("\n1 2 3\n", "\n1 2 2\n", "line 10", "twice"),
            ("\n1 2 3\n", "\n1 2\n", "line 10", "announces 3"),
            (
                "\n1 2 3\n",
                "\n1 2 3\n\n4\n",
                "line 12",
                "after the surface",
            ),
            ("\n1 2 3\n", "\n", "line 10", "file ends"),
            (
                "5 2 1 3\n",
                "6 2 1 3\n7 7 7\n",
                "tets",
                "node 0 is in no tet",
            ),
        ] {
            let broken = TWO_TETS.replacen(from, to, 1);
            let broken = match to {
                // One node more at the front shifts every index.
                "6 2 1 3\n7 7 7\n" => {
                    broken.replace("\n0 1 2 3\n1 2 3 4\n", "\n1 2 3 4\n2 3 4 5\n")
                }
                _ => broken,
            };
            let message = parse(&broken).expect_err(to).to_string();
            assert!(
                message.contains(line) && message.contains(cure),
                "{to:?}: {message}"
            );
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig {
            cases: 2000,
            rng_seed: RngSeed::Fixed(1),
            failure_persistence: None,
            ..ProptestConfig::default()
        })]
        #[test]
        fn mutations_never_panic_and_what_passes_is_sound(
            edits in prop::collection::vec((0usize..TWO_TETS.len(), 0usize..16), 1..6)
        ) {
            let mut text = TWO_TETS.as_bytes().to_vec();
            for (at, with) in edits {
                let at = at % text.len();
                match b"0123456789.-e \n" .get(with) {
                    Some(&byte) => text[at] = byte,
                    None => { text.remove(at); }
                }
            }
            if let Ok(file) = parse(std::str::from_utf8(&text).unwrap()) {
                prop_assert!((0..file.mesh.tets.len()).all(|t| file.mesh.volume(t) > 0.0));
                prop_assert!(file.pinned.iter().chain(&file.surface).all(|&n| (n as usize) < file.mesh.nodes.len()));
            }
        }
    }

    #[test]
    fn a_missing_or_binary_file_is_an_error() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("mesh.txt");
        assert!(matches!(read_tet_mesh(&path), Err(Error::Io { .. })));
        std::fs::write(&path, [b'1', 0xff, 0xfe]).unwrap();
        assert!(matches!(read_tet_mesh(&path), Err(Error::Format { .. })));
    }
}
