//! Fine handles: asleep until something comes near, with the finer cubature around them.
//!
//! Coarse handles carry the whole body. A fine handle h has a column of its own beside theirs, which is 0 at every other
//! handle, coarse or fine; while it sleeps its displacement φ_h is 0. On the skin it is a number U_h as theirs is; below
//! the skin it moves tissue as an elastic body would follow, by a 3×3 block (method: `docs/method.md` §10):
//!
//! ```text
//! T(X) = x̄(X) + Σ_coarse U_h(X) φ_h + Σ_awake N_h(X) φ_h      N_h = U_h I on the skin
//! ```
//!
//! Each coarse cubature point has a cell, the tissue nearest to it. Where a handle is awake its cells are too: the points of
//! such a cell, the coarse one with a smaller weight and its children, stand in for the coarse point alone.
//!
//! Everything is flat arrays with indices, so that lists of what is awake are all that a step has to say.

use super::{PointSet, Skeleton};
use crate::material::LocalTissue;
use crate::math::Rows;
use crate::{Error, Result};
use glam::{DMat3, DVec3, Vec3};
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// The fine handles of an avatar; none where it was baked without ([`FineHandles::is_empty`]).
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FineHandles {
    /// Rest position of each, m.
    pub positions: Vec<DVec3>,
    /// How far no soft skin is from a handle, coarse or fine, m; a column reaches two to three times as far.
    pub spacing: f64,
    /// (handle, U) of each vertex of the tissue's skin and of what is attached to it, handles rising.
    pub skin: Rows<(u32, f32)>,
    /// (handle, N by columns) of each node of the layer, handles rising; none at a node that a bone holds.
    pub nodes: Rows<(u32, [f32; 9])>,
    /// The cells that are awake with each handle, rising: indices of coarse cubature points.
    pub cells: Rows<u32>,
    /// Weight of each coarse cubature point while its cell is awake, m³.
    pub own_measure: Vec<f64>,
    /// The points that an awake cell has besides its coarse one; `measure` is the weight, m³, `basis` that of the coarse
    /// handles. Their pose blend shapes are those of the coarse point: they move x̄ and nothing else.
    #[serde(skip)]
    pub points: PointSet,
    /// The cell of each of `points`, rising.
    pub cell_of_point: Vec<u32>,
    /// What the material has of its own at each of `points`; none where it is [`LocalTissue::default`] everywhere.
    pub tissue: Vec<LocalTissue>,
    /// The nodes of the tet of each cubature point: first the coarse ones, then `points`.
    pub corners: Vec<[u32; 4]>,
    /// ∇λ of the first three of them, 1/m; the four sum to zero.
    pub slopes: Vec<[[f32; 3]; 3]>,
    /// How many of them can be awake at a time: so many of the avatar's handles, the last ones, stand for them
    /// ([`super::Avatar::with_fine_slots`]). No part of a baked file.
    #[serde(skip)]
    pub slots: usize,
}

/// What a fine handle does at a cubature point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FineBlock {
    /// Index among the fine handles.
    pub handle: u32,
    /// N.
    pub value: DMat3,
    /// ∂N/∂X_l, 1/m: `gradient[l] φ` is column l of the handle's part of F.
    pub gradient: [DMat3; 3],
}

impl FineHandles {
    /// Number of handles.
    pub fn len(&self) -> usize {
        self.positions.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.positions.is_empty()
    }

    /// Which of `points` lie in `cell`.
    pub fn children(&self, cell: usize) -> Range<usize> {
        let first = |cell: u32| self.cell_of_point.partition_point(|&c| c < cell);
        first(cell as u32)..first(cell as u32 + 1)
    }

    /// The blocks at cubature point `point` (coarse points first) of the handles that are `wanted`, rising, over the
    /// corners n of its tet: N = Σ N_n/4, ∂N/∂X_l = Σ N_n ∂λ_n/∂X_l.
    pub fn blocks(
        &self,
        point: usize,
        mut wanted: impl FnMut(u32) -> bool,
        out: &mut Vec<FineBlock>,
    ) {
        out.clear();
        let [a, b, c] = self.slopes[point].map(|g| Vec3::from_array(g).as_dvec3());
        let slopes = [a, b, c, -(a + b + c)];
        for (&node, slope) in self.corners[point].iter().zip(slopes) {
            for &(handle, n) in self.nodes.row(node as usize) {
                if !wanted(handle) {
                    continue;
                }
                let n = DMat3::from_cols_array(&n.map(f64::from));
                let at = out.partition_point(|block| block.handle < handle);
                if out.get(at).is_none_or(|block| block.handle != handle) {
                    let (value, gradient) = (DMat3::ZERO, [DMat3::ZERO; 3]);
                    out.insert(
                        at,
                        FineBlock {
                            handle,
                            value,
                            gradient,
                        },
                    );
                }
                out[at].value += n * 0.25;
                for (sum, slope) in out[at].gradient.iter_mut().zip(slope.to_array()) {
                    *sum += n * slope;
                }
            }
        }
    }

    /// Bytes that the handles' tables take in memory, about.
    pub fn bytes(&self) -> usize {
        let blocks = size_of_val(self.nodes.entries()) + size_of_val(self.skin.entries());
        let points = &self.points;
        let of_points = size_of_val(points.basis.entries())
            + size_of_val(points.skinning.entries())
            + size_of_val(&points.position[..])
            + size_of_val(&self.tissue[..]);
        blocks + of_points + size_of_val(&self.corners[..]) + size_of_val(&self.slopes[..])
    }

    /// Checks every length, index and number of the fine handles of an avatar with so many coarse cubature points, coarse
    /// handles, vertices and nodes.
    ///
    /// # Errors
    /// [`Error::Invalid`] that names what is wrong, in `fine`.
    pub(super) fn validate(
        &self,
        skeleton: &Skeleton,
        [points, handles, vertices, nodes]: [usize; 4],
    ) -> Result<()> {
        if *self == Self::default() {
            return Ok(());
        }
        let check = |ok: bool, field: &str, problem: &str| match ok {
            true => Ok(()),
            false => Err(Error::invalid(format!("fine.{field}"), problem)),
        };
        let (own, children) = (self.len(), self.points.len());
        let finite = self.positions.iter().all(|p| p.is_finite());
        check(
            self.slots <= own && self.slots <= handles,
            "slots",
            "are more than there are handles",
        )?;
        check(
            own > 0 && finite,
            "positions",
            "a finite place is needed for each, of which there is one at least",
        )?;
        let spaced = self.spacing > 0.0 && self.spacing.is_finite();
        check(spaced, "spacing", "must be positive (m)")?;
        self.skin.validate("fine.skin", vertices)?;
        // Without its layer a file has the nodes still.
        let nodes = if nodes == 0 { self.nodes.len() } else { nodes };
        self.nodes.validate("fine.nodes", nodes)?;
        self.cells.validate("fine.cells", own)?;
        check(
            self.skin.iter().all(|row| {
                row.is_sorted_by(|a, b| a.0 < b.0)
                    && row.iter().all(|u| (u.0 as usize) < own && u.1.is_finite())
            }),
            "skin",
            "names a handle that is not there, one twice, or holds a value that is not finite",
        )?;
        check(
            self.nodes.iter().all(|row| {
                row.is_sorted_by(|a, b| a.0 < b.0)
                    && (row.iter())
                        .all(|n| (n.0 as usize) < own && n.1.iter().all(|e| e.is_finite()))
            }),
            "nodes",
            "names a handle that is not there, one twice, or holds a value that is not finite",
        )?;
        check(
            self.cells.iter().all(|row| {
                row.is_sorted_by(|a, b| a < b) && row.iter().all(|&c| (c as usize) < points)
            }),
            "cells",
            "names a cell that is not there, or one twice",
        )?;
        check(
            self.own_measure.len() == points && self.own_measure.iter().all(|&w| positive(w)),
            "own_measure",
            "a positive weight is needed for each coarse cubature point",
        )?;
        self.points.validate("fine.points", skeleton, handles)?;
        check(
            self.points.measure.iter().all(|&w| positive(w)),
            "points.measure",
            "weights must be positive",
        )?;
        check(
            self.points.pose_blend.features == 0,
            "points.pose_blend",
            "is that of the coarse points",
        )?;
        check(
            self.cell_of_point.len() == children
                && self.cell_of_point.is_sorted()
                && self.cell_of_point.iter().all(|&c| (c as usize) < points),
            "cell_of_point",
            "an existing cell is needed for each point, rising",
        )?;
        check(
            (self.tissue.is_empty() || self.tissue.len() == children)
                && self.tissue.iter().all(LocalTissue::is_valid),
            "tissue",
            "a positive stiffness, a unit quaternion, a damping time that is not negative and a muscle of 0 to 1 are \
             needed for each point, or nothing at all",
        )?;
        check(
            self.corners.len() == points + children
                && (self.corners.iter().flatten()).all(|&n| (n as usize) < nodes),
            "corners",
            "four existing nodes are needed for each point",
        )?;
        check(
            self.slopes.len() == points + children
                && (self.slopes.iter().flatten().flatten()).all(|s| s.is_finite()),
            "slopes",
            "three finite gradients are needed for each point",
        )
    }
}

fn positive(measure: f64) -> bool {
    measure > 0.0 && measure.is_finite()
}
