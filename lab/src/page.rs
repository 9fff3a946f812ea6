//! What a figure shows and claims.

use super::{Bound, Check};
use serde::Serialize;
use supple::{Error, Result};
use supple_pictures::{Animation, Curves, Image};
use supple_scene::Report;

/// A figure's page: what is shown, in order, and what is checked.
#[derive(Clone, Debug, Default)]
pub struct Page {
    /// What is shown, from the top.
    pub blocks: Vec<Block>,
    /// What is checked.
    pub checks: Vec<Check>,
}

/// A part of a page.
#[derive(Clone, Debug)]
pub enum Block {
    /// A paragraph.
    Text(String),
    /// A picture.
    Picture {
        /// Name of its file, without extension; unique on the page.
        name: String,
        /// The picture.
        image: Image,
        /// What it shows, below it.
        caption: String,
    },
    /// A picture that moves.
    Animation {
        /// As a picture's.
        name: String,
        /// The pictures.
        animation: Animation,
        /// What it shows, below it.
        caption: String,
    },
    /// A table.
    Table(Table),
    /// Curves.
    Curves(Curves),
    /// Values for programs.
    Data {
        /// Name of its file, without extension; unique on the page.
        name: String,
        /// They, as JSON.
        json: String,
    },
}

/// Measured values in rows.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Table {
    /// What it shows, above it.
    pub caption: String,
    /// Names of the columns, with their units.
    pub columns: Vec<String>,
    /// Cells as they are shown.
    pub rows: Vec<Vec<String>>,
}

impl Page {
    /// A page that begins with a paragraph.
    pub fn new(text: impl Into<String>) -> Self {
        let mut page = Self::default();
        page.text(text);
        page
    }

    /// Adds a paragraph.
    pub fn text(&mut self, text: impl Into<String>) {
        self.blocks.push(Block::Text(text.into()));
    }

    /// Adds a picture; `name` becomes its file's.
    pub fn picture(&mut self, name: &str, image: Image, caption: impl Into<String>) {
        self.blocks.push(Block::Picture {
            name: name.into(),
            image,
            caption: caption.into(),
        });
    }

    /// Adds a picture that moves; `name` becomes its file's.
    pub fn animation(&mut self, name: &str, animation: Animation, caption: impl Into<String>) {
        self.blocks.push(Block::Animation {
            name: name.into(),
            animation,
            caption: caption.into(),
        });
    }

    /// Adds a table.
    pub fn table(&mut self, caption: &str, columns: &[&str], rows: Vec<Vec<String>>) {
        self.blocks.push(Block::Table(Table {
            caption: caption.into(),
            columns: columns.iter().map(|c| c.to_string()).collect(),
            rows,
        }));
    }

    /// Adds curves.
    pub fn curves(&mut self, curves: Curves) {
        self.blocks.push(Block::Curves(curves));
    }

    /// Adds values for programs; `name` becomes their file's.
    ///
    /// # Errors
    /// [`Error::Invalid`] where they cannot be written.
    pub fn data(&mut self, name: &str, values: &impl Serialize) -> Result<()> {
        let json = serde_json::to_string_pretty(values)
            .map_err(|e| Error::invalid(name, format!("cannot be written: {e}")))?;
        self.blocks.push(Block::Data {
            name: name.into(),
            json,
        });
        Ok(())
    }

    /// Adds a check.
    pub fn check(&mut self, what: impl Into<String>, value: f64, unit: &'static str, bound: Bound) {
        self.checks.push(Check {
            what: what.into(),
            value,
            unit,
            bound,
        });
    }

    /// Checks what every scene must keep, named with `of` behind: no tet inverted or nearly so, no joint apart.
    pub fn check_intact(&mut self, of: &str, report: &Report) {
        self.check(
            format!("smallest det F{of}"),
            report.det_f(),
            "",
            Bound::AtLeast(0.05),
        );
        self.check(
            format!("joint gap{of}"),
            report.max_joint_gap_mm,
            "mm",
            Bound::AtMost(1.0),
        );
    }

    /// The checks that fail.
    pub fn failures(&self) -> impl Iterator<Item = &Check> {
        self.checks.iter().filter(|c| !c.holds())
    }
}
