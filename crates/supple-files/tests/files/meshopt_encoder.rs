//! Meshopt's streams, written from the specification (KHR_meshopt_compression, appendix A): small, not good.

const GROUP: usize = 16;

/// How the four bytes of a channel are taken in version 1.
#[derive(Clone, Copy)]
pub enum Channel {
    Bytes,
    Shorts,
    /// Turned left by so many bits.
    Xor(u32),
}

/// Elements of `stride` bytes in version 0, or in version 1 with a kind of channel for each four bytes.
pub fn attributes(bytes: &[u8], stride: usize, channels: Option<&[Channel]>) -> Vec<u8> {
    let most = ((8192 / stride) & !15).min(256);
    let mut out = vec![if channels.is_some() { 0xa1 } else { 0xa0 }];
    let mut last = bytes[..stride].to_vec();
    let baseline = last.clone();
    for block in bytes.chunks(most * stride) {
        let mut columns = vec![Vec::new(); stride];
        for element in block.chunks_exact(stride) {
            for c in 0..stride / 4 {
                let channel = channels.map_or(Channel::Bytes, |all| all[c]);
                let four = |from: &[u8]| -> [u8; 4] { from[4 * c..4 * c + 4].try_into().unwrap() };
                let delta = difference(channel, four(&last), four(element));
                delta
                    .iter()
                    .enumerate()
                    .for_each(|(k, d)| columns[4 * c + k].push(*d));
            }
            last.copy_from_slice(element);
        }
        let mut controls = vec![0u8; stride / 4];
        let mut data = Vec::new();
        for (k, column) in columns.iter().enumerate() {
            let Some(_) = channels else {
                data.extend(packed(column, [0, 2, 4, 8]));
                continue;
            };
            // All ways in turn, so that each is met.
            let (control, coded) = match (column.iter().all(|d| *d == 0), k % 3) {
                (true, _) => (2, Vec::new()),
                (false, 0) => (3, column.clone()),
                (false, 1) => (0, packed(column, [0, 1, 2, 4])),
                (false, _) => (1, packed(column, [1, 2, 4, 8])),
            };
            controls[k / 4] |= control << (2 * (k % 4));
            data.extend(coded);
        }
        if channels.is_some() {
            out.extend(controls);
        }
        out.extend(data);
    }
    let mut tail = baseline;
    tail.extend(channels.into_iter().flatten().map(|c| match c {
        Channel::Bytes => 0,
        Channel::Shorts => 1,
        Channel::Xor(turn) => 2 | (*turn as u8) << 4,
    }));
    let least: usize = if channels.is_some() { 24 } else { 32 };
    out.extend(vec![0; least.saturating_sub(tail.len())]);
    out.extend(tail);
    out
}

fn difference(channel: Channel, from: [u8; 4], to: [u8; 4]) -> [u8; 4] {
    let shorts = |v: [u8; 4]| {
        [
            u16::from_le_bytes([v[0], v[1]]),
            u16::from_le_bytes([v[2], v[3]]),
        ]
    };
    match channel {
        Channel::Bytes => [0, 1, 2, 3].map(|k| {
            let v = to[k].wrapping_sub(from[k]);
            if v & 0x80 != 0 { !(v << 1) } else { v << 1 }
        }),
        Channel::Shorts => {
            let (from, to) = (shorts(from), shorts(to));
            let [[a, b], [c, d]] = [0, 1].map(|k| {
                let v = to[k].wrapping_sub(from[k]);
                (if v & 0x8000 != 0 { !(v << 1) } else { v << 1 }).to_le_bytes()
            });
            [a, b, c, d]
        }
        Channel::Xor(turn) => {
            let v = u32::from_le_bytes(from) ^ u32::from_le_bytes(to);
            v.rotate_left(turn).to_le_bytes()
        }
    }
}

/// Groups of 16, each with the smallest of four numbers of bits that takes it.
fn packed(column: &[u8], bits: [usize; 4]) -> Vec<u8> {
    let mut column = column.to_vec();
    column.resize(column.len().next_multiple_of(GROUP), 0);
    let groups: Vec<_> = column.chunks_exact(GROUP).collect();
    let mut header = vec![0u8; groups.len().div_ceil(4)];
    let mut data = Vec::new();
    for (g, group) in groups.iter().enumerate() {
        let ways = bits
            .iter()
            .enumerate()
            .filter_map(|(code, b)| Some((code, grouped(group, *b)?)));
        let (code, coded) = ways.min_by_key(|(_, coded)| coded.len()).unwrap();
        header[g / 4] |= (code as u8) << (2 * (g % 4));
        data.extend(coded);
    }
    header.extend(data);
    header
}

fn grouped(group: &[u8], bits: usize) -> Option<Vec<u8>> {
    match bits {
        0 => group.iter().all(|v| *v == 0).then(Vec::new),
        8 => Some(group.to_vec()),
        bits => {
            let sentinel = (1u8 << bits) - 1;
            let mut out = vec![0; GROUP * bits / 8];
            for (i, v) in group.iter().enumerate() {
                let place = i * bits % 8;
                let shift = if bits == 1 { place } else { 8 - bits - place };
                out[i * bits / 8] |= (*v).min(sentinel) << shift;
            }
            out.extend(group.iter().filter(|v| **v >= sentinel));
            Some(out)
        }
    }
}

fn varint(mut v: u32, out: &mut Vec<u8>) {
    while v >= 0x80 {
        out.push(v as u8 | 0x80);
        v >>= 7;
    }
    out.push(v as u8);
}

fn zigzag(v: u32) -> u32 {
    if v & 0x8000_0000 != 0 {
        !(v << 1)
    } else {
        v << 1
    }
}

/// Indices of any kind, every other against the second of the two baselines.
pub fn indices(indices: &[u32]) -> Vec<u8> {
    let mut out = vec![0xd1];
    let mut last = [0u32; 2];
    for (i, index) in indices.iter().enumerate() {
        let line = i % 2;
        varint(
            zigzag(index.wrapping_sub(last[line])) << 1 | line as u32,
            &mut out,
        );
        last[line] = *index;
    }
    out.extend([0; 4]);
    out
}

/// Triangles: by an edge and a corner met before where there are some.
pub fn triangles(indices: &[u32]) -> Vec<u8> {
    const TABLE: [u8; 16] = [0x00, 0x01, 0x10, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0];
    let (mut codes, mut data) = (Vec::new(), Vec::new());
    // The last ones first.
    let (mut edges, mut corners): (Vec<[u32; 2]>, Vec<u32>) = (Vec::new(), Vec::new());
    let (mut next, mut last) = (0u32, 0u32);
    for t in indices.chunks_exact(3) {
        let turns = [[t[0], t[1], t[2]], [t[1], t[2], t[0]], [t[2], t[0], t[1]]];
        let known = |t: &[u32; 3]| edges.iter().take(15).position(|e| *e == [t[0], t[1]]);
        let found = turns.iter().find_map(|t| Some((*t, known(t)?)));
        if let Some(([a, b, c], edge)) = found {
            let corner = corners.iter().take(13).skip(1).position(|v| *v == c);
            let low = match corner {
                _ if c == next => {
                    next += 1;
                    0
                }
                Some(corner) => corner as u8 + 1,
                None if c == last.wrapping_sub(1) => 13,
                None if c == last.wrapping_add(1) => 14,
                None => {
                    varint(zigzag(c.wrapping_sub(last)), &mut data);
                    15
                }
            };
            if low >= 13 {
                last = c;
            }
            codes.push((edge as u8) << 4 | low);
            if low == 0 || low >= 13 {
                corners.insert(0, c);
            }
            edges.splice(0..0, [[a, c], [c, b]]);
            continue;
        }
        let [a, b, c] = turns[0];
        if [a, b, c] == [next, next + 1, next + 2] {
            codes.push(0xf0);
            next += 3;
            corners.splice(0..0, [c, b, a]);
        } else {
            codes.push(if a == next { 0xfe } else { 0xff });
            let seen = |v: u32| {
                corners
                    .iter()
                    .take(14)
                    .position(|c| *c == v)
                    .map(|p| p as u8 + 1)
            };
            let (z, w) = (seen(b).unwrap_or(15), seen(c).unwrap_or(15));
            data.push(z << 4 | w);
            let mut number = |v: u32| {
                varint(zigzag(v.wrapping_sub(last)), &mut data);
                last = v;
            };
            match a == next {
                true => next += 1,
                false => number(a),
            }
            [(z, b), (w, c)]
                .iter()
                .filter(|p| p.0 == 15)
                .for_each(|p| number(p.1));
            corners.insert(0, a);
            [(z, b), (w, c)]
                .iter()
                .filter(|p| p.0 == 15)
                .for_each(|p| corners.insert(0, p.1));
        }
        edges.splice(0..0, [[a, c], [c, b], [b, a]]);
    }
    let mut out = vec![0xe1];
    out.extend(codes);
    out.extend(data);
    out.extend(TABLE);
    out
}
