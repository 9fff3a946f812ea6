//! The named arrays of one file, whatever its format, or of a program.

use super::array::{Array, MOST_NUMBERS, SparseMatrix};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use supple::internal::math::Rows;
use supple::{Error, Result};

/// What a key holds.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Item {
    Dense(Array),
    Sparse(SparseMatrix),
}

/// The arrays of an `.npz` archive, of a pickled dictionary, or of a program.
pub(crate) struct Arrays {
    /// None of a program's.
    path: Option<PathBuf>,
    items: BTreeMap<String, Item>,
    /// Numbers that there is still room for.
    room: usize,
}

impl Arrays {
    /// None yet, of the file at `path`.
    pub fn of_file(path: &Path) -> Self {
        Self {
            path: Some(path.to_path_buf()),
            ..Self::in_memory()
        }
    }

    /// None yet, of a program.
    pub fn in_memory() -> Self {
        Self {
            path: None,
            items: BTreeMap::new(),
            room: MOST_NUMBERS,
        }
    }

    /// Numbers that there is still room for.
    pub fn room(&self) -> usize {
        self.room
    }

    /// Adds what `key` holds.
    pub fn insert(&mut self, key: &str, item: Item) {
        let held = match &item {
            Item::Dense(array) => array.numbers.len(),
            Item::Sparse(matrix) => matrix.rows.entries().len(),
        };
        self.room = self.room.saturating_sub(held);
        self.items.insert(key.to_string(), item);
    }

    /// An [`Error::Format`] of array `key` in the file; an [`Error::Invalid`] where there is none.
    pub fn broken(&self, key: &str, problem: impl Into<String>) -> Error {
        match &self.path {
            Some(path) => Error::format(path, key, problem),
            None => Error::invalid(key, problem),
        }
    }

    /// The one of an array's two names by which it is there; if it is not, the first in a file, the second in a program.
    pub fn called<'k>(&self, names: [&'k str; 2]) -> &'k str {
        match names.map(|name| self.items.contains_key(name)) {
            [true, _] => names[0],
            [false, true] => names[1],
            [false, false] => names[usize::from(self.path.is_none())],
        }
    }

    /// The array `key`, if it is there; all of its numbers must be finite.
    pub fn get(&self, key: &str) -> Result<Option<&Array>> {
        let array = match self.items.get(key) {
            None => return Ok(None),
            Some(Item::Dense(array)) => array,
            Some(Item::Sparse(_)) => return Err(self.broken(key, "is a sparse matrix, not dense")),
        };
        if let Some(at) = array.numbers.iter().position(|v| !v.is_finite()) {
            return Err(self.broken(key, format!("element {at} is not finite")));
        }
        Ok(Some(array))
    }

    /// The array `key`, whose shape must be `shape`; `None` stands for any length.
    pub fn expect(&self, key: &str, shape: &[Option<usize>]) -> Result<&Array> {
        let array = self.get(key)?.ok_or_else(|| self.missing(key))?;
        let fits = array.shape.len() == shape.len()
            && (array.shape.iter().zip(shape))
                .all(|(found, wanted)| wanted.is_none_or(|w| w == *found));
        if fits && array.texts.is_empty() {
            return Ok(array);
        }
        let wanted: Vec<_> = shape
            .iter()
            .map(|s| s.map_or("any".to_string(), |n| n.to_string()))
            .collect();
        let found = if array.texts.is_empty() {
            format!("shape {:?}", array.shape)
        } else {
            "text".to_string()
        };
        let wanted = wanted.join(", ");
        let problem = format!("{found}, expected numbers of shape [{wanted}]");
        Err(self.broken(key, problem))
    }

    /// What is not 0 in each row of the matrix `key`, which may be dense or sparse; indices rise, and
    /// what is stored twice adds up.
    pub fn nonzero_rows(&self, key: &str, shape: [usize; 2]) -> Result<Rows<(u32, f64)>> {
        let [rows, columns] = shape;
        let Some(Item::Sparse(matrix)) = self.items.get(key) else {
            let array = self.expect(key, &[Some(rows), Some(columns)])?;
            let row = |r: usize| array.numbers[r * columns..(r + 1) * columns].iter();
            let nonzero = |r| (0u32..).zip(row(r).copied()).filter(|(_, v)| *v != 0.0);
            return Ok((0..rows).map(nonzero).collect());
        };
        if (matrix.rows.len(), matrix.columns) != (rows, columns) {
            let problem = format!(
                "shape [{}, {}], expected numbers of shape [{rows}, {columns}]",
                matrix.rows.len(),
                matrix.columns
            );
            return Err(self.broken(key, problem));
        }
        if matrix.rows.entries().iter().any(|(_, v)| !v.is_finite()) {
            return Err(self.broken(key, "holds a value that is not finite"));
        }
        Ok(matrix.rows.iter().map(summed).collect())
    }

    fn missing(&self, key: &str) -> Error {
        let found: Vec<_> = self.items.keys().map(String::as_str).collect();
        self.broken(key, format!("is missing; there are {}", found.join(", ")))
    }
}

/// Entries by rising index, those of one index summed in their order, zeros left out.
pub(crate) fn summed(row: &[(u32, f64)]) -> Vec<(u32, f64)> {
    let mut entries = row.to_vec();
    entries.sort_by_key(|e| e.0);
    entries.dedup_by(|next, kept| {
        let same = next.0 == kept.0;
        if same {
            kept.1 += next.1;
        }
        same
    });
    entries.retain(|e| e.1 != 0.0);
    entries
}
