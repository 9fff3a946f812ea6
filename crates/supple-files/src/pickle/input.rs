//! A pickle's bytes, taken one piece after another.

use super::Value;
use super::text::from_latin1;

/// The bytes that are left.
pub(super) struct Input<'a> {
    pub bytes: &'a [u8],
    pub at: usize,
}

impl<'a> Input<'a> {
    pub fn take(&mut self, count: usize) -> Result<&'a [u8], String> {
        let end = self.at.checked_add(count);
        let taken = end.and_then(|end| self.bytes.get(self.at..end));
        let taken = taken.ok_or_else(|| {
            format!(
                "{count} bytes are announced and {} are left",
                self.bytes.len() - self.at
            )
        })?;
        self.at += count;
        Ok(taken)
    }

    pub fn byte(&mut self) -> Result<u8, String> {
        self.take(1).map(|b| b[0])
    }

    /// An unsigned integer of so many bytes, lowest first.
    pub fn count(&mut self, width: usize) -> Result<u64, String> {
        let bytes = self.take(width)?;
        Ok(bytes.iter().rev().fold(0, |n, b| n << 8 | u64::from(*b)))
    }

    /// Bytes with their number, of so many bytes, before them.
    pub fn counted(&mut self, width: usize) -> Result<&'a [u8], String> {
        let count = self.count(width)?;
        self.take(usize::try_from(count).unwrap_or(usize::MAX))
    }

    /// Up to the end of the line.
    pub fn line(&mut self) -> Result<&'a [u8], String> {
        let rest = &self.bytes[self.at..];
        let length = rest.iter().position(|b| *b == b'\n');
        let length = length.ok_or("a line has no end")?;
        self.at += length + 1;
        Ok(rest[..length]
            .strip_suffix(b"\r")
            .unwrap_or(&rest[..length]))
    }
}

/// An integer of a line.
pub(super) fn decimal(line: &[u8]) -> Result<Value, String> {
    let text = from_latin1(line);
    let int = text.trim().parse().map(Value::Int);
    int.map_err(|_| "an integer of 64 bits is expected".into())
}

/// An index of the memo, of a line.
pub(super) fn memo_index(line: &[u8]) -> Result<u32, String> {
    let text = from_latin1(line);
    let index = text.trim().parse();
    index.map_err(|_| "an index of the memo is expected".into())
}
