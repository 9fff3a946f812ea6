//! Wavefront OBJ, as [`crate::obj::read::read_obj`] reads it.

use std::fmt::Write;
use std::path::Path;
use supple::Result;
use supple::internal::write_whole;
use supple::model::Surface;

/// Writes named surfaces to `path`, one object each, with every digit of their positions.
pub fn write_obj<'a>(
    objects: impl IntoIterator<Item = (&'a str, &'a Surface)>,
    path: impl AsRef<Path>,
) -> Result<()> {
    let mut text = String::new();
    let mut first = 1;
    for (name, surface) in objects {
        // Writing to a String cannot fail.
        let _ = writeln!(text, "o {name}");
        for p in &surface.positions {
            let _ = writeln!(text, "v {} {} {}", p.x, p.y, p.z);
        }
        for [a, b, c] in surface.triangles.iter().map(|t| t.map(|v| v + first)) {
            let _ = writeln!(text, "f {a} {b} {c}");
        }
        first += surface.positions.len() as u32;
    }
    write_whole(path, text)
}
