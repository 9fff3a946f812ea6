//! Figures run one after the other, and the page about them.

use super::html::index;
use super::{Block, Check, Figure, Page, Runner, Table};
use serde::Serialize;
use std::path::Path;
use supple::internal::math::Stopwatch;
use supple::internal::write_whole;
use supple::{Error, Result};

/// What came of a run of figures; `figures.json`.
#[derive(Clone, Debug, Serialize)]
pub struct Summary {
    /// `small` or `full`.
    pub size: &'static str,
    /// What it ran on.
    pub machine: String,
    /// How each figure went.
    pub figures: Vec<Verdict>,
}

/// What came of a figure.
#[derive(Clone, Debug, Serialize)]
pub struct Verdict {
    /// The figure.
    pub name: &'static str,
    /// Its title.
    pub title: &'static str,
    /// Its number in the paper.
    pub paper: &'static str,
    /// Wall-clock time, s.
    pub seconds: f64,
    /// Why it could not be drawn, if it could not.
    pub error: Option<String>,
    /// What was checked.
    pub checks: Vec<Check>,
    /// What was measured.
    pub tables: Vec<Table>,
}

impl Verdict {
    /// Whether it was drawn and all of its checks hold.
    pub fn holds(&self) -> bool {
        self.error.is_none() && self.checks.iter().all(Check::holds)
    }
}

impl Summary {
    /// How many checks hold, and of how many; a figure that could not be drawn counts as one that does not.
    pub fn checks(&self) -> (usize, usize) {
        let held = |v: &Verdict| v.checks.iter().filter(|c| c.holds()).count();
        let all = |v: &Verdict| v.checks.len() + usize::from(v.error.is_some());
        let figures = self.figures.iter();
        (figures.clone().map(held).sum(), figures.map(all).sum())
    }
}

/// Draws `figures` with `runner` and writes `index.html` with its pictures, and `figures.json`, into `folder`.
/// Both are written anew after every figure, which `done` then hears about: what is cut off leaves the page of
/// what was drawn. A figure that fails is said to have failed, and the others are drawn.
///
/// # Errors
/// [`Error::Io`] of the folder.
pub fn write_gallery(
    figures: &[&Figure],
    runner: &Runner,
    folder: &Path,
    done: &mut dyn FnMut(&Verdict),
) -> Result<Summary> {
    make_folder(folder)?;
    let mut summary = Summary {
        size: runner.pick("small", "full"),
        machine: machine(),
        figures: Vec::new(),
    };
    let mut pages = Vec::new();
    for figure in figures {
        let watch = Stopwatch::start();
        let drawn = (figure.draw)(runner);
        let (page, error) = match drawn {
            Ok(page) => (page, None),
            Err(e) => (Page::default(), Some(e.to_string())),
        };
        write_pictures(&page, &folder.join(figure.name))?;
        let tables = page.blocks.iter().filter_map(|block| match block {
            Block::Table(table) => Some(table.clone()),
            _ => None,
        });
        let verdict = Verdict {
            name: figure.name,
            title: figure.title,
            paper: figure.paper,
            seconds: 1e-3 * watch.ms(),
            error,
            checks: page.checks.clone(),
            tables: tables.collect(),
        };
        done(&verdict);
        summary.figures.push(verdict);
        pages.push(page);
        write_whole(folder.join("index.html"), index(&summary, &pages)?)?;
        let json = serde_json::to_string_pretty(&summary)
            .map_err(|e| Error::invalid("figures.json", e.to_string()))?;
        write_whole(folder.join("figures.json"), json)?;
    }
    Ok(summary)
}

/// The page's pictures as PNG files in `folder`.
fn write_pictures(page: &Page, folder: &Path) -> Result<()> {
    make_folder(folder)?;
    for block in &page.blocks {
        let path = |name: &String| folder.join(name).with_extension("png");
        match block {
            Block::Picture { name, image, .. } => image.write_png(&path(name))?,
            Block::Animation {
                name, animation, ..
            } => animation.write_png(&path(name))?,
            Block::Data { name, json } => {
                write_whole(folder.join(name).with_extension("json"), json.as_bytes())?;
            }
            _ => {}
        }
    }
    Ok(())
}

fn make_folder(path: &Path) -> Result<()> {
    std::fs::create_dir_all(path).map_err(|e| Error::io(path, e))
}

/// The processor, how many threads it runs, and the system.
fn machine() -> String {
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let model = std::fs::read_to_string("/proc/cpuinfo")
        .ok()
        .and_then(|text| {
            let line = text.lines().find(|l| l.starts_with("model name"))?;
            Some(line.split_once(':')?.1.trim().to_string())
        });
    let (system, architecture) = (std::env::consts::OS, std::env::consts::ARCH);
    let model = model.unwrap_or_else(|| architecture.into());
    format!("{model}, {threads} threads, {system}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check::Bound;
    use crate::runner::Size;
    use supple_pictures::{Curves, Image};

    fn good(_: &Runner) -> Result<Page> {
        let mut page = Page::new("a < b");
        page.picture("grey", Image::new(8, 4, [0.5; 3]), "\"grey\"");
        page.table("sizes", &["n", "mm"], vec![vec!["1".into(), "2".into()]]);
        page.curves(Curves::new("c", "s", "m").line("l", [(0.0, 1.0), (1.0, 2.0)]));
        page.check("length", 2.0, "mm", Bound::AtMost(3.0));
        page.check("force", 2.0, "N", Bound::AtLeast(3.0));
        Ok(page)
    }

    fn broken(_: &Runner) -> Result<Page> {
        Err(Error::invalid("scene", "is not there"))
    }

    /// A figure that cannot be drawn does not take the others with it, and counts.
    #[test]
    fn a_gallery_tells_what_holds_and_what_fails() {
        let figure = |name, draw| Figure {
            name,
            title: "T & U",
            paper: "",
            draw,
        };
        let (broken, good) = (figure("broken", broken), figure("good", good));
        let folder = tempfile::tempdir().unwrap();
        let runner = Runner::new(Size::Small, "", "", |_| {});
        let mut seen = Vec::new();
        let summary = write_gallery(&[&broken, &good], &runner, folder.path(), &mut |v| {
            seen.push((v.name, v.holds()));
        })
        .unwrap();
        assert_eq!(seen, [("broken", false), ("good", false)]);
        assert_eq!(summary.checks(), (1, 3));
        let read = |name: &str| std::fs::read_to_string(folder.path().join(name)).unwrap();
        let page = read("index.html");
        for told in [
            "1 of 3 checks hold",
            "Not drawn: scene: is not there",
            "a &lt; b",
            "T &amp; U",
            "src=\"good/grey.png\" alt=\"&quot;grey&quot;\" width=\"8\" height=\"4\"",
            "<td>2 N</td><td>≥ 3 N</td><td class=\"fail\">fails</td>",
            "<svg",
        ] {
            assert!(page.contains(told), "{told} in {page}");
        }
        assert!(folder.path().join("good/grey.png").exists());
        let json: serde_json::Value = serde_json::from_str(&read("figures.json")).unwrap();
        assert_eq!(json["figures"][1]["checks"][1]["bound"]["at_least"], 3.0);
        assert_eq!(json["figures"][1]["tables"][0]["rows"][0][1], "2");
    }
}
