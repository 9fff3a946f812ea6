//! A skin made fit for meshing: every triangle once, all looking outward, holes closed by caps.
//!
//! Nothing here stops a mesher. What was found is in the [`SkinReport`].

mod edges;
mod holes;
mod orientation;
mod stitch;
#[cfg(test)]
mod tests;

use super::report::SkinReport;
use super::self_intersections::self_intersections;
use edges::{mark_non_manifold, parts};
use holes::close_holes;
use orientation::{make_consistent, same_way, turn_outward};
use stitch::{distinct_triangles, stitch};
use supple::model::Surface;
use supple::{Error, Result};

/// A skin whose triangles bound a solid: along any line the winding number starts and ends at 0.
pub(crate) struct SoundSkin {
    /// The skin's vertices, then one in the middle of each hole; the skin's triangles, then the caps.
    pub surface: Surface,
    /// How many of the triangles are the skin's own.
    pub skin_triangles: usize,
    /// For each vertex the one that stands for it: another one in the same place on the border of the same
    /// seam, or itself.
    pub stands_for: Vec<u32>,
    /// Vertices around holes and on non-manifold edges, which the bones hold.
    pub held: Vec<bool>,
    /// The vertices around each hole; hole `h` has vertex `vertices + h` in its middle.
    pub rims: Vec<Vec<u32>>,
    /// The skin's triangles as they came, but all looking outward.
    pub oriented: Vec<[u32; 3]>,
    /// What was found.
    pub report: SkinReport,
}

impl SoundSkin {
    /// Looks through `skin`, turns what looks inward and closes holes.
    ///
    /// # Errors
    /// [`Error::Invalid`] where a position is not finite, a triangle names a vertex that is not there, or
    /// there is no triangle at all.
    pub fn new(skin: &Surface) -> Result<Self> {
        let vertices = skin.positions.len();
        if !skin.positions.iter().all(|p| p.is_finite())
            || (skin.triangles.iter().flatten()).any(|&v| v as usize >= vertices)
        {
            let problem = "holds a value that is not finite, or names a vertex that is not there";
            return Err(Error::invalid("skin", problem));
        }
        let mut report = SkinReport {
            vertices,
            triangles: skin.triangles.len(),
            ..SkinReport::default()
        };
        let stands_for = stitch(skin, &mut report);
        let mut surface = Surface {
            positions: skin.positions.clone(),
            triangles: (skin.triangles.iter())
                .map(|t| t.map(|v| stands_for[v as usize]))
                .collect(),
        };
        let kept = distinct_triangles(&surface, &stands_for, &mut report);
        if kept.is_empty() {
            return Err(Error::invalid("skin", "has no triangle with area"));
        }
        let all = std::mem::take(&mut surface.triangles);
        surface.triangles = kept.iter().map(|&t| all[t]).collect();
        let mut held = vec![false; vertices];
        make_consistent(&mut surface);
        mark_non_manifold(&surface, &mut held, &mut report);
        let part = parts(&surface, &mut report);
        let skin_triangles = kept.len();
        let rims = close_holes(&mut surface, &mut held, &mut report);
        turn_outward(&mut surface, &part);

        let mut oriented = skin.triangles.clone();
        for (&t, turned) in kept.iter().zip(&surface.triangles) {
            if !same_way(all[t], *turned) {
                oriented[t].swap(1, 2);
                report.turned_triangles += 1;
            }
        }
        Ok(Self {
            surface,
            skin_triangles,
            stands_for,
            held,
            rims,
            oriented,
            report,
        })
    }

    /// The report with the self-intersections counted.
    pub fn full_report(&self) -> SkinReport {
        let mut report = self.report.clone();
        report.self_intersections = self_intersections(&self.skin());
        report
    }

    /// The surface without the vertices that it does not use, and the vertex that each was.
    pub fn compact(&self) -> (Surface, Vec<u32>) {
        let mut used = vec![false; self.surface.positions.len()];
        (self.surface.triangles.iter().flatten()).for_each(|&v| used[v as usize] = true);
        let old: Vec<u32> = (0..used.len() as u32)
            .filter(|&v| used[v as usize])
            .collect();
        let mut new = vec![0; used.len()];
        (old.iter().enumerate()).for_each(|(n, &v)| new[v as usize] = n as u32);
        let surface = Surface {
            positions: old
                .iter()
                .map(|&v| self.surface.positions[v as usize])
                .collect(),
            triangles: (self.surface.triangles.iter())
                .map(|t| t.map(|v| new[v as usize]))
                .collect(),
        };
        (surface, old)
    }

    /// The cap of hole `h`, looking outward.
    pub fn cap(&self, h: usize) -> Surface {
        let centre = (self.report.vertices + h) as u32;
        let caps = self.surface.triangles[self.skin_triangles..]
            .iter()
            .copied();
        Surface {
            positions: self.surface.positions.clone(),
            triangles: caps.filter(|t| t.contains(&centre)).collect(),
        }
    }

    /// The skin's own vertices and sound triangles.
    pub fn skin(&self) -> Surface {
        Surface {
            positions: self.surface.positions[..self.report.vertices].to_vec(),
            triangles: self.surface.triangles[..self.skin_triangles].to_vec(),
        }
    }
}
