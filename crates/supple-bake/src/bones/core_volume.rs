//! The rigid core of a body: what is inside the skin and not tissue, sampled on a grid.

use crate::body::Body;
use crate::math::NearestPoint;
use crate::mesh::{Grid, SoundSkin};
use glam::DVec3;
use supple::model::Surface;

/// A cell of the core.
pub(crate) struct CoreSample {
    pub position: DVec3,
    /// m³.
    pub volume: f64,
    /// The closest node of the layer that a bone holds; node 0 if none does.
    pub nearest_node: u32,
}

/// Cells in the box around the body.
const CELLS: f64 = 5e5;

/// Grid cells whose centre is inside the skin, outside the layer and outside every surface of
/// `known`. Inside is by winding number, so a skin that cuts through itself does no harm; holes are
/// closed by caps.
pub(crate) fn core_samples(body: &Body, known: &[&Surface]) -> Vec<CoreSample> {
    let Ok(SoundSkin { surface: skin, .. }) = SoundSkin::new(&body.skin) else {
        return Vec::new();
    };
    let layer = Surface {
        positions: body.layer.mesh.nodes.clone(),
        triangles: body.layer.mesh.boundary_triangles(),
    };
    let positions = || skin.positions.iter().copied();
    let (Some(low), Some(high)) = (
        positions().reduce(DVec3::min),
        positions().reduce(DVec3::max),
    ) else {
        return Vec::new();
    };
    let cell = ((high - low).element_product() / CELLS).cbrt();
    if !(cell > 0.0 && cell.is_finite()) {
        return Vec::new();
    }
    // Off by an odd share of a cell, so that no line runs along an edge of a regular mesh.
    let grid = Grid {
        origin: low + cell * DVec3::new(0.5, 0.4827, 0.4683),
        spacing: cell,
        counts: ((high - low) / cell).to_array().map(|n| n.ceil() as usize),
    };
    let mut core = inside(&grid, &skin);
    for solid in std::iter::once(&layer).chain(known.iter().copied()) {
        let held = inside(&grid, solid);
        core.iter_mut().zip(held).for_each(|(c, h)| *c &= !h);
    }
    let (held, places): (Vec<u32>, Vec<DVec3>) = (body.layer.bone_of_node.iter().enumerate())
        .filter(|(_, bone)| bone.is_some())
        .map(|(n, _)| (n as u32, body.layer.mesh.nodes[n]))
        .unzip();
    let search = NearestPoint::new(&places);
    let cells: Vec<usize> = (0..core.len()).filter(|&i| core[i]).collect();
    supple::internal::math::par_map(cells.len(), |c| {
        let [nx, ny, _] = grid.counts;
        let (i, j, k) = (cells[c] % nx, cells[c] / nx % ny, cells[c] / (nx * ny));
        let position = grid.origin + cell * DVec3::new(i as f64, j as f64, k as f64);
        CoreSample {
            position,
            volume: cell.powi(3),
            nearest_node: (search.nearest(position)).map_or(0, |(k, _)| held[k as usize]),
        }
    })
}

/// Which samples of `grid` are inside `surface`, x running fastest.
fn inside(grid: &Grid, surface: &Surface) -> Vec<bool> {
    let nx = grid.counts[0];
    let mut out = vec![false; grid.counts.iter().product()];
    for (line, runs) in grid.inside_runs(surface, 0).iter().enumerate() {
        for &(first, last) in runs {
            out[line * nx + first as usize..=line * nx + last as usize].fill(true);
        }
    }
    out
}
