//! Series of a run, read.

use super::{ENERGY_NAMES, Series};
use crate::{file, npz};
use glam::DVec3;
use std::path::Path;
use supple::Result;

/// Reads what [`write_series`](super::write_series) wrote.
///
/// # Errors
/// [`supple::Error::Io`]; [`supple::Error::Format`] with the array, what was expected and what was found.
pub fn read_series(path: impl AsRef<Path>) -> Result<Series> {
    let path = path.as_ref();
    parse_series(&file::read_bytes(path)?, path)
}

/// Reads a series from a file's `bytes`; `path` names it in errors. See [`read_series`].
pub fn parse_series(bytes: &[u8], path: &Path) -> Result<Series> {
    let wanted = [
        "time",
        "vertices",
        "displacement",
        "contact_force",
        "loads",
        "energies",
        "energy_names",
        "faces",
        "bone_names",
    ];
    let archive = npz::parse(bytes, path, &wanted)?;
    let time = archive.expect("time", &[None])?.numbers.clone();
    let steps = Some(time.len());
    let vertices = archive.expect("vertices", &[steps, None, Some(3)])?.shape[1];
    let vectors = |key: &str| -> Result<Vec<DVec3>> {
        let array = archive.expect(key, &[steps, Some(vertices), Some(3)])?;
        let places = array.numbers.chunks_exact(3);
        Ok(places.map(DVec3::from_slice).collect())
    };
    let texts = |key: &str| -> Result<Vec<String>> {
        let array = archive.get(key)?;
        Ok(array.map(|a| a.texts.clone()).unwrap_or_default())
    };
    let names = texts("energy_names")?;
    if names != ENERGY_NAMES {
        let problem = format!("{names:?}, expected {ENERGY_NAMES:?}");
        return Err(archive.broken("energy_names", problem));
    }
    let bone_names = texts("bone_names")?;
    let shape = [steps, Some(bone_names.len()), Some(6)];
    let loads = &archive.expect("loads", &shape)?.numbers;
    let energies = &archive
        .expect("energies", &[steps, Some(names.len())])?
        .numbers;
    let faces = archive.expect("faces", &[None, Some(3)])?;
    let faces: Vec<u32> = faces.numbers.iter().map(|v| *v as u32).collect();
    Ok(Series {
        vertices: vectors("vertices")?,
        displacement: vectors("displacement")?,
        contact_force: vectors("contact_force")?,
        loads: loads.as_chunks().0.to_vec(),
        energies: energies.as_chunks().0.to_vec(),
        faces: faces.as_chunks().0.to_vec(),
        bone_names,
        time,
    })
}
