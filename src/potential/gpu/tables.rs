//! Constant tables made once from the avatar: who moves whom, and which terms go where.

use super::pack::{columns, round};
use super::shared::{HandleGradient, HessianSegment, Influence, LocalTissue, Point};
use crate::math::Rows;
use crate::model::{Avatar, PointSet, Space};
use crate::potential::{BlockPattern, point_blocks};
use crate::{Error, GpuError, Result};
use glam::DMat3;

/// Blocks that may move one cubature point: `MAX_BLOCKS` of point_hessian.wgsl.
const MAX_POINT_BLOCKS: usize = 192;
/// Blocks that may move one skin vertex: places are bytes, 0 meaning none, and the last two a body's.
const MAX_VERTEX_BLOCKS: usize = 253;

/// |F| to which the kernels compute: its sixth power, times a stiffness and a point's volume, is within f32.
const MAX_STRETCH: f64 = 1e4;

/// A set of points as the kernels read it.
#[derive(Debug, Default)]
pub(super) struct PointTable {
    pub points: Vec<Point>,
    pub influences: Vec<Influence>,
    pub gradients: Vec<HandleGradient>,
    pub columns: Vec<f32>,
    /// Blocks of every point in its own order.
    pub blocks: Rows<u32>,
    pub pairs: usize,
}

impl PointTable {
    /// The points of `set`, whose `extension` says what they follow of the skin's offsets; no rows where they do not.
    pub fn new(
        space: Space,
        (set, extension): (&PointSet, &Rows<(u32, f32)>),
        field: &str,
        max_blocks: usize,
    ) -> Result<Self> {
        let mut out = Self {
            columns: set.pose_blend.columns.iter().flatten().copied().collect(),
            ..Self::default()
        };
        let mut blocks = Vec::new();
        for i in 0..set.len() {
            let (bones, basis) = (set.skinning.row(i), set.basis.row(i));
            out.points.push(Point {
                position: round(set.position[i]),
                measure: set.measure[i] as f32,
                first_influence: out.influences.len() as u32,
                bones: bones.len() as u32,
                handles: basis.len() as u32,
                first_gradient: out.gradients.len() as u32,
                first_block: out.blocks.entries().len() as u32,
                first_pair: out.pairs as u32,
                ..Point::default()
            });
            out.influences.extend(bones.iter().map(|w| Influence {
                index: w.bone,
                weight: w.weight as f32,
            }));
            out.influences.extend(basis.iter().map(|u| Influence {
                index: u.handle,
                weight: u.value as f32,
            }));
            out.gradients.extend(basis.iter().map(|u| HandleGradient {
                gradient: round(u.gradient),
                handle: u.handle,
            }));
            point_blocks(space, set, i, &mut blocks);
            if blocks.len() > max_blocks {
                return Err(GpuError::Limit {
                    what: format!(
                        "blocks (two a bone, one a handle) that move point {i} of {field}"
                    ),
                    needed: blocks.len() as u64,
                    limit: max_blocks as u64,
                    cure: "truncate the basis and the skin weights, or evaluate on the CPU",
                }
                .into());
            }
            let mut sorted = blocks.clone();
            sorted.sort_unstable();
            if sorted.windows(2).any(|w| w[0] == w[1]) {
                return Err(Error::invalid(
                    format!("{field}.skinning"),
                    format!("a bone or a handle stands twice in the row of point {i}; merge them"),
                ));
            }
            out.pairs += blocks.len() * (blocks.len() + 1) / 2;
            out.blocks.push(blocks.iter().copied());
        }
        for (point, shares) in out.points.iter_mut().zip(extension.iter()) {
            point.first_share = out.influences.len() as u32;
            point.shares = shares.len() as u32;
            let share = |&(index, weight): &(u32, f32)| Influence { index, weight };
            out.influences.extend(shares.iter().map(share));
        }
        Ok(out)
    }

    /// Number of all points' shares in offsets of the skin.
    pub fn shares(&self) -> usize {
        self.points.iter().map(|p| p.shares as usize).sum()
    }
}

/// Everything constant that the kernels read of an avatar.
#[derive(Debug)]
pub(super) struct Tables {
    pub cubature: PointTable,
    pub skin: PointTable,
    /// max Σ |∇U| of a cubature point's handles, 1/m.
    pub steepest: f64,
    /// Parameters of the material, as its kernel reads them.
    pub material: Vec<u8>,
    /// What the material has of its own at every cubature point.
    pub tissue: Vec<LocalTissue>,
    pub pattern: BlockPattern,
    /// For every block of q, the points' own blocks that add to it.
    pub gather: Rows<u32>,
    /// For every thread of kernel `hessian`, which terms it sums.
    pub hessian_segments: Vec<HessianSegment>,
    /// 2 · pair + transposed, for every term.
    pub gather_pairs: Vec<u32>,
    /// Place + 1 of every block in a vertex's own order, four bytes a word; 0 where it does not move it.
    pub vertex_blocks: Vec<u32>,
    /// For every vertex, the other two corners of each triangle around it.
    pub one_ring: Rows<[u32; 2]>,
}

impl Tables {
    pub fn new(avatar: &Avatar) -> Result<Self> {
        let space = avatar.space();
        // A skin vertex follows its own offset.
        let vertices = match avatar.is_extended() {
            true => avatar.offset_vertices() as u32,
            false => 0,
        };
        let own: Rows<_> = (0..vertices).map(|v| [(v, 1.0)]).collect();
        let cubature = (&avatar.cubature, &avatar.pose_extension);
        let cubature = PointTable::new(space, cubature, "cubature", MAX_POINT_BLOCKS)?;
        let mut skin = PointTable::new(space, (&avatar.skin, &own), "skin", MAX_VERTEX_BLOCKS)?;
        for (v, point) in skin.points.iter_mut().enumerate() {
            /// Infinity is no number to a kernel.
            const MOST: f64 = 1e30;
            point.contact_stiffness = avatar.contact_stiffness_at(v).min(MOST) as f32;
        }
        let pattern =
            BlockPattern::new(space, &avatar.carried(), &[&avatar.cubature, &avatar.skin])
                .with_bodies(&avatar.body_frames(), &skin.blocks);

        let mut gather = vec![Vec::new(); space.blocks()];
        for (local, &block) in cubature.blocks.entries().iter().enumerate() {
            gather[block as usize].push(local as u32);
        }

        let mut terms = vec![Vec::new(); pattern.len()];
        for (point, blocks) in cubature.points.iter().zip(cubature.blocks.iter()) {
            let mut pair = point.first_pair;
            for (a, &row) in blocks.iter().enumerate() {
                for &column in &blocks[..=a] {
                    let transposed = row < column;
                    let stored = pattern
                        .find(row.max(column) as usize, row.min(column) as usize)
                        .ok_or_else(|| {
                            Error::invalid("pattern", "lacks a block of a cubature point")
                        })?;
                    terms[stored].push(2 * pair + u32::from(transposed));
                    pair += 1;
                }
            }
        }
        let counts = terms.iter().map(Vec::len);
        let hessian_segments = hessian_segments(pattern.blocks().zip(counts));
        let gather_pairs = terms.concat();

        let words = space.blocks().div_ceil(4);
        let mut vertex_blocks = vec![0u32; words * skin.points.len()];
        for (v, blocks) in skin.blocks.iter().enumerate() {
            for (place, &block) in blocks.iter().enumerate() {
                let block = block as usize;
                vertex_blocks[v * words + block / 4] |= (place as u32 + 1) << (8 * (block % 4));
            }
        }

        let mut one_ring = vec![Vec::new(); skin.points.len()];
        for &[a, b, c] in &avatar.triangles {
            for (v, edge) in [(a, [b, c]), (b, [c, a]), (c, [a, b])] {
                one_ring[v as usize].push(edge);
            }
        }
        Ok(Self {
            cubature,
            skin,
            steepest: steepest(&avatar.cubature),
            material: avatar.material.parameters().bytes,
            tissue: local_tissue(avatar),
            pattern,
            gather: gather.into_iter().collect(),
            hessian_segments,
            gather_pairs,
            vertex_blocks,
            one_ring: one_ring.into_iter().collect(),
        })
    }

    /// Longest φ and Δφ, m, with which F stays below [`MAX_STRETCH`].
    pub fn longest_handle(&self) -> f32 {
        (MAX_STRETCH / self.steepest.max(1e-6)) as f32
    }
}

fn steepest(set: &PointSet) -> f64 {
    let slope = |i| -> f64 { set.basis.row(i).iter().map(|u| u.gradient.length()).sum() };
    (0..set.len()).map(slope).fold(0.0, f64::max)
}

/// Terms that one thread sums, if a workgroup has room for the block's others: 7 is the median of a hand's, and up to 422
/// in one thread make all others wait.
const SEGMENT: usize = 16;
/// Threads of a workgroup of hessian.wgsl.
const HESSIAN_GROUP: usize = 64;

/// The segments of stored blocks with these places and numbers of terms. Those of a block are in one workgroup, in order.
fn hessian_segments(blocks: impl Iterator<Item = ((usize, usize), usize)>) -> Vec<HessianSegment> {
    let mut out: Vec<HessianSegment> = Vec::new();
    let mut first = 0;
    for (block, ((row, column), terms)) in blocks.enumerate() {
        let length = SEGMENT.max(terms.div_ceil(HESSIAN_GROUP));
        let count = terms.div_ceil(length).max(1);
        if out.len() % HESSIAN_GROUP + count > HESSIAN_GROUP {
            out.resize(
                out.len().next_multiple_of(HESSIAN_GROUP),
                HessianSegment::default(),
            );
        }
        out.extend((0..count).map(|k| HessianSegment {
            block: block as u32,
            row: row as u32,
            column: column as u32,
            first: (first + k * length) as u32,
            end: (first + terms.min((k + 1) * length)) as u32,
            count: if k == 0 { count as u32 } else { 0 },
        }));
        first += terms;
    }
    out.resize(
        out.len().next_multiple_of(HESSIAN_GROUP),
        HessianSegment::default(),
    );
    out
}

fn local_tissue(avatar: &Avatar) -> Vec<LocalTissue> {
    let local = |i: usize| {
        let local = avatar.tissue_at(i).local;
        LocalTissue {
            axes: columns(DMat3::from_quat(local.axes)),
            stiffness: local.stiffness as f32,
            damping_time: local.damping_time as f32,
            muscle: local.muscle as f32,
            ..LocalTissue::default()
        }
    };
    (0..avatar.cubature.len()).map(local).collect()
}
