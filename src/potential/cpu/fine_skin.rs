//! What fine handles that are awake do to the skin: numbers beside the coarse handles' rows, of the vertices that they reach.

use crate::math::Rows;
use crate::model::{Avatar, Awake, BasisEntry};

/// Slots of each skin vertex, none where no handle is awake.
#[derive(Debug, Default)]
pub struct FineSkin {
    /// Where the row of each vertex is, and one more; 0 where it has none. Empty while all sleep.
    place: Vec<u32>,
    rows: Rows<BasisEntry>,
    longest: usize,
}

impl FineSkin {
    /// Those of the handles `awake`, in the memory that is there.
    pub fn set(&mut self, avatar: &Avatar, awake: &Awake) {
        self.place.clear();
        self.rows.clear();
        self.longest = 0;
        if awake.handles().is_empty() {
            return;
        }
        let first = avatar.coarse_handles();
        for row in avatar.fine.skin.iter() {
            let before = self.rows.entries().len();
            let entries = row.iter().filter_map(|&(handle, u)| {
                let slot = awake.slot_of(handle)?;
                Some(BasisEntry {
                    handle: (first + slot) as u32,
                    value: f64::from(u),
                    gradient: glam::DVec3::ZERO,
                })
            });
            let filled = self.rows.push_some(entries, |e| e.handle);
            self.longest = self.longest.max(self.rows.entries().len() - before);
            self.place
                .push(if filled { self.rows.len() as u32 } else { 0 });
        }
    }

    /// The row of a vertex, slots rising.
    pub fn row(&self, vertex: usize) -> &[BasisEntry] {
        match self.place.get(vertex) {
            None | Some(0) => &[],
            Some(&place) => self.rows.row(place as usize - 1),
        }
    }

    /// Slots of a vertex at most.
    pub fn longest(&self) -> usize {
        self.longest
    }
}
