//! Which fine handles are awake.
//!
//! An avatar with slots ([`Avatar::with_fine_slots`]) has more handles than it was baked with: its last ones stand for the fine
//! handles that are awake, and are fixed at 0 where none is; a state says which ones they are ([`State::awake`]). Histories and
//! solvers see handles and no more.

use super::{Avatar, FineHandles, State};
use crate::{Error, Result};
use glam::DVec3;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

impl Avatar {
    /// The avatar with room for `budget` fine handles that are awake at a time, or for all of them where it has fewer.
    ///
    /// # Errors
    /// [`Error::Invalid`] of an avatar that has slots already.
    pub fn with_fine_slots(mut self, budget: usize) -> Result<Self> {
        if self.fine.slots > 0 {
            let problem = "the avatar has slots for fine handles; hand it in without them";
            return Err(Error::invalid("fine.slots", problem));
        }
        let slots = budget.min(self.fine.len());
        if slots > 0 {
            Arc::make_mut(&mut self.fine).slots = slots;
            self.handles.resize(self.handles.len() + slots, DVec3::ZERO);
        }
        Ok(self)
    }

    /// Handles that never sleep: those before the slots.
    pub fn coarse_handles(&self) -> usize {
        self.handles.len().saturating_sub(self.fine.slots)
    }

    /// φ of a fine handle in `state`, m; none where it sleeps.
    pub fn fine_displacement(&self, state: &State, handle: u32) -> Option<DVec3> {
        let slot = state.awake.iter().position(|h| *h == handle)?;
        state.handles.get(self.coarse_handles() + slot).copied()
    }
}

/// Which fine handles are awake, slot by slot, and how far the cubature around them is the finer one.
#[derive(Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Awake {
    /// The fine handle of each slot that is taken; those after sleep.
    handles: Vec<u32>,
    /// s of each cell that is awake or fades, 0 to 1, cells rising: its coarse point counts (1 − s) of its own weight and s of
    /// that beside its children, they s of theirs.
    cells: Vec<(u32, f64)>,
}

impl Clone for Awake {
    fn clone(&self) -> Self {
        Self {
            handles: self.handles.clone(),
            cells: self.cells.clone(),
        }
    }

    /// In the memory that is there, as a step needs it.
    fn clone_from(&mut self, other: &Self) {
        self.handles.clone_from(&other.handles);
        self.cells.clone_from(&other.cells);
    }
}

impl Awake {
    /// None, with room for what `avatar` can have awake at a time.
    pub fn none(avatar: &Avatar) -> Self {
        let mut out = Self::default();
        out.reserve(avatar);
        out
    }

    /// Makes room for what `avatar` can have awake at a time.
    pub(crate) fn reserve(&mut self, avatar: &Avatar) {
        let fine = &avatar.fine;
        let cells = match fine.slots {
            0 => 0,
            _ => fine.own_measure.len(),
        };
        (self.handles).reserve(fine.slots.saturating_sub(self.handles.len()));
        (self.cells).reserve(cells.saturating_sub(self.cells.len()));
    }

    /// The fine handle of each slot that is taken.
    pub fn handles(&self) -> &[u32] {
        &self.handles
    }

    /// (cell, s) of the cells that are awake or fade, rising.
    pub fn cells(&self) -> &[(u32, f64)] {
        &self.cells
    }

    /// Whether no handle is awake and no cell fades.
    pub fn is_none(&self) -> bool {
        self.handles.is_empty() && self.cells.is_empty()
    }

    /// Those of a state that was put here; cells follow with [`Awake::complete`].
    pub fn set_handles(&mut self, handles: &[u32]) {
        self.handles.clear();
        self.handles.extend(handles);
    }

    /// Adds the cells that the handles of a state that was put here want and that are not there, wholly awake: nothing led there, so that
    /// nothing needs to fade.
    pub fn complete(&mut self, fine: &FineHandles) {
        for k in 0..self.handles.len() {
            self.add_cells(fine, self.handles[k], 1.0);
        }
    }

    /// Adds the cells of `handle` that are not there, at this share.
    fn add_cells(&mut self, fine: &FineHandles, handle: u32, share: f64) {
        for &cell in fine.cells.row(handle as usize) {
            if let Err(at) = self.cells.binary_search_by_key(&cell, |c| c.0) {
                self.cells.insert(at, (cell, share));
            }
        }
    }

    /// The slot of a fine handle that is awake.
    pub fn slot_of(&self, handle: u32) -> Option<usize> {
        self.handles.iter().position(|h| *h == handle)
    }

    /// Wakes `handle` in the next slot, unless it is awake or all are taken; the slots come after so many `coarse` handles. Its displacement is 0 in `states`: neither a
    /// position nor a velocity changes. Cells that wake with it start at s = 0.
    pub fn wake<'a>(
        &mut self,
        fine: &FineHandles,
        coarse: usize,
        handle: u32,
        states: impl Iterator<Item = &'a mut State>,
    ) -> bool {
        let slot = self.handles.len();
        if slot >= fine.slots || self.slot_of(handle).is_some() {
            return false;
        }
        self.handles.push(handle);
        states.for_each(|state| {
            state.handles[coarse + slot] = DVec3::ZERO;
            state.awake.clone_from(&self.handles);
        });
        self.add_cells(fine, handle, 0.0);
        true
    }

    /// The handle of `slot` sleeps; the last one takes its slot, in `states` too. Its cells fade from where they are.
    pub fn sleep<'a>(
        &mut self,
        coarse: usize,
        slot: usize,
        states: impl Iterator<Item = &'a mut State>,
    ) {
        let (first, last) = (coarse, self.handles.len() - 1);
        self.handles.swap_remove(slot);
        for state in states {
            state.handles[first + slot] = state.handles[first + last];
            state.handles[first + last] = DVec3::ZERO;
            state.awake.clone_from(&self.handles);
        }
    }

    /// Moves every cell's s towards 1 where a handle that is awake wakes it, and towards 0 elsewhere, by what `most` says of
    /// the cell; a cell that reaches 0 is left out.
    pub fn fade(&mut self, fine: &FineHandles, mut most: impl FnMut(u32) -> f64) {
        let handles = &self.handles;
        let wanted = |cell: u32| {
            let mut rows = handles.iter().map(|&h| fine.cells.row(h as usize));
            rows.any(|row| row.binary_search(&cell).is_ok())
        };
        for (cell, share) in &mut self.cells {
            let to = f64::from(u8::from(wanted(*cell)));
            if *share != to {
                let most = most(*cell);
                *share += (to - *share).clamp(-most, most);
            }
        }
        self.cells
            .retain(|(cell, share)| *share > 0.0 || wanted(*cell));
    }

    /// Checks what was restored or written by hand.
    ///
    /// # Errors
    /// [`Error::Invalid`] in `awake`.
    pub fn validate(&self, avatar: &Avatar) -> Result<()> {
        let fine = &avatar.fine;
        // They are few: a list of those seen would be one more allocation in a step.
        let new =
            |(k, h): (usize, &u32)| (*h as usize) < fine.len() && !self.handles[..k].contains(h);
        let handles = self.handles.len() <= fine.slots && self.handles.iter().enumerate().all(new);
        let cells = self.cells.is_sorted_by(|a, b| a.0 < b.0)
            && (self.cells.iter()).all(|&(cell, s)| {
                (cell as usize) < fine.own_measure.len() && (0.0..=1.0).contains(&s)
            });
        match handles && cells {
            true => Ok(()),
            false => Err(Error::invalid(
                "awake",
                "names a fine handle or cell that is not there, one twice, or more than there are slots",
            )),
        }
    }
}
