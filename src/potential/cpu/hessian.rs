//! The packed Hessian: every block row gathers from its points and its active contacts, in fixed order.
//!
//! Blocks of points are made where they are needed ([`hessian_row`]) and not stored: a hand's would
//! be 12 kB a point.

use super::contact::ContactRow;
use super::fine_skin::FineSkin;
use super::gradient::gradient;
use super::point_hessian::{PointView, hessian_row, is_prescribed};
use super::{Basis, Incidence};
use crate::potential::BlockPattern;
use glam::{DMat3, DVec3};

/// Adds the points' parts of block row `row` to its gradient and its packed blocks.
pub fn gather_points<'a, B: Basis + 'a>(
    incidence: &Incidence,
    row: usize,
    point: impl Fn(usize) -> PointView<'a, B>,
    force: &mut DVec3,
    out: &mut [[f64; 9]],
) {
    for &(i, local) in incidence.row(row) {
        let (i, local) = (i as usize, local as usize);
        let view = point(i);
        *force += gradient(&view, local);
        let targets = incidence.targets(i, local);
        hessian_row(&view, local, |b, block| {
            add(&mut out[targets[b] as usize], &block)
        });
    }
}

/// Adds the points' parts of block row `row` to its gradient alone.
pub fn gather_point_forces<'a, B: Basis + 'a>(
    incidence: &Incidence,
    row: usize,
    point: impl Fn(usize) -> PointView<'a, B>,
    force: &mut DVec3,
) {
    for &(i, local) in incidence.row(row) {
        *force += gradient(&point(i as usize), local as usize);
    }
}

/// The same sum over blocks that were stored: `blocks(i)` is [`super::point_hessian::point_hessian`] of point `i`.
pub fn gather_blocks<'a>(
    incidence: &Incidence,
    row: usize,
    blocks: impl Fn(usize) -> &'a [DMat3],
    out: &mut [[f64; 9]],
) {
    for &(i, local) in incidence.row(row) {
        let (i, local) = (i as usize, local as usize);
        let stored = &blocks(i)[local * (local + 1) / 2..];
        for (&target, &block) in incidence.targets(i, local).iter().zip(stored) {
            add(&mut out[target as usize], &block.to_cols_array());
        }
    }
}

#[inline]
fn add(sum: &mut [f64; 9], block: &[f64; 9]) {
    for k in 0..9 {
        sum[k] += block[k];
    }
}

/// The active contacts by block row, refilled at every evaluation without allocating.
#[derive(Clone, Debug, Default)]
pub struct ContactRows {
    starts: Vec<u32>,
    entries: Vec<(u32, u32)>,
}

impl ContactRows {
    /// Sorts (contact, local block) by block row, contacts rising within a row.
    pub fn fill(&mut self, contacts: &[ContactRow], skin: &SkinBlocks<'_>, rows: usize) {
        self.starts.clear();
        self.starts.resize(rows + 2, 0);
        for_each_block(contacts, skin, |_, _, block| self.starts[block + 2] += 1);
        for row in 2..rows + 2 {
            self.starts[row] += self.starts[row - 1];
        }
        self.entries.clear();
        self.entries.resize(self.starts[rows + 1] as usize, (0, 0));
        // starts[row + 1] runs from the start of its row to the end of it.
        for_each_block(contacts, skin, |contact, local, block| {
            let next = &mut self.starts[block + 1];
            self.entries[*next as usize] = (contact, local);
            *next += 1;
        });
    }

    fn row(&self, row: usize) -> &[(u32, u32)] {
        &self.entries[self.starts[row] as usize..self.starts[row + 1] as usize]
    }
}

/// The blocks of each contact: the vertex's own in local order, slots last, then the body's c and ω.
fn for_each_block(
    contacts: &[ContactRow],
    skin: &SkinBlocks<'_>,
    mut f: impl FnMut(u32, u32, usize),
) {
    for (contact, k) in contacts.iter().zip(0..) {
        let v = contact.vertex as usize;
        let blocks = skin.coarse.blocks(v).iter().copied();
        let body = contact.body.into_iter().flat_map(|c| [2 * c, 2 * c + 1]);
        for (block, local) in blocks.chain(skin.slots(v)).chain(body).zip(0..) {
            f(k, local, block as usize);
        }
    }
}

/// The blocks that move skin vertices.
#[derive(Clone, Copy, Debug)]
pub struct SkinBlocks<'a> {
    /// Bones and coarse handles.
    pub coarse: &'a Incidence,
    /// Handles that are awake.
    pub fine: &'a FineSkin,
    /// Block of handle 0.
    pub first_handle: u32,
}

impl<'a> SkinBlocks<'a> {
    /// The slots that move vertex `v`, rising; rows of these are full.
    fn slots(&self, v: usize) -> impl Iterator<Item = u32> + use<'a> {
        let first = self.first_handle;
        self.fine.row(v).iter().map(move |n| first + n.handle)
    }
}

/// The active contacts as block rows gather them.
#[derive(Clone, Copy, Debug)]
pub struct ContactTerms<'a> {
    /// By block row.
    pub rows: &'a ContactRows,
    /// Them.
    pub contacts: &'a [ContactRow],
    /// How many levers each has, and these: the vertex's ([`super::contact::skin_levers`]), then the body's.
    pub levers: (usize, &'a [DVec3]),
    /// The blocks of the vertices.
    pub skin: SkinBlocks<'a>,
    /// Where blocks are stored.
    pub pattern: &'a BlockPattern,
    /// By frame: whose blocks are left out.
    pub prescribed: &'a [bool],
}

/// Adds f ℓ of block row `row`.
pub fn gather_contact_forces(terms: &ContactTerms<'_>, row: usize, force: &mut DVec3) {
    let (stride, levers) = terms.levers;
    for &(k, local) in terms.rows.row(row) {
        *force += terms.contacts[k as usize].force * levers[k as usize * stride + local as usize];
    }
}

/// Adds the contacts' parts, f ℓ and k ℓ_a ℓ_bᵀ, of block row `row`, less the columns of prescribed frames.
pub fn gather_contacts(
    terms: &ContactTerms<'_>,
    row: usize,
    force: &mut DVec3,
    out: &mut [[f64; 9]],
) {
    let ((stride, levers), skin) = (terms.levers, terms.skin);
    let left_out = |column: u32| is_prescribed(terms.prescribed, column as usize);
    for &(k, local) in terms.rows.row(row) {
        let (contact, local) = (&terms.contacts[k as usize], local as usize);
        let (vertex, levers) = (contact.vertex as usize, &levers[k as usize * stride..]);
        let own = levers[local];
        *force += contact.force * own;
        let scaled = own * contact.stiffness;
        let mut add_column = |target: usize, other: DVec3| {
            let block = DMat3::from_cols(scaled * other.x, scaled * other.y, scaled * other.z);
            add(&mut out[target], &block.to_cols_array());
        };
        let blocks = skin.coarse.blocks(vertex);
        let own_blocks = blocks.len() + skin.fine.row(vertex).len();
        if local < blocks.len() {
            let targets = skin.coarse.targets(vertex, local).iter().zip(blocks);
            for ((&target, &column), &other) in targets.zip(levers) {
                if !left_out(column) {
                    add_column(target as usize, other);
                }
            }
        } else {
            // A frame's row has a block in every column, a slot's too.
            let columns = blocks.iter().copied().chain(skin.slots(vertex));
            for (column, &other) in columns.zip(levers) {
                if column as usize <= row && !left_out(column) {
                    add_column(column as usize, other);
                }
            }
        }
        let Some(body) = contact.body else {
            continue;
        };
        let columns = terms.pattern.columns().row(row);
        for (column, &other) in (2 * body..2 * body + 2).zip(&levers[own_blocks..]) {
            if column as usize <= row && !left_out(column) {
                add_column(columns.partition_point(|&c| c < column), other);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Mat9, Random, Vec9};
    use crate::potential::BlockPattern;
    use crate::potential::cpu::Points;
    use crate::potential::cpu::point_hessian::{PointTerms, point_hessian};
    use crate::random_avatar::random_avatar;

    #[test]
    fn blocks_made_in_place_are_the_stored_ones() {
        let avatar = random_avatar(2, 3, 9, 15, 12);
        let space = avatar.space();
        let points = Points::new(
            "cubature",
            space,
            &avatar.cubature.skinning,
            &avatar.cubature.basis,
        )
        .unwrap();
        let pattern = BlockPattern::new(space, &[], &[&avatar.cubature]);
        let incidence = points.incidence(&pattern);
        let random = &mut Random::new(3);
        let terms: Vec<PointTerms> = (0..points.len())
            .map(|_| PointTerms {
                inertia: random.uniform(0.5, 1.0),
                force: random.vector(1.0),
                pulled_force: random.vector(1.0),
                stress: random.matrix(1.0),
                blended: random.matrix(1.0),
                metric: random.matrix(1.0),
            })
            .collect();
        let arms: Vec<_> = (0..points.skinning.entries().len())
            .map(|_| random.vector(1.0))
            .collect();
        // C is symmetric.
        let tangents: Vec<Mat9> = (0..points.len())
            .map(|_| {
                let q: Vec9 = std::array::from_fn(|_| random.uniform(-1.0, 1.0));
                q.map(|a| q.map(|b| a * b))
            })
            .collect();
        let view = |i: usize| PointView {
            terms: &terms[i],
            skinning: points.skinning.row(i),
            arms: &arms[points.skinning.range(i)],
            basis: points.basis.row(i),
            tangent: &tangents[i],
            prescribed: &[],
        };
        let stored: Vec<Vec<DMat3>> = (0..points.len())
            .map(|i| {
                let count = incidence.blocks(i).len();
                let mut out = vec![DMat3::NAN; count * (count + 1) / 2];
                point_hessian(&view(i), &mut out);
                out
            })
            .collect();
        for row in 0..space.blocks() {
            let width = pattern.columns().row(row).len();
            let (mut direct, mut gathered) = (vec![[0.0; 9]; width], vec![[0.0; 9]; width]);
            let mut force = DVec3::ZERO;
            gather_points(&incidence, row, view, &mut force, &mut direct);
            gather_blocks(&incidence, row, |i| &stored[i], &mut gathered);
            assert_eq!(direct, gathered);
            assert!(force.is_finite());
        }
    }
}
