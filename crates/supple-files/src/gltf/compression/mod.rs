//! Data that extensions of glTF compress.

#[cfg(feature = "draco")]
mod draco;
#[cfg(not(feature = "draco"))]
#[path = "no_draco.rs"]
mod draco;
mod meshopt_attributes;
mod meshopt_filters;
mod meshopt_indices;
mod meshopt_triangles;

pub(super) use draco::DracoMesh;

use super::document::{BufferView, Document, MeshoptView};
use std::collections::BTreeMap;

/// What is wrong with compressed data.
type Problem = String;

/// Bytes that the views of a file may become, for each byte of it. Attributes that are all the same become a thousand, those
/// of characters five.
const MOST_BYTES_PER_BYTE: u64 = 256;

/// The decompressed bytes of each compressed view, or what is wrong with it: a view that nobody reads does no harm.
pub(super) fn decompress(
    document: &Document,
    buffers: &[Vec<u8>],
    size: usize,
    most: u64,
) -> BTreeMap<usize, Result<Vec<u8>, Problem>> {
    let mut budget = MOST_BYTES_PER_BYTE.saturating_mul(size as u64).min(most);
    let views = document.buffer_views.iter().enumerate();
    let compressed = views.filter_map(|(v, view)| Some((v, view, view.meshopt()?)));
    let decompressed =
        compressed.map(|(v, view, how)| (v, of_view(view, how, buffers, &mut budget)));
    decompressed.collect()
}

/// EXT_meshopt_compression and KHR_meshopt_compression, whose views differ only in what the streams may hold.
fn of_view(
    view: &BufferView,
    how: &MeshoptView,
    buffers: &[Vec<u8>],
    budget: &mut u64,
) -> Result<Vec<u8>, Problem> {
    let from = buffers.get(how.buffer).and_then(|buffer| {
        let end = how.byte_offset.checked_add(how.byte_length)?;
        let range = usize::try_from(how.byte_offset).ok()?..usize::try_from(end).ok()?;
        buffer.get(range)
    });
    let from = from.ok_or("compressed data that leaves its buffer")?;
    let (count, stride) = (how.count, how.byte_stride);
    let length = count.checked_mul(stride).filter(|l| *l <= view.byte_length);
    let length = length.ok_or("compressed data of more bytes than the view has")?;
    let rest = budget.checked_sub(length);
    *budget =
        rest.ok_or("compressed data of more bytes, all together, than a file of this size may")?;
    // Below the budget, so below what fits.
    let (count, stride) = (count as usize, stride as usize);
    let wrong = |problem: Problem| format!("meshopt data that are broken: {problem}");
    let filter = how.filter.as_deref().unwrap_or("NONE");
    match (how.mode.as_str(), filter) {
        ("ATTRIBUTES", filter) => {
            let mut bytes = meshopt_attributes::decode(from, count, stride).map_err(wrong)?;
            meshopt_filters::apply(filter, &mut bytes, stride).map_err(wrong)?;
            Ok(bytes)
        }
        ("TRIANGLES", "NONE") => {
            let indices = meshopt_triangles::decode(from, count).map_err(wrong)?;
            narrow(&indices, stride)
        }
        ("INDICES", "NONE") => {
            let indices = meshopt_indices::decode(from, count).map_err(wrong)?;
            narrow(&indices, stride)
        }
        (mode, filter) => Err(format!(
            "meshopt mode {mode} with filter {filter} is unknown"
        )),
    }
}

/// Indices as their bytes, two or four each.
fn narrow(indices: &[u32], stride: usize) -> Result<Vec<u8>, Problem> {
    match stride {
        2 => Ok(indices
            .iter()
            .flat_map(|i| (*i as u16).to_le_bytes())
            .collect()),
        4 => Ok(indices.iter().flat_map(|i| i.to_le_bytes()).collect()),
        _ => Err(format!("indices of {stride} bytes")),
    }
}

/// Bytes that are taken from the front.
struct Bytes<'a>(&'a [u8]);

impl<'a> Bytes<'a> {
    fn take(&mut self, count: usize) -> Result<&'a [u8], Problem> {
        let (taken, rest) = self.0.split_at_checked(count).ok_or("they end too early")?;
        self.0 = rest;
        Ok(taken)
    }

    fn byte(&mut self) -> Result<u8, Problem> {
        Ok(self.take(1)?[0])
    }

    /// Seven bits a byte, the lowest first; the eighth says that more follow.
    fn varint(&mut self) -> Result<u32, Problem> {
        let mut value = 0;
        for shift in [0, 7, 14, 21, 28] {
            let byte = self.byte()?;
            value |= u32::from(byte & 0x7f) << shift;
            if byte < 0x80 {
                return Ok(value);
            }
        }
        Err("a number of more than five bytes".into())
    }

    /// That nothing is left.
    fn end(&self) -> Result<(), Problem> {
        match self.0.len() {
            0 => Ok(()),
            rest => Err(format!("{rest} bytes too many")),
        }
    }
}

/// The signed number behind an unsigned one whose lowest bit is the sign.
fn unzigzag(v: u32) -> u32 {
    if v & 1 != 0 { !(v >> 1) } else { v >> 1 }
}
