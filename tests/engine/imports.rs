//! Imports run downward only: a room may use rooms of its own rank or below. The ranks are read from
//! the table in the crate's front-page docs, the one place that states them.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// Module → rank, from the rows `| rank | modules | … |` of src/lib.rs.
fn ranks(front_page: &str) -> HashMap<String, usize> {
    let mut ranks = HashMap::new();
    for line in front_page.lines().filter_map(|l| l.strip_prefix("//! | ")) {
        let cells: Vec<&str> = line.split('|').map(str::trim).collect();
        if let Ok(rank) = cells[0].parse() {
            for name in cells[1].split('`').skip(1).step_by(2) {
                ranks.insert(name.to_owned(), rank);
            }
        }
    }
    ranks
}

/// Every `crate::module` that `source` names outside its tests and comments.
fn imports(source: &str) -> Vec<String> {
    let code = source
        .split("#[cfg(test)]\nmod ")
        .next()
        .unwrap_or_default();
    code.lines()
        .filter(|line| !line.trim_start().starts_with("//"))
        .flat_map(|line| line.split("crate::").skip(1))
        .map(|rest| {
            rest.chars()
                .take_while(|c| c.is_alphanumeric() || *c == '_')
                .collect()
        })
        .filter(|name: &String| name.starts_with(char::is_lowercase))
        .collect()
}

/// Imports of `source`, a file of `room`, that run up.
fn upward(room: &str, source: &str, ranks: &HashMap<String, usize>) -> Vec<String> {
    let own = ranks[room];
    imports(source)
        .into_iter()
        .filter(|name| ranks.get(name).is_some_and(|&r| r > own))
        .collect()
}

fn files(folder: &Path, out: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            files(&path, out);
        } else if path.extension().is_some_and(|e| e == "rs") {
            out.push(path);
        }
    }
}

#[test]
fn imports_run_downward() {
    let ranks = ranks(include_str!("../../src/lib.rs"));
    let mut sources = Vec::new();
    files(Path::new("src"), &mut sources);
    let mut checked = 0;
    for path in sources {
        let inside = path.strip_prefix("src").unwrap();
        let room = inside
            .components()
            .next()
            .unwrap()
            .as_os_str()
            .to_str()
            .unwrap();
        let room = room.trim_end_matches(".rs");
        if matches!(room, "lib" | "main") {
            continue;
        }
        assert!(
            ranks.contains_key(room),
            "src/{room} has no rank in src/lib.rs"
        );
        let up = upward(room, &std::fs::read_to_string(&path).unwrap(), &ranks);
        assert!(up.is_empty(), "{} imports upward: {up:?}", path.display());
        checked += 1;
    }
    assert!(checked > 20, "only {checked} files were read");
}

#[test]
fn an_upward_import_is_noticed() {
    let ranks = ranks(include_str!("../../src/lib.rs"));
    let source = "use crate::math::Rows;\nuse crate::sim::Simulation;\n";
    assert_eq!(upward("model", source, &ranks), ["sim"]);
    assert!(upward("internal", source, &ranks).is_empty());
}
