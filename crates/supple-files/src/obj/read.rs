//! Wavefront OBJ: one surface for each object of the file.
//!
//! Of the format (<https://paulbourke.net/dataformats/obj/>) places, faces and names are read: `v`, `f`, `o`, `g`. Groups
//! are objects only where the file has none.

use crate::file::read_bytes;
use glam::DVec3;
use std::collections::HashMap;
use std::path::Path;
use supple::model::Surface;
use supple::{Error, Result};

/// Reads the objects of the OBJ file at `path` with their names; polygons are cut into triangles.
/// Vertices come in the order in which faces first use them; those that no face uses are left out.
///
/// # Errors
/// [`Error::Io`] where the file cannot be read, [`Error::Format`] with the line where it is broken, and where it
/// holds a number that is not finite, or no face.
pub fn read_obj(path: impl AsRef<Path>) -> Result<Vec<(String, Surface)>> {
    let path = path.as_ref();
    parse_obj(&read_bytes(path)?, path)
}

/// Reads the objects of an OBJ file's `bytes`; `path` names it in errors. See [`read_obj`].
pub fn parse_obj(bytes: &[u8], path: &Path) -> Result<Vec<(String, Surface)>> {
    let lines = || bytes.split(|b| *b == b'\n').map(String::from_utf8_lossy);
    let has_objects = lines().any(|line| line.trim_start().starts_with("o "));
    let mut file = ObjFile::default();
    let mut continued = String::new();
    for (number, line) in lines().enumerate() {
        // A backslash at its end carries a line on.
        if let Some(start) = line.trim_end().strip_suffix('\\') {
            continued.push_str(start);
            continue;
        }
        continued.push_str(&line);
        file.line(&continued, has_objects)
            .map_err(|problem| Error::format(path, format!("line {}", number + 1), problem))?;
        continued.clear();
    }
    file.objects.retain(|object| !object.1.triangles.is_empty());
    if file.objects.is_empty() {
        return Err(Error::format(path, "faces", "there are none"));
    }
    Ok(file.objects)
}

#[derive(Default)]
struct ObjFile {
    places: Vec<DVec3>,
    objects: Vec<(String, Surface)>,
    /// The last object's vertex for each of the file's.
    vertices: HashMap<usize, u32>,
}

impl ObjFile {
    fn line(&mut self, line: &str, has_objects: bool) -> Result<(), String> {
        let mut words = line.split_ascii_whitespace();
        match words.next() {
            Some("v") => {
                let mut next = || {
                    let number = words.next().and_then(|w| w.parse::<f64>().ok());
                    number
                        .filter(|x| x.is_finite())
                        .ok_or("a vertex needs three finite numbers")
                };
                self.places.push(DVec3::new(next()?, next()?, next()?));
            }
            Some("f") => {
                let corners: Vec<u32> = words
                    .map(|word| self.corner(word))
                    .collect::<Result<_, _>>()?;
                let [first, others @ ..] = &corners[..] else {
                    return Err("a face needs three vertices".into());
                };
                if others.len() < 2 {
                    return Err("a face needs three vertices".into());
                }
                let triangles = others.windows(2).map(|pair| [*first, pair[0], pair[1]]);
                self.object().triangles.extend(triangles);
            }
            Some("o") => self.begin(line),
            Some("g") if !has_objects => self.begin(line),
            _ => {}
        }
        Ok(())
    }

    /// A new object, called what stands after the line's first word.
    fn begin(&mut self, line: &str) {
        let name = line.trim().split_once(|c: char| c.is_ascii_whitespace());
        let name = name.map_or("", |n| n.1.trim());
        self.objects.push((name.to_string(), Surface::default()));
        self.vertices.clear();
    }

    fn object(&mut self) -> &mut Surface {
        if self.objects.is_empty() {
            self.begin("o unnamed");
        }
        let last = self.objects.len() - 1;
        &mut self.objects[last].1
    }

    /// The vertex of a face's `place/texture/normal`: counted from 1, or from the end below 0.
    fn corner(&mut self, word: &str) -> Result<u32, String> {
        let place = word.split('/').next().unwrap_or("");
        let known = self.places.len();
        let index = place.parse::<i64>().ok().and_then(|i| match i {
            1.. => usize::try_from(i - 1).ok(),
            _ => known.checked_sub(usize::try_from(i.unsigned_abs()).ok().filter(|i| *i > 0)?),
        });
        let found = index.and_then(|i| Some((i, *self.places.get(i)?)));
        let (index, place) = found.ok_or_else(|| {
            let shown: String = word.chars().take(20).collect();
            format!("a face names vertex `{shown}` of {known} so far")
        })?;
        if let Some(&vertex) = self.vertices.get(&index) {
            return Ok(vertex);
        }
        let surface = self.object();
        let vertex = surface.positions.len() as u32;
        surface.positions.push(place);
        self.vertices.insert(index, vertex);
        Ok(vertex)
    }
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
