//! Meshopt's mode TRIANGLES (KHR_meshopt_compression, appendix A, mode 1).
//!
//! A byte for each triangle says where its corners come from: an edge or a corner of those met last, the next vertex that
//! was not met before, or a number that follows.

use super::{Bytes, Problem, unzigzag};

/// Entries of the table at the end.
const TABLE: usize = 16;

/// `count` indices, three a triangle.
pub(super) fn decode(data: &[u8], count: usize) -> Result<Vec<u32>, Problem> {
    if !count.is_multiple_of(3) {
        return Err(format!("{count} indices of triangles"));
    }
    let mut data = Bytes(data);
    if data.byte() != Ok(0xe1) {
        return Err("they do not begin as triangles do".into());
    }
    let codes = data.take(count / 3)?;
    let end = data
        .0
        .len()
        .checked_sub(TABLE)
        .ok_or("they end too early")?;
    let (numbers, table) = data.0.split_at(end);
    let mut decoder = Decoder {
        numbers: Bytes(numbers),
        next: 0,
        last: 0,
        edges: Recent::default(),
        corners: Recent::default(),
    };
    let mut out = Vec::with_capacity(count);
    for &code in codes {
        out.extend(decoder.triangle(code, table)?);
    }
    decoder.numbers.end()?;
    Ok(out)
}

struct Decoder<'a> {
    numbers: Bytes<'a>,
    /// The vertex after all that were met.
    next: u32,
    /// The last vertex that was given as a number.
    last: u32,
    edges: Recent<[u32; 2]>,
    corners: Recent<u32>,
}

impl Decoder<'_> {
    fn triangle(&mut self, code: u8, table: &[u8]) -> Result<[u32; 3], Problem> {
        let (high, low) = (code >> 4, code & 15);
        if high < 15 {
            let [a, b] = self.edges.get(high)?;
            let (c, is_new) = match low {
                0 => (self.take_next(), true),
                1..=12 => (self.corners.get(low)?, false),
                15 => (self.number()?, true),
                13 => (self.set_last(self.last.wrapping_sub(1)), true),
                _ => (self.set_last(self.last.wrapping_add(1)), true),
            };
            if is_new {
                self.corners.push(c);
            }
            self.edges.push([c, b]);
            self.edges.push([a, c]);
            return Ok([a, b, c]);
        }
        let (from_table, first_is_next) = (low < 14, low < 15);
        let pair = match from_table {
            true => table[usize::from(low)],
            false => self.numbers.byte()?,
        };
        if !from_table && pair == 0 {
            self.next = 0;
        }
        let a = match first_is_next {
            true => self.take_next(),
            false => self.number()?,
        };
        let (b, b_is_new) = self.corner(pair >> 4, from_table)?;
        let (c, c_is_new) = self.corner(pair & 15, from_table)?;
        self.corners.push(a);
        (b_is_new
            .then_some(b)
            .into_iter()
            .chain(c_is_new.then_some(c)))
        .for_each(|corner| self.corners.push(corner));
        self.edges.push([b, a]);
        self.edges.push([c, b]);
        self.edges.push([a, c]);
        Ok([a, b, c])
    }

    /// A corner by half a byte, and whether it is to be remembered.
    fn corner(&mut self, code: u8, from_table: bool) -> Result<(u32, bool), Problem> {
        match code {
            0 => Ok((self.take_next(), true)),
            15 if from_table => Err("a table that asks for a number".into()),
            15 => Ok((self.number()?, true)),
            code => Ok((self.corners.get(code - 1)?, false)),
        }
    }

    fn take_next(&mut self) -> u32 {
        let next = self.next;
        self.next = next.wrapping_add(1);
        next
    }

    fn set_last(&mut self, vertex: u32) -> u32 {
        self.last = vertex;
        vertex
    }

    fn number(&mut self) -> Result<u32, Problem> {
        let delta = unzigzag(self.numbers.varint()?);
        Ok(self.set_last(self.last.wrapping_add(delta)))
    }
}

/// The last 16 that were pushed.
#[derive(Default)]
struct Recent<T> {
    ring: [Option<T>; 16],
    pushed: usize,
}

impl<T: Copy> Recent<T> {
    fn push(&mut self, value: T) {
        self.ring[self.pushed % 16] = Some(value);
        self.pushed += 1;
    }

    /// The one that was pushed `back` before the last.
    fn get(&self, back: u8) -> Result<T, Problem> {
        let at = self.pushed.checked_sub(1 + usize::from(back));
        let found = at.and_then(|at| self.ring[at % 16]);
        found.ok_or_else(|| "an edge or corner from before the first".into())
    }
}
