//! What all instances share and no step changes.

use super::normals::vertex_triangles;
use super::points::Points;
use super::pose_columns::PoseColumns;
use super::{Basis, Incidence};
use crate::Result;
use crate::material::MaterialPoint;
use crate::math::Rows;
use crate::model::{Avatar, Space};
use crate::potential::{BlockPattern, TissueFactors};
use std::sync::Arc;

/// The avatar with the tables that gathers need.
pub(super) struct Asset<B> {
    pub avatar: Arc<Avatar>,
    pub space: Space,
    pub pattern: BlockPattern,
    pub cubature: Points<B>,
    pub cubature_incidence: Incidence,
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
        let pattern = BlockPattern::from_blocks(
            space,
            &avatar.carried(),
            &[&cubature.blocks(space), &skin_blocks],
        )
        .with_bodies(&body_frames, &skin_blocks);
        Ok(Self {
            cubature_incidence: cubature.incidence(&pattern),
            skin_incidence: skin.incidence(&pattern),
            cubature_columns: PoseColumns::new(&avatar.cubature.pose_blend, cubature.len()),
            skin_columns: PoseColumns::new(&avatar.skin.pose_blend, skin.len()),
            lever_stride: 2 * skin.skinning.longest() + skin.basis.longest() + 2,
            vertex_triangles: vertex_triangles(skin.len(), &avatar.triangles),
            avatar,
            space,
            pattern,
            cubature,
            skin,
        })
    }

    /// The tissue at cubature point `i` as `factors` change it.
    pub fn tissue_at(&self, i: usize, factors: &TissueFactors) -> MaterialPoint<'_> {
        let mut tissue = self.avatar.tissue_at(i);
        tissue.local = factors.on(tissue.local);
        tissue
    }
}
