//! The tables of keys in docs/recipes.md and docs/scenes.md say what the types read, no key more and no key less.
//!
//! What a type reads is asked of serde: a key or a value that it does not know makes it list those that it does. A table
//! names the keys that it is about in a comment before it, `<!-- keys: scene.output.panels[] -->`.

use serde::de::DeserializeOwned;
use std::collections::{BTreeMap, BTreeSet};
use supple_scene::{AvatarSource, Scene};

type Names = BTreeSet<String>;

/// A key and a value that no type knows.
const UNKNOWN: &str = "not_a_key";

/// What may stand in one place of a file.
#[derive(Debug, PartialEq)]
enum Kind {
    /// A table of these keys.
    Keys(Names),
    /// One of these words, or a table of one of these keys.
    Variants(Names),
    /// A table whose key of this name says which of its variants it is.
    Tagged(String),
    /// Numbers, text, lists of them, free tables.
    Plain,
}

/// What serde says that it expected in `text`.
fn ask<T: DeserializeOwned>(text: &str) -> Kind {
    let Err(error) = toml::from_str::<T>(text) else {
        return Kind::Plain;
    };
    let message = error.message();
    let known = |rest: &str| {
        let words = rest.split('`').skip(1).step_by(2);
        words.map(str::to_owned).collect()
    };
    if let Some(rest) = message.strip_prefix(&format!("unknown field `{UNKNOWN}`")) {
        Kind::Keys(known(rest))
    } else if let Some(rest) = message.strip_prefix(&format!("unknown variant `{UNKNOWN}`")) {
        Kind::Variants(known(rest))
    } else if let Some(rest) = message.strip_prefix("missing field `") {
        Kind::Tagged(rest.trim_end_matches('`').to_owned())
    } else {
        Kind::Plain
    }
}

/// A row of a table: what stands in backticks.
#[derive(Clone, Debug, Default)]
struct Row {
    /// The words of the first cell.
    keys: Names,
    /// Of the second.
    second: Names,
    /// Of all but the first.
    words: Names,
    /// Those of them that stand in quotes, as values of a key do.
    quoted: Names,
}

impl Row {
    fn of(line: &str) -> Self {
        let cells: Vec<&str> = line.trim_matches('|').split('|').collect();
        let code = |cell: &str| -> Vec<String> {
            let spans = cell.split('`').skip(1).step_by(2);
            spans.map(str::to_owned).collect()
        };
        // The first word of each level: `{ lattice = { cell = 0.004 } }` names lattice and cell.
        let words = |cell: &str| -> Names {
            let word = |part: &str| {
                let part = part.split('=').next().unwrap_or_default();
                part.trim_matches([' ', '"', '}']).to_owned()
            };
            let spans = code(cell);
            let parts = spans.iter().flat_map(|s| s.split(['{', ',']).map(word));
            parts.filter(|w| !w.is_empty()).collect()
        };
        let rest = || cells.iter().skip(1);
        let quoted = |s: String| Some(s.strip_prefix('"')?.strip_suffix('"')?.to_owned());
        Self {
            keys: words(cells[0]),
            second: words(cells.get(1).unwrap_or(&"")),
            words: rest().flat_map(|cell| words(cell)).collect(),
            quoted: rest()
                .flat_map(|cell| code(cell).into_iter().filter_map(quoted))
                .collect(),
        }
    }
}

/// The rows of each table, by what its comment names.
fn tables(pages: &str) -> BTreeMap<String, Vec<Row>> {
    let mut tables = BTreeMap::new();
    let mut lines = pages.lines();
    while let Some(line) = lines.next() {
        let Some(about) = line.strip_prefix("<!-- keys: ") else {
            continue;
        };
        let table = lines.by_ref().skip_while(|l| l.is_empty());
        let rows: Vec<Row> = (table.take_while(|l| l.starts_with('|')).skip(2))
            .map(Row::of)
            .collect();
        for path in about.trim_end_matches(" -->").split(", ") {
            let before = tables.insert(path.to_owned(), rows.clone());
            assert!(before.is_none(), "{path} has two tables");
        }
    }
    tables
}

/// Goes through a type, and compares it with the tables.
struct Comparison<'a> {
    ask: fn(&str) -> Kind,
    tables: &'a BTreeMap<String, Vec<Row>>,
    seen: Names,
    problems: Vec<String>,
}

impl Comparison<'_> {
    /// Compares what may stand at `path`, the value of the key of `row`; `text` is a file with a given value there.
    fn compare(&mut self, path: &str, row: &Row, text: &dyn Fn(&str) -> String) {
        let unknown = format!("{{ {UNKNOWN} = 0 }}");
        for list in [false, true] {
            let inside = |value: &str| match list {
                true => text(&format!("[{value}]")),
                false => text(value),
            };
            let kind = (self.ask)(&inside(&unknown));
            if kind != Kind::Plain {
                let path = format!("{path}{}", if list { "[]" } else { "" });
                return self.compare_kind(&path, kind, row, &inside);
            }
        }
    }

    fn compare_kind(&mut self, path: &str, kind: Kind, row: &Row, text: &dyn Fn(&str) -> String) {
        match kind {
            Kind::Plain => {}
            Kind::Keys(keys) => {
                let rows = self.rows(path, &keys);
                // The same type under another name: its inner tables are compared there.
                if path == "scene.avatar" {
                    return;
                }
                for key in keys {
                    let row = row_of(&rows, &key);
                    let inside = |v: &str| text(&format!("{{ {key} = {v} }}"));
                    self.compare(&format!("{path}.{key}"), &row, &inside);
                }
            }
            Kind::Variants(variants) => {
                let has_keys = |v: &String| {
                    let text = text(&format!("{{ {v} = {{ {UNKNOWN} = 0 }} }}"));
                    (self.ask)(&text) != Kind::Plain
                };
                if variants.iter().any(has_keys) {
                    return self.compare_kind(path, Kind::Keys(variants), row, text);
                }
                let undocumented: Vec<_> = variants.difference(&row.words).collect();
                let unread: Vec<_> = row.quoted.difference(&variants).collect();
                if !undocumented.is_empty() {
                    self.problem(format!("{path}: not documented: {undocumented:?}"));
                }
                if !unread.is_empty() {
                    self.problem(format!("{path}: documented, never read: {unread:?}"));
                }
            }
            Kind::Tagged(tag) => {
                let ask = self.ask;
                let Kind::Variants(variants) = ask(&text(&format!("{{ {tag} = '{UNKNOWN}' }}")))
                else {
                    return self.problem(format!("{path}.{tag}: lists no variants"));
                };
                let rows = self.rows(path, &variants);
                for variant in variants {
                    let text = text(&format!("{{ {tag} = '{variant}', {UNKNOWN} = 0 }}"));
                    let keys = match ask(&text) {
                        Kind::Keys(keys) => keys,
                        _ => Names::new(),
                    };
                    let documented = row_of(&rows, &variant).second;
                    if keys != documented {
                        let problem =
                            format!("{path}: {variant} reads {keys:?}, documented {documented:?}");
                        self.problem(problem);
                    }
                }
            }
        }
    }

    /// The rows of the table about `path`, whose first cells must name `expected`.
    fn rows(&mut self, path: &str, expected: &Names) -> Vec<Row> {
        self.seen.insert(path.to_owned());
        let Some(rows) = self.tables.get(path) else {
            self.problem(format!("{path} has no table; its keys are {expected:?}"));
            return Vec::new();
        };
        let documented: Names = rows.iter().flat_map(|r| r.keys.clone()).collect();
        let undocumented: Vec<_> = expected.difference(&documented).collect();
        let unread: Vec<_> = documented.difference(expected).collect();
        if !undocumented.is_empty() {
            self.problem(format!("{path}: not documented: {undocumented:?}"));
        }
        if !unread.is_empty() {
            self.problem(format!("{path}: documented, never read: {unread:?}"));
        }
        rows.clone()
    }

    fn problem(&mut self, problem: String) {
        self.problems.push(problem);
    }
}

fn row_of(rows: &[Row], key: &str) -> Row {
    let row = rows.iter().find(|r| r.keys.contains(key));
    row.cloned().unwrap_or_default()
}

/// What the pages get wrong, and the tables that were compared.
fn problems(pages: &str) -> (Vec<String>, usize) {
    let tables = tables(pages);
    let mut problems = Vec::new();
    let mut seen = Names::new();
    for (root, ask) in [
        ("scene", ask::<Scene> as fn(&str) -> Kind),
        ("recipe", ask::<AvatarSource>),
    ] {
        let mut comparison = Comparison {
            ask,
            tables: &tables,
            seen: Names::new(),
            problems: Vec::new(),
        };
        // A file is a table without its braces.
        let file = |value: &str| value[1..value.len() - 1].to_owned();
        comparison.compare(root, &Row::default(), &file);
        seen.extend(comparison.seen);
        problems.extend(comparison.problems);
    }
    let stale = tables.keys().filter(|path| !seen.contains(*path));
    problems.extend(stale.map(|path| format!("{path}: a table about what is not there")));
    (problems, seen.len())
}

const PAGES: &str = concat!(
    include_str!("../../../../docs/recipes.md"),
    include_str!("../../../../docs/scenes.md"),
);

#[test]
fn every_key_is_documented_and_every_documented_key_is_read() {
    let (problems, tables) = problems(PAGES);
    assert!(problems.is_empty(), "{problems:#?}");
    assert!(tables > 25, "only {tables} tables were compared");
}

/// Each edit of the pages is one mistake that must be noticed.
#[test]
fn what_the_pages_get_wrong_is_noticed() {
    let cases = [
        (
            "| `density` | 1000 | of tissue",
            "| | | of tissue",
            "recipe.bake: not documented: [\"density\"]",
        ),
        (
            "| `soft` | 0 |",
            "| `soft`, `hard` | 0 |",
            "recipe.bake.handles[]: documented, never read: [\"hard\"]",
        ),
        (
            "| `loop` |",
            "| `repeat` |",
            "scene.motion: not documented: [\"loop\"]",
        ),
        (
            "(`\"volume\"`)",
            "(volume)",
            "recipe.bake.handles[].candidates: not documented: [\"volume\"]",
        ),
        (
            "(`\"hold\"`)",
            "(`\"hold\"`, `\"keep\"`)",
            "scene.motion.root: documented, never read: [\"keep\"]",
        ),
        (
            "{ nodes = 20000 }",
            "{ knots = 20000 }",
            "recipe.bake.mesher.lattice: not documented: [\"nodes\"]",
        ),
        (
            "| `\"box\"` | `half_extents` |",
            "| `\"box\"` | `extents` |",
            "scene.colliders[].shape: box reads",
        ),
        (
            "<!-- keys: scene.output.cut -->",
            "",
            "scene.output.cut has no table",
        ),
        (
            "<!-- keys: scene.measure -->",
            "<!-- keys: scene.measure, scene.measures -->",
            "scene.measures: a table",
        ),
        (
            "| `scale` | 1 |",
            "| | 1 |",
            "scene.avatar: not documented: [\"scale\"]",
        ),
    ];
    for (from, to, expected) in cases {
        assert!(PAGES.contains(from), "{from}");
        let (problems, _) = problems(&PAGES.replacen(from, to, 1));
        let noticed = problems.iter().any(|p| p.starts_with(expected));
        assert!(noticed, "{from} → {to}: {problems:#?}");
    }
}
