//! Which points touch which block rows: the static half of every gather.

use crate::math::Rows;
use crate::potential::BlockPattern;

/// The blocks of a set of points, and where their parts of the Hessian go.
#[derive(Clone, Debug, Default)]
pub struct Incidence {
    blocks: Rows<u32>,
    rows: Rows<(u32, u32)>,
    targets: Rows<u32>,
}

impl Incidence {
    /// `blocks` are those of each point, rising; the pattern must have all their pairs.
    pub fn new(pattern: &BlockPattern, blocks: Rows<u32>) -> Self {
        let mut rows = vec![Vec::new(); pattern.space().blocks()];
        for (point, touched) in blocks.iter().enumerate() {
            for (local, &block) in touched.iter().enumerate() {
                rows[block as usize].push((point as u32, local as u32));
            }
        }
        let place = |row: u32, column: u32| {
            let columns = pattern.columns().row(row as usize);
            columns.partition_point(|&c| c < column) as u32
        };
        let targets = blocks.iter().map(|touched| {
            let pairs = touched.iter().enumerate();
            pairs.flat_map(|(a, &row)| touched[..=a].iter().map(move |&column| place(row, column)))
        });
        Self {
            targets: targets.collect(),
            rows: rows.into_iter().collect(),
            blocks,
        }
    }

    /// Takes all points out; the memory stays.
    pub(super) fn clear(&mut self) {
        self.blocks.clear();
        self.targets.clear();
        self.rows.clear();
    }

    /// Adds a point that moves with `blocks`, rising, and whose pairs of them go to `targets`, in the order of
    /// [`Incidence::targets`].
    pub(super) fn push(&mut self, blocks: &[u32], targets: &[u32]) {
        self.blocks.push(blocks.iter().copied());
        self.targets.push(targets.iter().copied());
    }

    /// Sorts what was added by its block rows, of which there are `rows`.
    pub(super) fn finish(&mut self, rows: usize) {
        let points = (0u32..).zip(self.blocks.iter());
        let touched = points.flat_map(|(point, blocks)| {
            let locals = (0u32..).zip(blocks);
            locals.map(move |(local, &block)| (block as usize, (point, local)))
        });
        self.rows.sort(rows, touched);
    }

    /// Targets of all pairs of blocks of `point`.
    pub(super) fn all_targets(&self, point: usize) -> &[u32] {
        self.targets.row(point)
    }

    /// Blocks of `point`, in local order.
    pub fn blocks(&self, point: usize) -> &[u32] {
        self.blocks.row(point)
    }

    /// (point, its local block) of everything that touches the block row `row`, points rising.
    pub fn row(&self, row: usize) -> &[(u32, u32)] {
        self.rows.row(row)
    }

    /// Places, within the pattern's row, of a point's blocks (`local`, b) for b = 0..=`local`.
    pub fn targets(&self, point: usize, local: usize) -> &[u32] {
        let first = local * (local + 1) / 2;
        &self.targets.row(point)[first..=first + local]
    }
}
