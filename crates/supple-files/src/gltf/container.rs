//! A file's JSON and its buffers: GLB, embedded, or in files beside it (glTF 2.0, chapter 4 and §3.6.1).

use super::compression::decompress;
use super::document::{Buffer, Document, Fallback};
use std::cell::Cell;
use std::collections::{BTreeMap, BTreeSet};
use std::io::Read;
use std::path::{Component, Path, PathBuf};
use supple::{Error, Result};

/// A larger file or buffer is not read.
const MOST_BYTES: u64 = 1 << 30;

/// Numbers that are read out of the accessors of one file, all together. A detailed character has ten
/// million.
const MOST_NUMBERS: u64 = 1 << 26;

/// And for each byte: views may overlap and sparse accessors need none, so a small file could ask for
/// any amount.
const MOST_NUMBERS_PER_BYTE: u64 = 1 << 10;

/// Extensions that a file may require: they are read, or change nothing of what is (materials, textures, lights, metadata).
/// A trailing `*` stands for any ending. What changes geometry and is not read is none of them.
const READABLE: [&str; 12] = [
    "KHR_draco_mesh_compression",
    "EXT_meshopt_compression",
    "KHR_meshopt_compression",
    "KHR_mesh_quantization",
    "KHR_node_visibility",
    "KHR_materials_*",
    "KHR_texture_*",
    "EXT_texture_*",
    "KHR_lights_punctual",
    "KHR_xmp*",
    "VRM",
    "VRMC_*",
];

/// A file in memory.
#[derive(Debug)]
pub(super) struct File {
    /// Names the file in errors; external buffers lie relative to it.
    pub path: PathBuf,
    pub document: Document,
    /// A buffer that only who cannot decompress needs is empty.
    pub buffers: Vec<Vec<u8>>,
    /// The bytes of the views that are compressed, or what is wrong with them.
    decompressed: BTreeMap<usize, Result<Vec<u8>, String>>,
    /// How many more numbers may be read.
    pub budget: Cell<u64>,
}

impl File {
    /// Reads the file at `path` and its buffers.
    pub fn read(path: &Path) -> Result<Self> {
        Self::parse(&read_at_most(path, MOST_BYTES)?, path)
    }

    /// Reads the `bytes` of a file that lies, or would lie, at `path`.
    pub fn parse(bytes: &[u8], path: &Path) -> Result<Self> {
        let (json, mut binary) = match bytes.starts_with(b"glTF") {
            true => split_glb(bytes).map_err(|problem| Error::format(path, "GLB", problem))?,
            false => (bytes, None),
        };
        // A byte-order mark is no JSON, but is met.
        let json = json.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(json);
        let document: Document = serde_json::from_slice(json)
            .map_err(|e| Error::format(path, "JSON", format!("is no glTF 2.0: {e}")))?;
        check_versions(&document).map_err(|(field, text)| Error::format(path, field, text))?;
        let views = document.buffer_views.iter();
        let compressed_views: BTreeSet<usize> = (views.filter(|view| view.meshopt().is_some()))
            .map(|view| view.buffer)
            .collect();
        let mut buffers = Vec::new();
        for (i, buffer) in document.buffers.iter().enumerate() {
            let compressed = compressed_views.contains(&i);
            if is_fallback(buffer, compressed) && !(i == 0 && binary.is_some()) {
                buffers.push(Vec::new());
                continue;
            }
            let bytes = match &buffer.uri {
                // Only the first buffer may be the GLB's own.
                None if i == 0 => match binary.take() {
                    Some(binary) => cut(binary.to_vec(), buffer),
                    None => Err("has no uri, and the file has no binary chunk".into()),
                },
                None => Err("has no uri".into()),
                Some(uri) => load(uri, path, MOST_BYTES).and_then(|bytes| cut(bytes, buffer)),
            };
            let field = || format!("buffers[{i}]");
            buffers.push(bytes.map_err(|problem| Error::format(path, field(), problem))?);
        }
        let size = json.len() + buffers.iter().map(Vec::len).sum::<usize>();
        let decompressed = decompress(&document, &buffers, size, MOST_BYTES);
        let budget = MOST_NUMBERS_PER_BYTE.saturating_mul(size as u64);
        Ok(Self {
            path: path.into(),
            document,
            buffers,
            decompressed,
            budget: Cell::new(budget.min(MOST_NUMBERS)),
        })
    }

    /// The bytes of a view, decompressed.
    pub fn view(&self, view: usize) -> Result<&[u8], String> {
        let field = || format!("bufferViews[{view}]");
        let found = self.document.buffer_views.get(view);
        let found = found.ok_or_else(|| format!("{} is not there", field()))?;
        if let Some(decompressed) = self.decompressed.get(&view) {
            let bytes = decompressed.as_ref();
            return bytes
                .map(Vec::as_slice)
                .map_err(|problem| format!("{}: {problem}", field()));
        }
        let buffer = self.buffers.get(found.buffer);
        let buffer = buffer.ok_or_else(|| format!("{}: its buffer is not there", field()))?;
        let start = found.byte_offset;
        let end = start.checked_add(found.byte_length);
        end.filter(|end| *end <= buffer.len() as u64)
            .map(|end| &buffer[start as usize..end as usize])
            .ok_or_else(|| {
                let length = buffer.len();
                format!("{} leaves its buffer of {length} bytes", field())
            })
    }

    /// Whether the file cannot be read without an extension.
    pub fn requires(&self, extension: &str) -> bool {
        let required = &self.document.extensions_required;
        required.iter().any(|required| required == extension)
    }

    /// An [`Error::Format`] of this file.
    pub fn broken(&self, field: impl Into<String>, problem: impl Into<String>) -> Error {
        Error::format(&self.path, field, problem)
    }
}

/// Whether only who cannot decompress needs a buffer: it says so, or what it would hold is compressed elsewhere.
fn is_fallback(buffer: &Buffer, holds_compressed_views: bool) -> bool {
    let marks = [
        &buffer.extensions.meshopt_ext,
        &buffer.extensions.meshopt_khr,
    ];
    let marked = |mark: &&Option<Fallback>| mark.as_ref().is_some_and(|mark| mark.fallback);
    marks.iter().any(marked) || buffer.uri.is_none() && holds_compressed_views
}

/// The JSON chunk and the binary one of a GLB file (§4.4); chunks of other types are skipped.
fn split_glb(bytes: &[u8]) -> Result<(&[u8], Option<&[u8]>), String> {
    let word = |at: usize| -> Option<u32> {
        let word = bytes.get(at..at.checked_add(4)?)?;
        Some(u32::from_le_bytes(word.try_into().ok()?))
    };
    match word(4) {
        Some(2) => {}
        Some(version) => return Err(format!("version {version}; only version 2 is read")),
        None => return Err("is cut short".into()),
    }
    let length = word(8).unwrap_or(0) as usize;
    if length > bytes.len() {
        let problem = format!("is cut short: {} bytes of {length}", bytes.len());
        return Err(problem);
    }
    let (mut json, mut binary) = (None, None);
    let mut at = 12;
    while at + 8 <= length {
        let size = word(at).unwrap_or(0) as usize;
        let chunk = at.checked_add(8 + size).filter(|&end| end <= length);
        let Some(end) = chunk else {
            return Err(format!("the chunk at byte {at} is longer than the file"));
        };
        match word(at + 4) {
            Some(0x4E4F_534A) if json.is_none() => json = Some(&bytes[at + 8..end]),
            Some(0x004E_4942) if binary.is_none() => binary = Some(&bytes[at + 8..end]),
            _ => {}
        }
        at = end;
    }
    let json = json.ok_or("has no JSON chunk")?;
    Ok((json, binary))
}

/// Refuses other versions and required extensions that are not read.
fn check_versions(document: &Document) -> Result<(), (&'static str, String)> {
    let asset = &document.asset;
    let version = asset.min_version.as_ref().unwrap_or(&asset.version);
    if !version.starts_with("2.") {
        let problem = format!("{version}; glTF 2.0 is read: export the file as that");
        return Err(("asset.version", problem));
    }
    let required = &document.extensions_required;
    match required.iter().find(|e| !is_readable(e)) {
        None => Ok(()),
        Some(extension) => {
            let cure = match extension.contains("compression") {
                true => "export the file without compression",
                false => "export the file without it",
            };
            let problem = format!("{extension} may change the geometry and is not read: {cure}");
            Err(("extensionsRequired", problem))
        }
    }
}

fn is_readable(extension: &str) -> bool {
    READABLE.iter().any(|known| match known.strip_suffix('*') {
        Some(start) => extension.starts_with(start),
        None => extension == *known,
    })
}

/// The bytes behind a URI, where they are at most so many.
pub(super) fn load(uri: &str, path: &Path, most: u64) -> Result<Vec<u8>, String> {
    if let Some(data) = uri.strip_prefix("data:") {
        let (kind, data) = data
            .split_once(',')
            .ok_or("is a data URI without a comma")?;
        return match kind.ends_with(";base64") {
            true => decode_base64(data).ok_or_else(|| "is spoiled base64".into()),
            false => Err("is a data URI in another coding than base64".into()),
        };
    }
    let name = decode_percent(uri).ok_or("has a uri with a spoiled % escape")?;
    let relative = Path::new(&name);
    let inside = |c: Component<'_>| matches!(c, Component::Normal(_) | Component::CurDir);
    if name.contains("://") || !relative.components().all(inside) {
        let cure = "files are read only from the folder of the one that names them and those in it: put it there";
        return Err(format!("{name}: {cure}"));
    }
    let at = path.parent().unwrap_or(Path::new("")).join(relative);
    read_at_most(&at, most).map_err(|e| e.to_string())
}

/// A buffer's stated length of the bytes that were found.
fn cut(mut bytes: Vec<u8>, buffer: &Buffer) -> Result<Vec<u8>, String> {
    let stated = buffer.byte_length;
    if (bytes.len() as u64) < stated {
        return Err(format!("{} bytes of {stated}", bytes.len()));
    }
    bytes.truncate(stated as usize);
    Ok(bytes)
}

fn read_at_most(path: &Path, most: u64) -> Result<Vec<u8>> {
    let io = |source| Error::io(path, source);
    let file = std::fs::File::open(path).map_err(io)?;
    let mut bytes = Vec::new();
    file.take(most + 1).read_to_end(&mut bytes).map_err(io)?;
    match bytes.len() as u64 > most {
        false => Ok(bytes),
        true => Err(Error::format(
            path,
            "length",
            format!("more than {most} bytes"),
        )),
    }
}

/// RFC 4648, padded or not.
fn decode_base64(text: &str) -> Option<Vec<u8>> {
    let text = text.trim_end_matches('=');
    let mut out = Vec::with_capacity(text.len() / 4 * 3 + 3);
    let (mut bits, mut count) = (0u32, 0);
    for c in text.bytes() {
        let value = match c {
            b'A'..=b'Z' => c - b'A',
            b'a'..=b'z' => c - b'a' + 26,
            b'0'..=b'9' => c - b'0' + 52,
            b'+' | b'-' => 62,
            b'/' | b'_' => 63,
            _ => return None,
        };
        bits = bits << 6 | u32::from(value);
        count += 6;
        if count >= 8 {
            count -= 8;
            out.push((bits >> count) as u8);
            bits &= (1 << count) - 1;
        }
    }
    Some(out)
}

/// RFC 3986's escapes.
fn decode_percent(text: &str) -> Option<String> {
    let mut out = Vec::with_capacity(text.len());
    let mut bytes = text.bytes();
    while let Some(b) = bytes.next() {
        let digit = |b: Option<u8>| char::from(b?).to_digit(16);
        out.push(match b {
            b'%' => (16 * digit(bytes.next())? + digit(bytes.next())?) as u8,
            _ => b,
        });
    }
    String::from_utf8(out).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_of_the_rfc() {
        for (plain, coded) in [
            ("", ""),
            ("f", "Zg=="),
            ("fo", "Zm8="),
            ("foo", "Zm9v"),
            ("foobar", "Zm9vYmFy"),
        ] {
            assert_eq!(decode_base64(coded).unwrap(), plain.as_bytes());
        }
        assert_eq!(decode_base64("Zm 9v"), None);
    }

    #[test]
    fn percent_escapes() {
        assert_eq!(decode_percent("a%20b%C3%A9").unwrap(), "a bé");
        assert_eq!(decode_percent("a%2"), None);
        assert_eq!(decode_percent("%ff"), None);
    }
}
