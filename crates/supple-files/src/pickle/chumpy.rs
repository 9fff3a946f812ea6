//! chumpy's lazy arrays, reduced to their values.
//!
//! SMPL's files hold `Ch`, MANO's `Select` of `Ch`: the first columns of a larger set of directions.

use super::globals::Global;
use super::{Pickle, Value};
use crate::array::Array;

impl Pickle<'_> {
    /// The value of an expression with this `state`.
    pub(super) fn chumpy(
        &self,
        class: Global,
        state: Value,
        room: usize,
        depth: usize,
    ) -> Result<Array, String> {
        let term = |key: &str| {
            let found = self.get(state, key);
            found.ok_or_else(|| format!("an expression of chumpy's has no {key}"))
        };
        match class {
            Global::ChumpySelect => {
                // r = a.ravel()[idxs].reshape(preferred_shape)
                let source = self.array(term("a")?, room, depth)?;
                let left = room.saturating_sub(source.numbers.len());
                let selected = self.array(term("idxs")?, left, depth)?;
                let at = |index: &f64| {
                    let index = (index.fract() == 0.0 && *index >= 0.0).then_some(*index as usize);
                    index.and_then(|i| source.numbers.get(i).copied())
                };
                let numbers: Option<Vec<f64>> = selected.numbers.iter().map(at).collect();
                let selection = Array {
                    shape: selected.shape,
                    numbers: numbers.ok_or("chumpy selects an element that is not there")?,
                    texts: Vec::new(),
                };
                match self.get(state, "preferred_shape") {
                    Some(shape) => self.reshaped(selection, shape),
                    None => Ok(selection),
                }
            }
            Global::ChumpyReshape => {
                let source = self.array(term("a")?, room, depth)?;
                self.reshaped(source, term("newshape")?)
            }
            _ => self.array(term("x")?, room, depth),
        }
    }

    /// The same numbers in another shape; one length may be −1, for what is left.
    fn reshaped(&self, array: Array, shape: Value) -> Result<Array, String> {
        let mismatch = || "chumpy's shape does not fit its numbers".to_string();
        let lengths = self.array(shape, 64, 2).map_err(|_| mismatch())?.numbers;
        let whole = |n: &f64| (n.fract() == 0.0 && n.abs() < 9e15).then_some(*n as i64);
        let lengths: Option<Vec<i64>> = lengths.iter().map(whole).collect();
        let lengths = lengths.ok_or_else(mismatch)?;
        let mut known = lengths.iter().filter(|n| **n != -1);
        let known = known.try_fold(1usize, |product, n| {
            product.checked_mul(usize::try_from(*n).ok()?)
        });
        let known = known.ok_or_else(mismatch)?;
        let count = array.numbers.len();
        let left = count.checked_div(known).unwrap_or(0);
        let length = |n: &i64| usize::try_from(*n).unwrap_or(left);
        let shape: Vec<usize> = lengths.iter().map(length).collect();
        let product = shape.iter().try_fold(1usize, |p, n| p.checked_mul(*n));
        if product != Some(count) {
            return Err(mismatch());
        }
        Ok(Array { shape, ..array })
    }
}
