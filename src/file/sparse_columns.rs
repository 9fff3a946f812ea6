//! Pose blend shapes without their zeros: a bone moves few vertices, and 95 of 100 values of a hand's columns are 0.

use crate::model::PoseBlend;
use serde::{Deserialize, Serialize};

/// More values than this are a mistake or an attack: SMPL-X has five million.
const MOST_VALUES: usize = 1 << 26;

/// The columns of a [`PoseBlend`], each from one value that is not +0 to the next.
#[derive(Serialize, Deserialize)]
pub(super) struct SparseColumns {
    features: u32,
    points: u32,
    /// Number of values of each feature.
    counts: Vec<u32>,
    /// How many points lie between a value's and the one's before it in its feature.
    skips: Vec<u32>,
    values: Vec<[f32; 3]>,
}

impl SparseColumns {
    pub fn of(blend: &PoseBlend, points: usize) -> Self {
        let mut sparse = Self {
            features: blend.features as u32,
            points: points as u32,
            counts: Vec::new(),
            skips: Vec::new(),
            values: Vec::new(),
        };
        for column in blend.columns.chunks_exact(points.max(1)) {
            let (before, mut next) = (sparse.values.len(), 0);
            for (i, value) in column.iter().enumerate() {
                // Not `value != 0`: the sign of a zero is kept.
                if value.map(f32::to_bits) != [0; 3] {
                    sparse.skips.push((i - next) as u32);
                    sparse.values.push(*value);
                    next = i + 1;
                }
            }
            sparse.counts.push((sparse.values.len() - before) as u32);
        }
        sparse
    }

    /// The columns, or what is wrong.
    pub fn columns(&self, points: usize) -> Result<PoseBlend, &'static str> {
        let features = self.features as usize;
        let count = features.checked_mul(points).filter(|&c| c <= MOST_VALUES);
        let (Some(count), true) = (count, self.points as usize == points) else {
            return Err("is of another number of points, or has too many values");
        };
        let mut columns = vec![[0.0; 3]; count];
        let mut values = self.skips.iter().zip(&self.values);
        let whole = self.skips.len() == self.values.len()
            && (count == 0 || self.counts.len() == features)
            && self.counts.iter().map(|c| u64::from(*c)).sum::<u64>() == self.values.len() as u64;
        if !whole {
            return Err("has other numbers of values than it says");
        }
        for (column, count) in columns.chunks_exact_mut(points.max(1)).zip(&self.counts) {
            let mut next = 0_usize;
            for (skip, value) in values.by_ref().take(*count as usize) {
                next = next.saturating_add(*skip as usize);
                *(column.get_mut(next)).ok_or("names a point that is not there")? = *value;
                next += 1;
            }
        }
        Ok(PoseBlend { features, columns })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_come_back_bit_by_bit() {
        let mut columns = vec![[0.0; 3]; 3 * 7];
        columns[2] = [1.0, -2.0, 3.0];
        columns[3] = [0.0, -0.0, 0.0];
        columns[20] = [f32::MIN_POSITIVE, 0.0, 0.0];
        let blend = PoseBlend {
            features: 3,
            columns,
        };
        let sparse = SparseColumns::of(&blend, 7);
        assert_eq!(sparse.values.len(), 3);
        let back = sparse.columns(7).unwrap();
        let bits = |b: &PoseBlend| -> Vec<_> {
            let numbers = b.columns.iter().flatten();
            numbers.map(|x| x.to_bits()).collect()
        };
        assert_eq!((back.features, bits(&back)), (blend.features, bits(&blend)));
        assert!(sparse.columns(6).is_err());
    }

    #[test]
    fn nonsense_is_refused_within_bounds() {
        let huge = SparseColumns {
            features: u32::MAX,
            points: 1000,
            counts: Vec::new(),
            skips: Vec::new(),
            values: Vec::new(),
        };
        assert!(huge.columns(1000).is_err());
        let beyond = SparseColumns {
            features: 1,
            points: 2,
            counts: vec![1],
            skips: vec![u32::MAX],
            values: vec![[1.0; 3]],
        };
        assert!(beyond.columns(2).is_err());
    }
}
