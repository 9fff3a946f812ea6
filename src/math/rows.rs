//! Compressed rows: many short lists in two flat arrays.

use crate::{Error, Result};
use serde::{Deserialize, Serialize};

/// A list of short lists; row `i` is `entries[offsets[i]..offsets[i + 1]]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Rows<T> {
    offsets: Vec<u32>,
    entries: Vec<T>,
}

impl<T> Default for Rows<T> {
    fn default() -> Self {
        Self {
            offsets: vec![0],
            entries: Vec::new(),
        }
    }
}

impl<T> Rows<T> {
    /// Number of rows.
    pub fn len(&self) -> usize {
        // What was read from a file and not yet validated may have no offset at all.
        self.offsets.len().saturating_sub(1)
    }

    /// Whether there is no row.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Row `i`.
    pub fn row(&self, i: usize) -> &[T] {
        &self.entries[self.range(i)]
    }

    /// Where row `i` lies in [`Rows::entries`].
    pub fn range(&self, i: usize) -> std::ops::Range<usize> {
        self.offsets[i] as usize..self.offsets[i + 1] as usize
    }

    /// All rows in order.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = &[T]> {
        self.offsets
            .windows(2)
            .map(|w| &self.entries[w[0] as usize..w[1] as usize])
    }

    /// Row starts, one more than there are rows.
    pub fn offsets(&self) -> &[u32] {
        &self.offsets
    }

    /// All entries, row after row.
    pub fn entries(&self) -> &[T] {
        &self.entries
    }

    /// Appends a row.
    pub fn push(&mut self, row: impl IntoIterator<Item = T>) {
        self.entries.extend(row);
        self.offsets.push(self.entries.len() as u32);
    }

    /// The same rows with every entry mapped.
    pub fn map<U>(&self, f: impl FnMut(&T) -> U) -> Rows<U> {
        Rows {
            offsets: self.offsets.clone(),
            entries: self.entries.iter().map(f).collect(),
        }
    }

    /// Length of the longest row.
    pub fn longest(&self) -> usize {
        self.iter().map(<[T]>::len).max().unwrap_or(0)
    }

    /// Checks that the offsets rise from 0 to the number of entries and that there are `rows` rows.
    pub fn validate(&self, field: &str, rows: usize) -> Result<()> {
        let rising = self.offsets.windows(2).all(|w| w[0] <= w[1]);
        let ends = self.offsets.first() == Some(&0)
            && self.offsets.last().copied() == u32::try_from(self.entries.len()).ok();
        if !(rising && ends) {
            return Err(Error::invalid(
                field,
                "row offsets do not partition the entries",
            ));
        }
        if self.len() != rows {
            return Err(Error::invalid(
                field,
                format!("{} rows, expected {rows}", self.len()),
            ));
        }
        Ok(())
    }
}

impl<T, R: IntoIterator<Item = T>> FromIterator<R> for Rows<T> {
    fn from_iter<I: IntoIterator<Item = R>>(rows: I) -> Self {
        let mut out = Self::default();
        rows.into_iter().for_each(|row| out.push(row));
        out
    }
}
