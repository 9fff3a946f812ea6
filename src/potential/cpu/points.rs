//! A set of points as the evaluation wants it: rows sorted by block, incidence known.

use super::{Basis, Incidence};
use crate::math::Rows;
use crate::model::{SkinWeight, Space};
use crate::potential::BlockPattern;
use crate::{Error, Result};

/// Bones and handles of a set of points, each row rising, so that the local order of a point's blocks is
/// the global one.
#[derive(Clone, Debug)]
pub struct Points<B> {
    /// Bones of each point.
    pub skinning: Rows<SkinWeight>,
    /// Handles of each point.
    pub basis: Rows<B>,
}

impl<B: Basis> Points<B> {
    /// Sorts the rows; `field` names the set in errors.
    ///
    /// # Errors
    /// Where a point names a bone or a handle twice, or one that is not there, or counts differ.
    pub fn new(
        field: &str,
        space: Space,
        skinning: &Rows<SkinWeight>,
        basis: &Rows<B>,
    ) -> Result<Self> {
        if skinning.len() != basis.len() {
            return Err(Error::invalid(
                format!("{field}.basis"),
                format!("{} rows, expected {}", basis.len(), skinning.len()),
            ));
        }
        Ok(Self {
            skinning: sorted(skinning, space.frames, |w| w.bone as usize)
                .map_err(|problem| Error::invalid(format!("{field}.skinning"), problem))?,
            basis: sorted(basis, space.handles, B::handle)
                .map_err(|problem| Error::invalid(format!("{field}.basis"), problem))?,
        })
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        self.skinning.len()
    }

    /// Whether there is no point.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Blocks of every point, rising.
    pub fn blocks(&self, space: Space) -> Rows<u32> {
        let rows = self.skinning.iter().zip(self.basis.iter());
        rows.map(|(bones, handles)| {
            let frames = bones.iter().flat_map(move |w| {
                let block = space.frame_block(w.bone as usize) as u32;
                [block, block + 1]
            });
            frames.chain(
                handles
                    .iter()
                    .map(move |n| space.handle_block(n.handle()) as u32),
            )
        })
        .collect()
    }

    /// Where the points' blocks go in `pattern`.
    pub fn incidence(&self, pattern: &BlockPattern) -> Incidence {
        Incidence::new(pattern, self.blocks(pattern.space()))
    }
}

fn sorted<T: Copy>(
    rows: &Rows<T>,
    count: usize,
    index: impl Fn(&T) -> usize,
) -> Result<Rows<T>, String> {
    let mut out = Rows::default();
    for (point, row) in rows.iter().enumerate() {
        let mut row = row.to_vec();
        row.sort_by_key(&index);
        if let Some(pair) = row.windows(2).find(|p| index(&p[0]) == index(&p[1])) {
            return Err(format!(
                "point {point} names {} twice: add the two up",
                index(&pair[0])
            ));
        }
        if row.last().is_some_and(|last| index(last) >= count) {
            return Err(format!(
                "point {point} names one of {count} that is not there"
            ));
        }
        out.push(row);
    }
    Ok(out)
}
