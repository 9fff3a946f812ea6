//! Damage to files, the same every time.

use supple::internal::math::Random;

/// Numbers that counts and indices turn into, as bytes.
const EDGES: [u64; 10] = [
    0,
    1,
    2,
    0x7f,
    0xff,
    0xffff,
    0x7fff_ffff,
    0xffff_ffff,
    i64::MAX as u64,
    u64::MAX,
];

/// Numbers that counts and indices turn into, as text.
const NUMBERS: [&str; 12] = [
    "0",
    "-1",
    "1",
    "99999999",
    "4294967295",
    "9223372036854775807",
    "18446744073709551616",
    "1e400",
    "nan",
    "-inf",
    "1e-320",
    "",
];

/// Bytes that mean something in one format or another.
const BYTES: &[u8] = b"\0\x01\x7f\x80\xff \n\t\"'#$.,-+0189(){}[]<>:;/\\eEuUNnR";

/// Truncations at evenly spread lengths, then random edits.
pub struct Mutations<'a> {
    seeds: &'a [Vec<u8>],
    random: Random,
    case: usize,
    cases: usize,
}

impl<'a> Mutations<'a> {
    pub fn new(seeds: &'a [Vec<u8>], cases: usize) -> Self {
        Self {
            seeds,
            random: Random::new(0x5ca1ab1e),
            case: 0,
            cases,
        }
    }

    fn pick<'b, T>(&mut self, of: &'b [T]) -> &'b T {
        &of[self.random.index(of.len())]
    }

    fn edit(&mut self, bytes: &mut Vec<u8>) {
        if bytes.is_empty() {
            return;
        }
        let at = self.random.index(bytes.len());
        match self.random.index(9) {
            0 => bytes[at] ^= 1 << self.random.index(8),
            1 => bytes[at] = *self.pick(BYTES),
            2 | 3 => self.put_number(bytes, at),
            4 | 5 => self.put_text_number(bytes, at),
            6 => {
                let end = self.end_of_chunk(bytes, at);
                bytes.drain(at..end);
            }
            7 => {
                let chunk = bytes[at..self.end_of_chunk(bytes, at)].to_vec();
                let to = self.random.index(bytes.len());
                bytes.splice(to..to, chunk);
            }
            _ => {
                let seeds = self.seeds;
                let other = self.pick(seeds);
                let from = self.random.index(other.len().max(1));
                let chunk = other
                    .get(from..self.end_of_chunk(other, from))
                    .unwrap_or_default();
                let end = (at + chunk.len()).min(bytes.len());
                bytes.splice(at..end, chunk.iter().copied());
            }
        }
    }

    fn end_of_chunk(&mut self, bytes: &[u8], at: usize) -> usize {
        let longest = if self.random.index(4) == 0 { 512 } else { 16 };
        (at + 1 + self.random.index(longest)).min(bytes.len())
    }

    /// A binary number of 1, 2, 4 or 8 bytes.
    fn put_number(&mut self, bytes: &mut [u8], at: usize) {
        let width = *self.pick(&[1, 2, 4, 8]);
        let mut number = *self.pick(&EDGES);
        if self.random.index(4) == 0 {
            number = self.random.bits() >> self.random.index(64);
        }
        let mut coded = number.to_le_bytes()[..width].to_vec();
        if self.random.index(4) == 0 {
            coded.reverse();
        }
        for (to, from) in bytes[at..].iter_mut().zip(coded) {
            *to = from;
        }
    }

    /// In place of the next number in the text.
    fn put_text_number(&mut self, bytes: &mut Vec<u8>, at: usize) {
        let Some(start) = bytes[at..].iter().position(u8::is_ascii_digit) else {
            return;
        };
        let start = at + start;
        let digits = bytes[start..]
            .iter()
            .take_while(|b| b.is_ascii_digit())
            .count();
        let number = *self.pick(&NUMBERS);
        bytes.splice(start..start + digits, number.bytes());
    }
}

impl Iterator for Mutations<'_> {
    type Item = Vec<u8>;

    fn next(&mut self) -> Option<Vec<u8>> {
        if self.case == self.cases {
            return None;
        }
        let case = self.case;
        self.case += 1;
        let mut bytes = self.seeds[case % self.seeds.len()].clone();
        let truncations = self.cases / 5;
        if case < truncations {
            bytes.truncate(case * bytes.len() / truncations);
        } else {
            for _ in 0..1 + self.random.index(4) {
                self.edit(&mut bytes);
            }
        }
        Some(bytes)
    }
}
