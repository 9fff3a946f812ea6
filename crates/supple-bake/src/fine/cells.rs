//! The cubature's second level: the cells of the coarse points, which wake with a handle, and their finer points.
//!
//! A cell is the tets nearest to a coarse point, a sub-cell those of them nearest to one of the cell's points. A point's
//! weight is the tissue volume of its sub-cell: positive, additive, and Σ w is the tissue's. The children of a cell do not sum to
//! the coarse point's weight, which stands for more or less than its cell.

use crate::cubature::Tissue;
use crate::cubature::candidates as tissue_tets;
use crate::handles::{Density, farthest_points};
use crate::math::NearestPoint;
use glam::{DMat3, DVec3};
use std::collections::BTreeSet;
use supple::internal::math::{Rows, par_map};

/// A cell is awake with a handle whose block is larger than this at one of the cell's nodes; 1 is the identity. With 0.3 the
/// coarse points around see too little of it where there are few of them for the tets: of 30 awake handles on limb M a press
/// is then off by 39 % in place of 25, as with all tets. On limb S, where a point stands for 12 tets, both do.
const WAKES: f64 = 0.1;

/// The points of the second level.
#[derive(Debug, Default, PartialEq)]
pub(super) struct Cells {
    /// The tets that carry one, cell after cell.
    pub tets: Vec<u32>,
    /// The cell of each, rising.
    pub cell_of_point: Vec<u32>,
    /// Weight of each, m³.
    pub measure: Vec<f64>,
    /// Weight of each coarse point beside its children, m³.
    pub own_measure: Vec<f64>,
    /// The cells that each handle wakes.
    pub of_handle: Rows<u32>,
}

impl Cells {
    /// Of the coarse points at the centroids of the tets `coarse`, with `points` further ones where there are so many tets.
    /// `nodes` are the blocks of each node, of `handles` handles.
    pub fn new(
        tissue: Tissue<'_>,
        coarse: &[u32],
        nodes: &Rows<(u32, DMat3)>,
        handles: usize,
        points: usize,
    ) -> Self {
        let mesh = tissue.mesh;
        let centroid = |&t: &u32| mesh.centroid(t as usize);
        let centres: Vec<DVec3> = coarse.iter().map(centroid).collect();
        let cell_of_tet = nearest_of(&centres, (0..mesh.tets.len() as u32).map(|t| centroid(&t)));
        let of_handle = waking(tissue, &cell_of_tet, nodes, handles);

        let mut can_wake = vec![false; coarse.len()];
        (of_handle.entries().iter()).for_each(|&c| can_wake[c as usize] = true);
        let mut taken = vec![false; mesh.tets.len()];
        coarse.iter().for_each(|&t| taken[t as usize] = true);
        let fits = |t: &u32| !taken[*t as usize] && can_wake[cell_of_tet[*t as usize] as usize];
        let candidates: Vec<u32> = tissue_tets(tissue, 0).into_iter().filter(fits).collect();
        let places: Vec<DVec3> = candidates.iter().map(centroid).collect();
        let chosen = farthest_points(&places, &centres, Density::Count(points));
        let mut chosen: Vec<(u32, u32)> = (chosen.iter())
            .map(|&i| candidates[i as usize])
            .map(|t| (cell_of_tet[t as usize], t))
            .collect();
        chosen.sort_unstable();
        let tets: Vec<u32> = chosen.iter().map(|c| c.1).collect();
        let cell_of_point: Vec<u32> = chosen.iter().map(|c| c.0).collect();

        let mut own_measure = vec![0.0; coarse.len()];
        let mut measure = vec![0.0; tets.len()];
        let volumes = tissue.tet_volumes();
        let nearest = par_map(mesh.tets.len(), |t| {
            let (cell, place) = (cell_of_tet[t], mesh.centroid(t));
            let first = |cell: u32| cell_of_point.partition_point(|&c| c < cell);
            let children = first(cell)..first(cell + 1);
            let distance = |child: usize| centroid(&tets[child]).distance_squared(place);
            // The first of equals, and the coarse point before all.
            let mut best = (None, centres[cell as usize].distance_squared(place));
            for child in children {
                if distance(child) < best.1 {
                    best = (Some(child), distance(child));
                }
            }
            best.0
        });
        for ((nearest, volume), &cell) in nearest.into_iter().zip(volumes).zip(&cell_of_tet) {
            match nearest {
                Some(child) => measure[child] += volume,
                None => own_measure[cell as usize] += volume,
            }
        }
        Self {
            tets,
            cell_of_point,
            measure,
            own_measure,
            of_handle,
        }
    }
}

/// Index of the nearest of `points` to each place.
fn nearest_of(points: &[DVec3], places: impl Iterator<Item = DVec3>) -> Vec<u32> {
    let search = NearestPoint::new(points);
    let places: Vec<DVec3> = places.collect();
    par_map(places.len(), |i| {
        search.nearest(places[i]).map_or(0, |(found, _)| found)
    })
}

/// The cells, rising, that have a node at which the handle's block is large.
fn waking(
    tissue: Tissue<'_>,
    cell_of_tet: &[u32],
    nodes: &Rows<(u32, DMat3)>,
    handles: usize,
) -> Rows<u32> {
    let size = |n: &DMat3| {
        let squares: f64 = n.to_cols_array().iter().map(|e| e * e).sum();
        (squares / 3.0).sqrt()
    };
    let mut cells = vec![BTreeSet::new(); handles];
    for (tet, &cell) in tissue.mesh.tets.iter().zip(cell_of_tet) {
        for &node in tet {
            for (handle, block) in nodes.row(node as usize) {
                if size(block) > WAKES {
                    cells[*handle as usize].insert(cell);
                }
            }
        }
    }
    cells.into_iter().collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_mesh::partly_tissue;

    /// Blocks that are 0.9 at one node and 0.05 at another.
    fn blocks(nodes: usize, strong: u32, weak: u32) -> Rows<(u32, DMat3)> {
        let block = |u: f64| DMat3::from_diagonal(DVec3::splat(u));
        let row = |n: u32| match n {
            n if n == strong => Some((0, block(0.9))),
            n if n == weak => Some((0, block(0.05))),
            _ => None,
        };
        (0..nodes as u32).map(row).collect()
    }

    #[test]
    fn sub_cells_share_the_tissue_and_cells_wake_where_blocks_are_large() {
        let (mesh, fraction) = partly_tissue();
        let tissue = Tissue {
            mesh: &mesh,
            fraction: &fraction,
        };
        let coarse: Vec<u32> = (0..40).map(|i| i * 49 + 3).collect();
        let (strong, weak) = (mesh.tets[700][0], mesh.tets[100][0]);
        let nodes = blocks(mesh.nodes.len(), strong, weak);
        let cells = Cells::new(tissue, &coarse, &nodes, 1, 60);
        let sum: f64 = cells.own_measure.iter().chain(&cells.measure).sum();
        assert!((sum / tissue.moments().0 - 1.0).abs() < 1e-12, "{sum}");
        let weights = cells.own_measure.iter().chain(&cells.measure);
        assert!(weights.into_iter().all(|w| *w > 0.0));
        assert!(cells.cell_of_point.is_sorted());
        // Each tet counts for the nearest point of the cell of its nearest coarse point.
        let at = |t: u32| mesh.centroid(t as usize);
        let nearest = |place: DVec3, of: &mut dyn Iterator<Item = u32>| {
            let distance = |t: &u32| at(*t).distance(place);
            of.min_by(|a, b| distance(a).total_cmp(&distance(b)))
                .unwrap()
        };
        let mut expected = std::collections::BTreeMap::new();
        for (t, volume) in (0..).zip(tissue.tet_volumes()) {
            let cell = nearest(at(t), &mut coarse.iter().copied());
            let of_cell = |(child, c): (&u32, &u32)| {
                let own = coarse[*c as usize] == cell;
                own.then_some(*child)
            };
            let children = cells.tets.iter().zip(&cells.cell_of_point);
            let children = children.filter_map(of_cell);
            let point = nearest(at(t), &mut std::iter::once(cell).chain(children));
            *expected.entry(point).or_insert(0.0) += volume;
        }
        let points = coarse.iter().chain(&cells.tets);
        let measures = cells.own_measure.iter().chain(&cells.measure);
        for (point, measure) in points.zip(measures) {
            assert!((measure / expected[point] - 1.0).abs() < 1e-12, "{point}");
        }
        // Cells of the tets around the strong node wake, and those alone have children.
        let around = |node: u32| -> BTreeSet<u32> {
            let tets = mesh.tets.iter().enumerate();
            let tets = tets.filter(|(_, tet)| tet.contains(&node));
            let cell = |t: usize| {
                let distance = |c: &u32| mesh.centroid(*c as usize).distance(mesh.centroid(t));
                let order = |a: &u32, b: &u32| {
                    distance(&coarse[*a as usize]).total_cmp(&distance(&coarse[*b as usize]))
                };
                (0..40u32).min_by(order).unwrap()
            };
            tets.map(|(t, _)| cell(t)).collect()
        };
        let awake: BTreeSet<u32> = cells.of_handle.row(0).iter().copied().collect();
        assert_eq!(awake, around(strong));
        assert!(!around(weak).is_subset(&awake));
        assert!(!cells.tets.is_empty() && cells.tets.len() <= 60);
        assert!(cells.cell_of_point.iter().all(|c| awake.contains(c)));
        assert!(cells.tets.iter().all(|t| !coarse.contains(t)));
        assert!(cells.tets.iter().all(|&t| fraction[t as usize] >= 0.5));
    }

    #[test]
    fn where_every_tet_is_a_point_none_has_a_child() {
        let (mesh, fraction) = partly_tissue();
        let tissue = Tissue {
            mesh: &mesh,
            fraction: &fraction,
        };
        let all: Vec<u32> = (0..mesh.tets.len() as u32).collect();
        let nodes = blocks(mesh.nodes.len(), mesh.tets[700][0], mesh.tets[100][0]);
        let cells = Cells::new(tissue, &all, &nodes, 1, 60);
        assert!(cells.tets.is_empty());
        let volumes = tissue.tet_volumes();
        for (own, volume) in cells.own_measure.iter().zip(volumes) {
            assert!((own / volume - 1.0).abs() < 1e-12);
        }
    }
}
