//! Series of a run, written.

use super::{ENERGY_NAMES, Series};
use crate::npy::{encode_f64, encode_texts, encode_u32};
use crate::npz::pack_whole;
use glam::DVec3;
use std::path::Path;
use supple::internal::write_whole;
use supple::{Error, Result};

/// Writes `series` to `path` as an `.npz` archive, uncompressed as NumPy's own `savez` has it. The same series gives the
/// same bytes.
///
/// # Errors
/// [`Error::Invalid`] of lists whose lengths do not fit each other, [`Error::Io`].
pub fn write_series(series: &Series, path: impl AsRef<Path>) -> Result<()> {
    let path = path.as_ref();
    let (steps, bones) = (series.time.len(), series.bone_names.len());
    let vertices = series.vertices.len() / steps.max(1);
    for (field, found, expected) in [
        ("vertices", series.vertices.len(), steps * vertices),
        ("displacement", series.displacement.len(), steps * vertices),
        (
            "contact_force",
            series.contact_force.len(),
            steps * vertices,
        ),
        ("loads", series.loads.len(), steps * bones),
        ("energies", series.energies.len(), steps),
    ] {
        if found != expected {
            let problem = format!("{found} values, expected {expected} for {steps} steps");
            return Err(Error::invalid(format!("series.{field}"), problem));
        }
    }
    let vectors = |of: &[DVec3]| {
        let numbers: Vec<f64> = of.iter().flat_map(DVec3::to_array).collect();
        encode_f64(&[steps, vertices, 3], &numbers)
    };
    let names = ENERGY_NAMES.map(String::from);
    let arrays = [
        ("time", encode_f64(&[steps], &series.time)),
        ("vertices", vectors(&series.vertices)),
        ("displacement", vectors(&series.displacement)),
        ("contact_force", vectors(&series.contact_force)),
        (
            "loads",
            encode_f64(&[steps, bones, 6], series.loads.as_flattened()),
        ),
        (
            "energies",
            encode_f64(&[steps, names.len()], series.energies.as_flattened()),
        ),
        ("energy_names", encode_texts(&names)),
        (
            "faces",
            encode_u32(&[series.faces.len(), 3], series.faces.as_flattened()),
        ),
        ("bone_names", encode_texts(&series.bone_names)),
    ];
    let failed = |e| Error::format(path, "archive", format!("could not be packed: {e}"));
    write_whole(path, pack_whole(&arrays).map_err(failed)?)
}
