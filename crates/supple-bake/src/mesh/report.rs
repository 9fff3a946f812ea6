//! What a mesher found in a skin and made of it.

use super::{MeshQuality, SoundSkin};
use serde::{Deserialize, Serialize};
use std::fmt;
use supple::Result;
use supple::model::Surface;

/// A hole in a skin: a loop of edges that have a triangle on one side only. It is closed by a cap for the
/// inside test and the volume, and the bones hold its vertices.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Hole {
    /// Edges around it.
    pub edges: usize,
    /// Length of its edges, m.
    pub perimeter: f64,
    /// Mean of its vertices, m.
    pub place: [f64; 3],
}

/// What is wrong with a skin; none of it stops a mesher.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SkinReport {
    /// Vertices.
    pub vertices: usize,
    /// Triangles.
    pub triangles: usize,
    /// Parts that share no vertex, each meshed by itself.
    pub parts: usize,
    /// Holes: closed by caps.
    pub holes: Vec<Hole>,
    /// Edges of three triangles or more, or of two that face opposite ways: held by their bones.
    pub non_manifold_edges: usize,
    /// Triangles with the vertices of another one: meshed once.
    pub duplicate_triangles: usize,
    /// Triangles without area: not meshed.
    pub degenerate_triangles: usize,
    /// Vertices of no triangle: they follow their bones.
    pub isolated_vertices: usize,
    /// Vertices of a seam, where parts that follow their bones differently meet: joined in the mesh.
    pub stitched_vertices: usize,
    /// Triangles that looked inward: turned.
    pub turned_triangles: usize,
    /// Pairs of triangles that cut each other without sharing a vertex: inside is by winding number.
    pub self_intersections: usize,
}

/// Figures of a layer's mesh.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MeshReport {
    /// What made the mesh, and why that.
    pub mesher: String,
    /// The skin it started from.
    pub skin: SkinReport,
    /// Tets and their angles.
    pub quality: MeshQuality,
    /// Volume that the skin encloses, its holes closed, m³.
    pub skin_volume: f64,
    /// Volume of the tissue, m³.
    pub tissue_volume: f64,
    /// What is left inside the skin, m³.
    pub core_volume: f64,
    /// Depth of the tissue under the skin's vertices: least, median, greatest, m.
    pub thickness: [f64; 3],
    /// Skin vertices that have no tissue under them: they follow their bones.
    pub bare_vertices: usize,
    /// Bones whose surface was derived from joints and skin weights.
    pub derived_bones: usize,
}

impl SkinReport {
    /// Looks `skin` over.
    ///
    /// # Errors
    /// [`supple::Error::Invalid`] where it names a vertex that is not there or holds a value that is not finite.
    pub fn of(skin: &Surface) -> Result<Self> {
        Ok(SoundSkin::new(skin)?.full_report())
    }
}

impl fmt::Display for SkinReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{} vertices, {} triangles",
            self.vertices, self.triangles
        )?;
        let mut tell = |count: usize, one: &str, many: &str| match count {
            0 => Ok(()),
            1 => write!(f, ", 1 {one}"),
            _ => write!(f, ", {count} {many}"),
        };
        if self.parts > 1 {
            tell(self.parts, "part", "parts")?;
        }
        tell(self.holes.len(), "hole (closed)", "holes (closed)")?;
        tell(
            self.non_manifold_edges,
            "non-manifold edge",
            "non-manifold edges",
        )?;
        tell(
            self.duplicate_triangles,
            "duplicate triangle",
            "duplicate triangles",
        )?;
        tell(
            self.degenerate_triangles,
            "degenerate triangle",
            "degenerate triangles",
        )?;
        tell(
            self.isolated_vertices,
            "isolated vertex",
            "isolated vertices",
        )?;
        tell(
            self.stitched_vertices,
            "stitched vertex",
            "stitched vertices",
        )?;
        tell(self.turned_triangles, "triangle turned", "triangles turned")?;
        tell(
            self.self_intersections,
            "self-intersecting pair",
            "self-intersecting pairs",
        )
    }
}
