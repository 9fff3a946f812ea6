//! What all instances share and no step changes.

use super::cubature::Cubature;
use super::normals::vertex_triangles;
use super::points::Points;
use super::pose_columns::PoseColumns;
use super::{Basis, Incidence};
use crate::Result;
use crate::math::Rows;
use crate::model::{Avatar, BasisEntry, Space};
use crate::potential::BlockPattern;
use std::sync::Arc;

/// The avatar with the tables that gathers need.
pub(super) struct Asset<B> {
    pub avatar: Arc<Avatar>,
    pub space: Space,
    pub pattern: BlockPattern,
    pub cubature: Cubature<B>,
    /// The finer points, by their coarse handles; none without slots for fine handles.
    pub children: Option<Cubature<BasisEntry>>,
    pub cubature_columns: PoseColumns,
    pub skin: Points<B>,
    pub skin_incidence: Incidence,
    pub skin_columns: PoseColumns,
    /// Blocks of a skin vertex at most, and the two of a body.
    pub lever_stride: usize,
    pub vertex_triangles: Rows<[u32; 2]>,
}

impl<B: Basis> Asset<B> {
    pub fn new(avatar: Arc<Avatar>, cubature: &Rows<B>, skin: &Rows<B>) -> Result<Self> {
        avatar.validate()?;
        let space = avatar.space();
        let cubature = Points::new("cubature", space, &avatar.cubature.skinning, cubature)?;
        let skin = Points::new("skin", space, &avatar.skin.skinning, skin)?;
        let body_frames = avatar.body_frames();
        let skin_blocks = skin.blocks(space);
        let cubature_blocks = cubature.blocks(space);
        let fine = &avatar.fine;
        let children = (fine.slots > 0)
            .then(|| {
                let (skinning, basis) = (&fine.points.skinning, &fine.points.basis);
                Points::new("fine.points", space, skinning, basis)
            })
            .transpose()?;
        let child_blocks = children.as_ref().map(|points| points.blocks(space));
        let mut sets = vec![&cubature_blocks, &skin_blocks];
        sets.extend(&child_blocks);
        let first_slot = space.handle_block(avatar.coarse_handles());
        let pattern = BlockPattern::from_blocks(space, &avatar.carried(), &sets)
            .with_bodies(&body_frames, &skin_blocks)
            .with_full_rows(first_slot);
        let measure = avatar.cubature.measure.clone();
        let of_children = fine.points.measure.clone();
        Ok(Self {
            skin_incidence: skin.incidence(&pattern),
            cubature_columns: PoseColumns::new(&avatar.cubature.pose_blend, cubature.len()),
            children: children.map(|points| Cubature::new(points, of_children, &pattern)),
            cubature: Cubature::new(cubature, measure, &pattern),
            skin_columns: PoseColumns::new(&avatar.skin.pose_blend, skin.len()),
            lever_stride: 2 * skin.skinning.longest() + skin.basis.longest() + 2,
            vertex_triangles: vertex_triangles(skin.len(), &avatar.triangles),
            avatar,
            space,
            pattern,
            skin,
        })
    }

    /// Cubature points that an instance may have at a time.
    pub fn most_points(&self) -> usize {
        let fine = &self.avatar.fine;
        let mut of_handle: Vec<usize> = (fine.cells.iter())
            .map(|cells| cells.iter().map(|&c| fine.children(c as usize).len()).sum())
            .collect();
        of_handle.sort_unstable_by(|a, b| b.cmp(a));
        let children: usize = of_handle.iter().take(fine.slots).sum();
        // Those of handles that fall asleep fade while others wake.
        self.cubature.len() + (2 * children).min(if fine.slots > 0 { fine.points.len() } else { 0 })
    }
}
