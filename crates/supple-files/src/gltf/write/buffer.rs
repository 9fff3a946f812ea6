//! The binary part of a GLB file and the accessors into it.

use serde_json::{Value, json};
use std::collections::BTreeMap;
use supple::{Error, Result};

const UNSIGNED_BYTE: u32 = 5121;
const UNSIGNED_SHORT: u32 = 5123;
const UNSIGNED_INT: u32 = 5125;
const FLOAT: u32 = 5126;

/// Bytes, buffer views and accessors as they grow.
#[derive(Default)]
pub(super) struct Buffer {
    pub bytes: Vec<u8>,
    pub views: Vec<Value>,
    pub accessors: Vec<Value>,
    /// Accessors of vectors that are all 0, by their number.
    zeros: BTreeMap<usize, usize>,
}

impl Buffer {
    /// A view of new bytes, at a multiple of four.
    pub fn view(&mut self, bytes: impl IntoIterator<Item = u8>) -> usize {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let offset = self.bytes.len();
        self.bytes.extend(bytes);
        let length = self.bytes.len() - offset;
        self.views
            .push(json!({"buffer": 0, "byteOffset": offset, "byteLength": length}));
        self.views.len() - 1
    }

    fn accessor(&mut self, accessor: Value) -> usize {
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }

    /// `N` floats an element; `kind` is glTF's name for that many.
    pub fn floats<const N: usize>(&mut self, kind: &str, values: &[[f32; N]]) -> usize {
        let view = self.view(values.iter().flatten().flat_map(|v| v.to_le_bytes()));
        let (low, high) = bounds(values.iter().copied());
        self.accessor(json!({
            "bufferView": view, "componentType": FLOAT, "count": values.len(), "type": kind,
            "min": low.to_vec(), "max": high.to_vec(),
        }))
    }

    /// Three floats an element that are 0 but for a few; those whose three are all within ±`threshold`
    /// are left out.
    pub fn sparse_vectors(&mut self, mut values: &[[f32; 3]], threshold: f32) -> usize {
        let mut kept: Vec<u32> = (0..values.len() as u32)
            .filter(|&v| values[v as usize].iter().any(|c| c.abs() > threshold))
            .collect();
        let count = values.len();
        // An index and a vector are 14 or 16 bytes, a vector alone 12.
        if kept.len() * 4 > count * 3 {
            return self.floats("VEC3", values);
        }
        if kept.is_empty() {
            if let Some(zeros) = self.zeros.get(&count) {
                return *zeros;
            }
            // Readers differ on accessors that name no bytes at all.
            kept.push(0);
            values = &[[0.0; 3]];
            self.zeros.insert(count, self.accessors.len());
        }
        let zero = (kept.len() < count).then_some([0.0; 3]);
        let (low, high) = bounds(kept.iter().map(|v| values[*v as usize]).chain(zero));
        let (indices, kind) = self.indices(&kept);
        let data = kept.iter().flat_map(|v| values[*v as usize]);
        let data = self.view(data.flat_map(f32::to_le_bytes));
        self.accessor(json!({
            "componentType": FLOAT, "count": count, "type": "VEC3",
            "min": low.to_vec(), "max": high.to_vec(),
            "sparse": {
                "count": kept.len(),
                "indices": {"bufferView": indices, "componentType": kind},
                "values": {"bufferView": data},
            },
        }))
    }

    /// Vertex indices of triangles.
    pub fn triangles(&mut self, triangles: &[[u32; 3]]) -> usize {
        let flat = triangles.as_flattened();
        let (view, kind) = self.indices(flat);
        self.accessor(json!({
            "bufferView": view, "componentType": kind, "count": flat.len(), "type": "SCALAR",
        }))
    }

    /// Four bone indices an element.
    pub fn bone_indices(&mut self, values: &[[u16; 4]]) -> usize {
        let flat = values.as_flattened();
        let (view, kind) = if flat.iter().all(|v| *v < 256) {
            (self.view(flat.iter().map(|v| *v as u8)), UNSIGNED_BYTE)
        } else {
            let bytes = flat.iter().flat_map(|v| v.to_le_bytes());
            (self.view(bytes), UNSIGNED_SHORT)
        };
        self.accessor(json!({
            "bufferView": view, "componentType": kind, "count": values.len(), "type": "VEC4",
        }))
    }

    /// A view of indices, and the narrowest type that holds them (65535 itself is reserved).
    fn indices(&mut self, values: &[u32]) -> (usize, u32) {
        if values.iter().all(|v| *v < u32::from(u16::MAX)) {
            let bytes = values.iter().flat_map(|v| (*v as u16).to_le_bytes());
            (self.view(bytes), UNSIGNED_SHORT)
        } else {
            let bytes = values.iter().flat_map(|v| v.to_le_bytes());
            (self.view(bytes), UNSIGNED_INT)
        }
    }
}

/// Smallest and largest of each component.
fn bounds<const N: usize>(values: impl Iterator<Item = [f32; N]>) -> ([f32; N], [f32; N]) {
    values.fold(
        ([f32::INFINITY; N], [f32::NEG_INFINITY; N]),
        |(low, high), v| {
            (
                std::array::from_fn(|k| low[k].min(v[k])),
                std::array::from_fn(|k| high[k].max(v[k])),
            )
        },
    )
}

/// A GLB file of a document and its buffer (glTF 2.0, §4.4).
///
/// # Errors
/// [`Error::Invalid`] where that is longer than a GLB file can say.
pub(super) fn container(document: &Value, buffer: &[u8]) -> Result<Vec<u8>> {
    let mut json = document.to_string().into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let padded = buffer.len().next_multiple_of(4);
    let total = 12 + 8 + json.len() + 8 + padded;
    if u32::try_from(total).is_err() {
        let problem = format!(
            "{total} bytes are too many for a GLB file: record fewer states, or take fewer morphs"
        );
        return Err(Error::invalid("recording", problem));
    }
    let mut out = Vec::with_capacity(total);
    out.extend(b"glTF");
    out.extend(2u32.to_le_bytes());
    out.extend((total as u32).to_le_bytes());
    out.extend((json.len() as u32).to_le_bytes());
    out.extend(b"JSON");
    out.extend(&json);
    out.extend((padded as u32).to_le_bytes());
    out.extend(b"BIN\0");
    out.extend(buffer);
    out.resize(total, 0);
    Ok(out)
}
