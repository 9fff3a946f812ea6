//! The cubature of one instance while fine handles are awake: all coarse points, then the children of the cells that are
//! awake. Everything is refilled in place when a handle wakes or sleeps, and weights in every step that fades.

use super::asset::Asset;
use super::basis::Mixed;
use super::cubature::Cubature;
use super::{Basis, GeneralBasis};
use crate::model::{Awake, FineBlock};

/// The points of an instance with handles awake.
pub(super) struct Woken {
    /// What they are of.
    awake: Awake,
    pub cubature: Cubature<Mixed>,
    blocks: Vec<FineBlock>,
    /// Scratch: the slot of each fine handle, blocks and targets of a point.
    slots: Vec<Option<u32>>,
    row: Vec<Mixed>,
    own: Vec<u32>,
    targets: Vec<u32>,
}

impl Woken {
    /// Room for all that `asset` can have awake at a time.
    pub fn new<B: Basis>(asset: &Asset<B>) -> Self {
        let fine = &asset.avatar.fine;
        Self {
            awake: Awake::none(&asset.avatar),
            cubature: Cubature::default(),
            blocks: Vec::new(),
            slots: vec![None; fine.len()],
            row: Vec::new(),
            own: Vec::new(),
            targets: Vec::new(),
        }
    }

    /// Whether no handle is awake, and the coarse points serve alone.
    pub fn is_none(&self) -> bool {
        self.awake.is_none()
    }

    /// Handles that are awake.
    pub fn handles(&self) -> usize {
        self.awake.handles().len()
    }

    /// Whether they are those of `awake` already.
    pub fn is(&self, awake: &Awake) -> bool {
        self.awake == *awake
    }

    /// Fills the tables with the points of `awake`.
    pub fn set<B: Basis>(&mut self, asset: &Asset<B>, awake: &Awake) {
        let same_points = self.has_points_of(awake);
        self.awake.clone_from(awake);
        if awake.is_none() {
            return;
        }
        if same_points {
            self.set_measures(asset);
            return;
        }
        let avatar = &*asset.avatar;
        let fine = &avatar.fine;
        self.slots.fill(None);
        for (&handle, slot) in awake.handles().iter().zip(0..) {
            self.slots[handle as usize] = Some(slot);
        }
        self.cubature.clear();
        let (own, coarse) = (&asset.cubature, asset.cubature.len());
        for i in 0..coarse {
            self.push(asset, i, (own, i));
        }
        if let Some(children) = &asset.children {
            for &(cell, _) in awake.cells().iter().filter(|(_, share)| *share > 0.0) {
                for child in fine.children(cell as usize) {
                    self.cubature.children.push(child as u32);
                    self.push(asset, coarse + child, (children, child));
                }
            }
        }
        self.cubature.incidence.finish(asset.space.blocks());
        self.set_measures(asset);
    }

    /// Whether `awake` differs from what is here at most in how far cells have faded.
    fn has_points_of(&self, awake: &Awake) -> bool {
        fn cells(awake: &Awake) -> impl Iterator<Item = u32> {
            let there = awake.cells().iter().filter(|(_, share)| *share > 0.0);
            there.map(|(cell, _)| *cell)
        }
        self.awake.handles() == awake.handles() && cells(&self.awake).eq(cells(awake))
    }

    /// (1 − s) w + s w_own of the coarse points, s w of the children.
    fn set_measures<B: Basis>(&mut self, asset: &Asset<B>) {
        let (fine, own) = (&asset.avatar.fine, &asset.cubature.measure);
        let measure = &mut self.cubature.measure;
        measure.clear();
        measure.extend(own);
        for &(cell, s) in self.awake.cells().iter().filter(|(_, s)| *s > 0.0) {
            let i = cell as usize;
            measure[i] = (1.0 - s) * own[i] + s * fine.own_measure[i];
            let children = fine.children(i);
            measure.extend(fine.points.measure[children].iter().map(|w| s * w));
        }
    }

    /// Adds cubature point `point` (coarse ones first), which is point `i` of `from`, with the slots that move it besides.
    fn push<B: Basis, C: Basis>(
        &mut self,
        asset: &Asset<B>,
        point: usize,
        (from, i): (&Cubature<C>, usize),
    ) {
        let (space, first) = (asset.space, asset.avatar.coarse_handles());
        let slots = &self.slots;
        let awake = |h: u32| slots[h as usize].is_some();
        asset.avatar.fine.blocks(point, awake, &mut self.blocks);
        // Slots are not in the order of handles.
        let slot = |block: &FineBlock| slots[block.handle as usize].unwrap_or(0);
        self.blocks.sort_unstable_by_key(slot);
        self.row.clear();
        self.row
            .extend(from.points.basis.row(i).iter().map(Basis::mixed));
        self.own.clear();
        self.own.extend(from.incidence.blocks(i));
        self.targets.clear();
        self.targets.extend(from.incidence.all_targets(i));
        for block in &self.blocks {
            let handle = first as u32 + slot(block);
            self.row.push(Mixed::Block(GeneralBasis {
                handle,
                value: block.value,
                gradient: block.gradient,
            }));
            // Rows of slots are full: a block's place in one is its column.
            self.own.push(space.handle_block(handle as usize) as u32);
            self.targets.extend(&self.own);
        }
        let cubature = &mut self.cubature;
        let skinning = from.points.skinning.row(i);
        (cubature.points.skinning).push(skinning.iter().copied());
        cubature.points.basis.push(self.row.iter().copied());
        cubature.incidence.push(&self.own, &self.targets);
    }
}
