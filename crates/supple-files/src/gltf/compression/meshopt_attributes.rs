//! Meshopt's mode ATTRIBUTES, versions 0 and 1 (KHR_meshopt_compression, appendix A, mode 0).
//!
//! Elements come in blocks. In a block each byte of the elements is a column of its own: what it differs by from element to
//! element, in groups of 16 of so many bits each. The first element differs from one in the tail.

use super::{Bytes, Problem};

/// Elements of a group.
const GROUP: usize = 16;
/// Most elements of a block, and most bytes.
const BLOCK: usize = 256;
const BLOCK_BYTES: usize = 8192;

/// `count` elements of `stride` bytes each.
pub(super) fn decode(data: &[u8], count: usize, stride: usize) -> Result<Vec<u8>, Problem> {
    if !(4..=256).contains(&stride) || !stride.is_multiple_of(4) {
        return Err(format!("elements of {stride} bytes"));
    }
    let (version, least_tail) = match data.first() {
        Some(0xa0) => (0, 32),
        Some(0xa1) => (1, 24),
        _ => return Err("they do not begin as attributes do".into()),
    };
    let tail = stride + if version == 1 { stride / 4 } else { 0 };
    let body = (data.len().checked_sub(tail.max(least_tail))).and_then(|end| data.get(1..end));
    let mut body = Bytes(body.ok_or("they end too early")?);
    let (last, channels) = data[data.len() - tail..].split_at(stride);
    let channels: Vec<Channel> = match version {
        0 => vec![Channel::Bytes; stride / 4],
        _ => channels
            .iter()
            .map(|c| Channel::new(*c))
            .collect::<Result<_, _>>()?,
    };
    let mut last = last.to_vec();
    let most = ((BLOCK_BYTES / stride) & !(GROUP - 1)).min(BLOCK);
    let mut out = Vec::new();
    let mut columns = vec![[0; BLOCK]; stride];
    let mut left = count;
    while left > 0 {
        let elements = left.min(most);
        columns_of_block(&mut body, version, elements, &mut columns)?;
        for e in 0..elements {
            for (c, channel) in channels.iter().enumerate() {
                let at = 4 * c..4 * c + 4;
                let delta = std::array::from_fn(|k| columns[4 * c + k][e]);
                // The range is of four.
                let before = std::array::from_fn(|k| last[4 * c + k]);
                last[at].copy_from_slice(&channel.after(before, delta));
            }
            out.extend_from_slice(&last);
        }
        left -= elements;
    }
    body.end()?;
    Ok(out)
}

/// What four bytes of an element are, and how they differ from those of the one before.
#[derive(Clone, Copy)]
enum Channel {
    Bytes,
    Shorts,
    /// One number of 32 bits, whose difference is turned left by so many bits.
    Xor(u32),
}

impl Channel {
    fn new(code: u8) -> Result<Self, Problem> {
        match (code & 15, code >> 4) {
            (0, 0) => Ok(Self::Bytes),
            (1, 0) => Ok(Self::Shorts),
            (2, turn) => Ok(Self::Xor(u32::from(turn))),
            _ => Err(format!("channel mode {code:#04x}")),
        }
    }

    fn after(self, before: [u8; 4], delta: [u8; 4]) -> [u8; 4] {
        match self {
            Self::Bytes => std::array::from_fn(|k| {
                let d = delta[k];
                let signed = if d & 1 != 0 { !(d >> 1) } else { d >> 1 };
                before[k].wrapping_add(signed)
            }),
            Self::Shorts => {
                let sum = |k: usize| {
                    let d = u16::from_le_bytes([delta[k], delta[k + 1]]);
                    let signed = if d & 1 != 0 { !(d >> 1) } else { d >> 1 };
                    let before = u16::from_le_bytes([before[k], before[k + 1]]);
                    before.wrapping_add(signed).to_le_bytes()
                };
                let ([a, b], [c, d]) = (sum(0), sum(2));
                [a, b, c, d]
            }
            Self::Xor(turn) => {
                let delta = u32::from_le_bytes(delta).rotate_right(turn);
                (u32::from_le_bytes(before) ^ delta).to_le_bytes()
            }
        }
    }
}

/// The differences of a block, each byte's in a column.
fn columns_of_block(
    body: &mut Bytes<'_>,
    version: u32,
    elements: usize,
    columns: &mut [[u8; BLOCK]],
) -> Result<(), Problem> {
    let controls = match version {
        0 => &[],
        _ => body.take(columns.len() / 4)?,
    };
    for (k, column) in columns.iter_mut().enumerate() {
        let control = controls.get(k / 4).map(|c| c >> (2 * (k % 4)) & 3);
        let bits = match control {
            None => [0, 2, 4, 8],
            Some(0) => [0, 1, 2, 4],
            Some(1) => [1, 2, 4, 8],
            Some(2) => {
                column.fill(0);
                continue;
            }
            Some(_) => {
                column[..elements].copy_from_slice(body.take(elements)?);
                continue;
            }
        };
        let groups = elements.div_ceil(GROUP);
        let header = body.take(groups.div_ceil(4))?;
        for (g, group) in column.chunks_exact_mut(GROUP).take(groups).enumerate() {
            let code = header[g / 4] >> (2 * (g % 4)) & 3;
            decode_group(body, bits[usize::from(code)], group)?;
        }
    }
    Ok(())
}

/// 16 numbers of `bits` bits; those whose bits are all 1 follow as whole bytes.
fn decode_group(body: &mut Bytes<'_>, bits: usize, group: &mut [u8]) -> Result<(), Problem> {
    match bits {
        0 => group.fill(0),
        8 => group.copy_from_slice(body.take(GROUP)?),
        bits => {
            let packed = body.take(GROUP * bits / 8)?;
            let sentinel = (1u8 << bits) - 1;
            for (i, value) in group.iter_mut().enumerate() {
                let (byte, place) = (packed[i * bits / 8], i * bits % 8);
                // Single bits begin with the lowest, others with the highest.
                let shift = if bits == 1 { place } else { 8 - bits - place };
                *value = match byte >> shift & sentinel {
                    v if v == sentinel => body.byte()?,
                    v => v,
                };
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The example of the specification: 16 differences of 4 bits, two of which follow as bytes.
    #[test]
    fn differences_of_the_specification() {
        let coded = [0x17, 0x5f, 0xf0, 0xbc, 0x77, 0xa9, 0x21, 0x00, 0x34, 0xb5];
        let mut group = [0; GROUP];
        let mut body = Bytes(&coded);
        decode_group(&mut body, 4, &mut group).unwrap();
        body.end().unwrap();
        let decoded = group.map(|d| Channel::Bytes.after([0; 4], [d, 0, 0, 0])[0] as i8);
        let expected = [-1, -4, -3, 26, -91, 0, -6, 6, -4, -4, 5, -5, 1, -1, 0, 0];
        assert_eq!(decoded, expected);
    }
}
