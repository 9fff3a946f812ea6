//! Wavefront OBJ: one surface for each object of the file.

use super::file::read_bytes;
use crate::model::Surface;
use crate::{Error, Result};
use glam::DVec3;
use std::path::Path;

/// Reads the objects of the OBJ file at `path` with their names; polygons are cut into triangles.
/// Vertices come in the order in which faces first use them; those that no face uses are left out.
///
/// # Errors
/// [`Error::Io`] where the file cannot be read, [`Error::Format`] where it is broken, holds a number
/// that is not finite, or no face.
pub fn read_obj(path: impl AsRef<Path>) -> Result<Vec<(String, Surface)>> {
    let path = path.as_ref();
    parse_obj(&read_bytes(path)?, path)
}

/// Reads the objects of an OBJ file's `bytes`; `path` names it in errors. See [`read_obj`].
pub fn parse_obj(bytes: &[u8], path: &Path) -> Result<Vec<(String, Surface)>> {
    let options = tobj::LoadOptions {
        triangulate: true,
        ignore_points: true,
        ignore_lines: true,
        ..Default::default()
    };
    // Materials are of no use here; their files need not be there.
    let no_materials = |_: &Path| Ok(Default::default());
    let mut reader = bytes;
    let (models, _) = tobj::load_obj_buf(&mut reader, &options, no_materials)
        .map_err(|e| Error::format(path, "faces", format!("is no OBJ file: {e}")))?;
    let objects: Vec<_> = models
        .into_iter()
        .filter(|m| !m.mesh.indices.is_empty())
        .map(|m| {
            let surface = Surface {
                positions: m
                    .mesh
                    .positions
                    .chunks_exact(3)
                    .map(DVec3::from_slice)
                    .collect(),
                triangles: m.mesh.indices.as_chunks().0.to_vec(),
            };
            (m.name, surface)
        })
        .collect();
    if objects.is_empty() {
        return Err(Error::format(path, "faces", "there are none"));
    }
    for (name, surface) in &objects {
        if surface.positions.iter().any(|p| !p.is_finite()) {
            return Err(Error::format(
                path,
                name,
                "holds a vertex that is not finite",
            ));
        }
    }
    Ok(objects)
}

/// Reads the objects of the OBJ file at `path`, each of which must be a closed surface seen from
/// outside.
///
/// # Errors
/// Those of [`read_obj`], and [`Error::Format`] naming the object that is open or inside out.
pub fn read_closed_obj(path: impl AsRef<Path>) -> Result<Vec<(String, Surface)>> {
    let path = path.as_ref();
    let objects = read_obj(path)?;
    for (name, surface) in &objects {
        if !surface.is_closed() {
            let problem = "is not closed: every edge must join two triangles; weld and fill it";
            return Err(Error::format(path, name, problem));
        }
        if surface.volume() <= 0.0 {
            return Err(Error::format(path, name, "is inside out: flip its faces"));
        }
    }
    Ok(objects)
}
