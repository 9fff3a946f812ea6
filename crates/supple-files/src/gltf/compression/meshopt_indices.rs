//! Meshopt's mode INDICES (KHR_meshopt_compression, appendix A, mode 2).

use super::{Bytes, Problem, unzigzag};

/// Bytes of nothing at the end.
const TAIL: usize = 4;

/// `count` indices, each by its difference from one of two that were met before.
pub(super) fn decode(data: &[u8], count: usize) -> Result<Vec<u32>, Problem> {
    let mut data = Bytes(data);
    if data.byte() != Ok(0xd1) {
        return Err("they do not begin as indices do".into());
    }
    let end = data.0.len().checked_sub(TAIL).ok_or("they end too early")?;
    let mut data = Bytes(&data.0[..end]);
    // A byte each at least.
    if count > end {
        return Err("they end too early".into());
    }
    let mut last = [0u32; 2];
    let mut out = Vec::with_capacity(count);
    for _ in 0..count {
        let v = data.varint()?;
        let last = &mut last[(v & 1) as usize];
        *last = last.wrapping_add(unzigzag(v >> 1));
        out.push(*last);
    }
    data.end()?;
    Ok(out)
}
