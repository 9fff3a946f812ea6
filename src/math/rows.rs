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
    pub fn iter(&self) -> impl ExactSizeIterator<Item = &[T]> + Clone {
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

    /// Appends a row if there is anything in it, sorted by `key`; whether there was.
    pub fn push_some<K: Ord>(
        &mut self,
        row: impl IntoIterator<Item = T>,
        key: impl FnMut(&T) -> K,
    ) -> bool {
        let before = self.entries.len();
        self.entries.extend(row);
        if self.entries.len() == before {
            return false;
        }
        self.entries[before..].sort_unstable_by_key(key);
        self.offsets.push(self.entries.len() as u32);
        true
    }

    /// Takes all rows out; the memory stays.
    pub fn clear(&mut self) {
        self.offsets.clear();
        self.offsets.push(0);
        self.entries.clear();
    }

    /// `rows` rows of the `items`, each in the row that it says, those of a row in order, in the memory that is there.
    pub fn sort(&mut self, rows: usize, items: impl Iterator<Item = (usize, T)> + Clone)
    where
        T: Copy + Default,
    {
        // offsets[row + 1] runs from the start of its row to the end of it, by way of offsets[row + 2].
        self.offsets.clear();
        self.offsets.resize(rows + 2, 0);
        (items.clone()).for_each(|(row, _)| self.offsets[row + 2] += 1);
        for row in 2..rows + 2 {
            self.offsets[row] += self.offsets[row - 1];
        }
        self.entries.clear();
        let count = self.offsets[rows + 1] as usize;
        self.entries.resize(count, T::default());
        for (row, item) in items {
            let next = &mut self.offsets[row + 1];
            self.entries[*next as usize] = item;
            *next += 1;
        }
        self.offsets.truncate(rows + 1);
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
