//! Which 3×3 blocks of the reduced Hessian can be non-zero.

use crate::math::Rows;
use crate::model::{PointSet, Space};
use std::collections::BTreeSet;

/// The lower triangle (row ≥ column) of a symmetric block matrix, row after row, columns rising.
#[derive(Clone, Debug, PartialEq)]
pub struct BlockPattern {
    space: Space,
    columns: Rows<u32>,
}

impl BlockPattern {
    /// The pattern of everything that moves `sets` of points. Blocks of frames among themselves are
    /// always there, for the skeleton's terms; of those that are `carried` (none where that is empty) only their own.
    pub fn new(space: Space, carried: &[bool], sets: &[&PointSet]) -> Self {
        let mut blocks = Vec::new();
        let touched = |set: &&PointSet| -> Rows<u32> {
            let rows = (0..set.len()).map(|i| {
                point_blocks(space, set, i, &mut blocks);
                blocks.clone()
            });
            rows.collect()
        };
        let touched: Vec<_> = sets.iter().map(touched).collect();
        Self::from_blocks(space, carried, &touched.iter().collect::<Vec<_>>())
    }

    /// The pattern of points that each move with a row of blocks.
    pub fn from_blocks(space: Space, carried: &[bool], sets: &[&Rows<u32>]) -> Self {
        let mut rows = vec![BTreeSet::new(); space.blocks()];
        let moves = |block: usize| !carried.get(block / 2).is_some_and(|carried| *carried);
        for row in (0..2 * space.frames).filter(|&row| moves(row)) {
            rows[row].extend((0..=row as u32).filter(|&column| moves(column as usize)));
        }
        for (row, columns) in rows.iter_mut().enumerate() {
            columns.insert(row as u32);
        }
        let mut touched = Vec::new();
        for blocks in sets.iter().flat_map(|set| set.iter()) {
            touched.clear();
            touched.extend(blocks);
            touched.sort_unstable();
            for (k, &row) in touched.iter().enumerate() {
                rows[row as usize].extend(&touched[..=k]);
            }
        }
        Self {
            space,
            columns: rows.into_iter().collect(),
        }
    }

    /// The pattern with what contacts add between each frame of `body_frames` and the handles of the points
    /// that it may touch, each point's blocks a row of `touching`.
    pub fn with_bodies(self, body_frames: &[u32], touching: &Rows<u32>) -> Self {
        let space = self.space;
        let mut rows: Vec<BTreeSet<u32>> = (self.columns.iter())
            .map(|columns| columns.iter().copied().collect())
            .collect();
        let first_handle = 2 * space.frames;
        for &block in touching.entries() {
            if block as usize >= first_handle {
                rows[block as usize].extend(body_frames.iter().flat_map(|&c| [2 * c, 2 * c + 1]));
            }
        }
        Self {
            space,
            columns: rows.into_iter().collect(),
        }
    }

    /// The pattern with the rows of all blocks from `first` on full: what the slots of fine handles may share points with.
    pub fn with_full_rows(self, first: usize) -> Self {
        let rows = self.columns.iter().enumerate();
        let columns = rows.map(|(row, columns)| match row < first {
            true => columns.to_vec(),
            false => (0..=row as u32).collect(),
        });
        Self {
            space: self.space,
            columns: columns.collect(),
        }
    }

    /// The numbering of DoFs.
    pub fn space(&self) -> Space {
        self.space
    }

    /// Columns of each block row.
    pub fn columns(&self) -> &Rows<u32> {
        &self.columns
    }

    /// Number of stored blocks.
    pub fn len(&self) -> usize {
        self.columns.entries().len()
    }

    /// Whether no block is stored.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Index of the stored block (`row`, `column`), `row ≥ column`.
    pub fn find(&self, row: usize, column: usize) -> Option<usize> {
        let (range, columns) = (self.columns.range(row), self.columns.row(row));
        let column = column as u32;
        // Most rows of frames are full from their start on.
        let at = match columns.get(column as usize) {
            Some(there) if *there == column => column as usize,
            _ => columns.binary_search(&column).ok()?,
        };
        Some(range.start + at)
    }

    /// (row, column) of every stored block in order.
    pub fn blocks(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        self.columns
            .iter()
            .enumerate()
            .flat_map(|(row, columns)| columns.iter().map(move |&column| (row, column as usize)))
    }
}

/// The blocks that move point `i` of `set`, in local order: (c, ω) of each of its bones, then each of
/// its handles.
pub fn point_blocks(space: Space, set: &PointSet, i: usize, out: &mut Vec<u32>) {
    out.clear();
    for weight in set.skinning.row(i) {
        let block = space.frame_block(weight.bone as usize) as u32;
        out.extend([block, block + 1]);
    }
    out.extend(
        set.basis
            .row(i)
            .iter()
            .map(|u| space.handle_block(u.handle as usize) as u32),
    );
}
