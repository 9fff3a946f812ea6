//! No two files of a folder import each other: each takes from files above it in the table of its folder's docs, the one
//! place that states the order.

use std::path::Path;

/// The rows `| file | … |` of a folder's docs, from the top.
fn order(docs: &str) -> Vec<&str> {
    docs.lines()
        .filter_map(|line| line.strip_prefix("//! | `")?.split('`').next())
        .collect()
}

/// The siblings that `source` names outside its tests.
fn siblings(source: &str) -> Vec<&str> {
    let code = source.split("#[cfg(test)]\nmod ").next().unwrap();
    code.lines()
        .filter(|line| !line.trim_start().starts_with("//"))
        .flat_map(|line| line.split("super::").skip(1))
        .map(|rest| {
            rest.split(|c: char| !c.is_alphanumeric() && c != '_')
                .next()
                .unwrap()
        })
        .collect()
}

/// What `file` imports from its own row of `order` or below, or past the table.
fn upward<'a>(order: &[&str], file: &str, source: &'a str) -> Vec<&'a str> {
    let row = |name: &str| order.iter().position(|o| *o == name);
    let own = row(file);
    siblings(source)
        .into_iter()
        .filter(|name| row(name) >= own || row(name).is_none())
        .collect()
}

#[test]
fn files_import_from_those_above_them() {
    for folder in ["src/sim", "src/skeleton"] {
        let docs = std::fs::read_to_string(Path::new(folder).join("mod.rs")).unwrap();
        let order = order(&docs);
        let entries = std::fs::read_dir(folder).unwrap().count();
        assert_eq!(order.len() + 1, entries, "{folder}: files in the table");
        for file in &order {
            let path = Path::new(folder).join(file);
            let of_folder = std::fs::read_to_string(path.join("mod.rs"));
            let source = of_folder
                .or_else(|_| std::fs::read_to_string(path.with_extension("rs")))
                .unwrap();
            let found = upward(&order, file, &source);
            assert!(found.is_empty(), "{folder}/{file} imports {found:?}");
        }
    }
}

#[test]
fn a_circle_is_noticed() {
    let order = ["line_search", "newton"];
    assert!(upward(&order, "newton", "use super::line_search::LineSearch;").is_empty());
    for source in ["use super::newton::Newton;", "use super::Simulation;"] {
        assert_eq!(upward(&order, "line_search", source).len(), 1, "{source}");
    }
}
