//! An avatar with some of its fine handles awake, as a space of its own: what waking them can do, apart from how a step
//! wakes them.

use glam::{DMat3, DVec3};
use supple::internal::math::Rows;
use supple::model::{Avatar, FineHandles, PointSet};
use supple::{Error, Result};
use supple_bake::all_tets;
use supple_bake::subspace::Subspace;

/// What carries the tissue's energy.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Points {
    /// The coarse points, in cells that are awake with their children.
    TwoLevels,
    /// Every tet.
    AllTets,
}

/// Blocks (handle, N) of the coarse handles at each node: numbers times the identity, as the avatar has them.
pub fn scalar_blocks(avatar: &Avatar) -> Rows<(u32, DMat3)> {
    let scaled = |&(h, u): &(u32, f64)| (h, DMat3::from_diagonal(DVec3::splat(u)));
    let held = &avatar.layer.bone_of_node;
    let rows = avatar.layer.basis.iter().zip(held);
    rows.map(|(row, bone)| row.iter().filter(|_| bone.is_none()).map(scaled))
        .collect()
}

/// The `count` fine handles nearest to `place`, rising.
pub fn nearest(fine: &FineHandles, place: DVec3, count: usize) -> Vec<u32> {
    let mut order: Vec<u32> = (0..fine.len() as u32).collect();
    let distance = |h: &u32| fine.positions[*h as usize].distance_squared(place);
    order.sort_by(|a, b| distance(a).total_cmp(&distance(b)).then(a.cmp(b)));
    order.truncate(count);
    order.sort_unstable();
    order
}

/// The space of the coarse handles, of blocks `coarse`, and of the fine ones that are `awake`, which rise; those come last.
///
/// # Errors
/// [`Error::Invalid`] where a handle of `awake` is not there; as [`Subspace::new`].
pub fn awake_space(
    avatar: &Avatar,
    coarse: &Rows<(u32, DMat3)>,
    awake: &[u32],
    points: Points,
) -> Result<Subspace> {
    let fine = &*avatar.fine;
    if awake.iter().any(|&h| h as usize >= fine.len()) {
        let problem = format!("names one that is not there; there are {}", fine.len());
        return Err(Error::invalid("awake", problem));
    }
    let first = avatar.handles.len() as u32;
    let at_node = |coarse: &[(u32, DMat3)], fine: &[(u32, [f32; 9])]| {
        let mut row = coarse.to_vec();
        for (h, n) in fine {
            if let Ok(slot) = awake.binary_search(h) {
                let n = DMat3::from_cols_array(&n.map(f64::from));
                row.push((first + slot as u32, n));
            }
        }
        row
    };
    let nodes = match fine.is_empty() {
        true => coarse.clone(),
        false => (coarse.iter().zip(fine.nodes.iter()))
            .map(|(coarse, fine)| at_node(coarse, fine))
            .collect(),
    };
    let mut handles = avatar.handles.clone();
    handles.extend(awake.iter().map(|&h| fine.positions[h as usize]));
    let sampled = match points {
        Points::AllTets => all_tets(avatar)?,
        Points::TwoLevels => two_levels(avatar, awake),
    };
    Subspace::new(&sampled, handles, nodes)
}

/// `avatar` with the points of its second level in the cells that are awake.
fn two_levels(avatar: &Avatar, awake: &[u32]) -> Avatar {
    let fine = &*avatar.fine;
    let mut is_awake = vec![false; avatar.cubature.len()];
    for &h in awake {
        (fine.cells.row(h as usize).iter()).for_each(|&cell| is_awake[cell as usize] = true);
    }
    let mut out = avatar.clone();
    let (set, tissue) = (&mut out.cubature, &mut out.tissue);
    for cell in (0..avatar.cubature.len()).filter(|cell| is_awake[*cell]) {
        set.measure[cell] = fine.own_measure[cell];
        for child in fine.children(cell) {
            push(set, &fine.points, child);
            tissue.extend(fine.tissue.get(child));
        }
    }
    // Their blend shapes are those of the coarse points, which a press in the bind pose does not move.
    out.cubature.pose_blend = Default::default();
    out.pose_extension = Rows::default();
    out
}

fn push(set: &mut PointSet, from: &PointSet, i: usize) {
    set.position.push(from.position[i]);
    set.measure.push(from.measure[i]);
    set.skinning.push(from.skinning.row(i).iter().copied());
    set.basis.push(from.basis.row(i).iter().copied());
}
