//! SciPy's compressed matrices.

use super::globals::Global;
use super::{DEEPEST, Pickle, Value};
use crate::array::{Array, SparseMatrix};
use supple::internal::math::Rows;

/// Rows that a matrix may have beyond its stored values.
const MOST_EMPTY_ROWS: usize = 1 << 16;

impl Pickle<'_> {
    /// The matrix that `value` is, if it is a sparse one.
    pub(super) fn sparse(&self, value: Value, room: usize) -> Result<Option<SparseMatrix>, String> {
        let Some((class @ (Global::SparseColumns | Global::SparseRows), _, state)) =
            self.call(value)
        else {
            return Ok(None);
        };
        let shape = self.get(state, "_shape").or(self.get(state, "shape"));
        let shape = shape.ok_or("a sparse matrix has no shape")?;
        let &[rows, columns] = self.shape(shape)?.as_slice() else {
            return Err("a sparse matrix needs two lengths".into());
        };
        let part = |key: &str| {
            let found = self.get(state, key);
            let found = found.ok_or_else(|| format!("a sparse matrix has no {key}"))?;
            self.array(found, room / 4, DEEPEST)
        };
        let (data, indices, starts) = (part("data")?, part("indices")?, part("indptr")?);
        let by_rows = class == Global::SparseRows;
        let (major, minor) = if by_rows {
            (rows, columns)
        } else {
            (columns, rows)
        };
        let entries = entries(&data, &indices, &starts, major, minor)?;
        let rows = if by_rows {
            row_lists(entries.into_iter(), rows)?
        } else {
            let turned = entries.into_iter().map(|(column, row, v)| (row, column, v));
            row_lists(turned, rows)?
        };
        Ok(Some(SparseMatrix { rows, columns }))
    }
}

/// (major, minor, value) of every stored element: those of major index i are
/// `starts[i]..starts[i + 1]`.
fn entries(
    data: &Array,
    indices: &Array,
    starts: &Array,
    major: usize,
    minor: usize,
) -> Result<Vec<(u32, u32, f64)>, String> {
    let stored = data.numbers.len();
    let starts = &starts.numbers;
    let bounds = starts.first() == Some(&0.0) && starts.last() == Some(&(stored as f64));
    let rising = starts.windows(2).all(|w| w[0] <= w[1]);
    let counted = indices.numbers.len() == stored && major.checked_add(1) == Some(starts.len());
    if !(bounds && rising && counted) || starts.iter().any(|s| s.fract() != 0.0) {
        return Err("a sparse matrix's indptr does not divide its data".into());
    }
    let limit = minor.min(u32::MAX as usize) as f64;
    if indices
        .numbers
        .iter()
        .any(|i| !(*i >= 0.0 && *i < limit && i.fract() == 0.0))
    {
        return Err(format!(
            "a sparse matrix has an index that is not below {minor}"
        ));
    }
    let spans = (0u32..).zip(starts.windows(2));
    let of_span = |(i, span): (u32, &[f64])| {
        let stored = span[0] as usize..span[1] as usize;
        stored.map(move |k| (i, indices.numbers[k] as u32, data.numbers[k]))
    };
    Ok(spans.flat_map(of_span).collect())
}

/// Columns and values of each row, in the order of the entries.
fn row_lists(
    entries: impl ExactSizeIterator<Item = (u32, u32, f64)>,
    rows: usize,
) -> Result<Rows<(u32, f64)>, String> {
    if rows > entries.len().saturating_add(MOST_EMPTY_ROWS) {
        return Err(format!(
            "a sparse matrix of {rows} rows has hardly any value"
        ));
    }
    let mut lists = vec![Vec::new(); rows];
    entries.for_each(|(row, column, value)| lists[row as usize].push((column, value)));
    Ok(Rows::from_iter(lists))
}
