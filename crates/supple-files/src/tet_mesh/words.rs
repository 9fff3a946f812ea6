//! Words and binary numbers of a file, one after another.

use std::path::Path;
use std::str::FromStr;
use supple::{Error, Result};

/// What is left of a file.
pub(super) struct Words<'a> {
    path: &'a Path,
    bytes: &'a [u8],
    at: usize,
    /// Whether errors tell the byte, and not the line.
    pub binary: bool,
    /// Whether binary numbers begin with their highest byte.
    pub big_endian: bool,
}

impl<'a> Words<'a> {
    pub fn new(bytes: &'a [u8], path: &'a Path) -> Self {
        Self {
            path,
            bytes,
            at: 0,
            binary: false,
            big_endian: false,
        }
    }

    /// An error at this place.
    pub fn fault(&self, problem: impl Into<String>) -> Error {
        let place = if self.binary {
            format!("byte {}", self.at)
        } else {
            let before = &self.bytes[..self.at.min(self.bytes.len())];
            format!(
                "line {}",
                1 + before.iter().filter(|b| **b == b'\n').count()
            )
        };
        Error::format(self.path, place, problem)
    }

    /// Goes to the next word, past white space and comments (from `#` to the end of the line).
    fn skip_space(&mut self) {
        while let Some(byte) = self.bytes.get(self.at) {
            if *byte == b'#' {
                let rest = &self.bytes[self.at..];
                self.at += rest.iter().position(|b| *b == b'\n').unwrap_or(rest.len());
            } else if byte.is_ascii_whitespace() {
                self.at += 1;
            } else {
                return;
            }
        }
    }

    /// The next word, if there is one; it is not taken.
    pub fn peek(&mut self) -> Option<&'a [u8]> {
        self.skip_space();
        let rest = &self.bytes[self.at..];
        let length = rest
            .iter()
            .position(u8::is_ascii_whitespace)
            .unwrap_or(rest.len());
        (length > 0).then(|| &rest[..length])
    }

    /// The next word; `what` should stand there.
    pub fn word(&mut self, what: &str) -> Result<&'a [u8]> {
        let word = self.peek().ok_or_else(|| self.ended(what))?;
        self.at += word.len();
        Ok(word)
    }

    fn ended(&self, what: &str) -> Error {
        self.fault(format!(
            "the file ends where {what} should stand: complete it"
        ))
    }

    /// The next word as a number.
    pub fn value<T: FromStr>(&mut self, what: &str) -> Result<T> {
        let word = self.peek().ok_or_else(|| self.ended(what))?;
        let value = std::str::from_utf8(word).ok().and_then(|w| w.parse().ok());
        let value = value.ok_or_else(|| {
            let found: String = String::from_utf8_lossy(word).chars().take(20).collect();
            self.fault(format!("{what} should stand here, not `{found}`"))
        })?;
        self.at += word.len();
        Ok(value)
    }

    /// A text in quotation marks.
    pub fn quoted(&mut self) -> Result<String> {
        self.skip_space();
        let rest = &self.bytes[self.at..];
        let inside = rest.strip_prefix(b"\"");
        let length = inside.and_then(|i| i.iter().position(|b| *b == b'"'));
        match (inside, length) {
            (Some(inside), Some(length)) => {
                self.at += length + 2;
                Ok(String::from_utf8_lossy(&inside[..length]).into_owned())
            }
            _ => Err(self.fault("a name in quotation marks should stand here")),
        }
    }

    /// Goes behind the end of this line, where binary data begin.
    pub fn end_line(&mut self) {
        let rest = &self.bytes[self.at..];
        self.at += rest
            .iter()
            .position(|b| *b == b'\n')
            .map_or(rest.len(), |p| p + 1);
    }

    /// Goes behind the next `text`.
    pub fn skip_past(&mut self, text: &[u8]) -> Result<()> {
        let rest = &self.bytes[self.at..];
        let found = rest.windows(text.len().max(1)).position(|w| w == text);
        let Some(found) = found else {
            let text = String::from_utf8_lossy(text).into_owned();
            return Err(self.fault(format!("{text} is missing: complete the file")));
        };
        self.at += found + text.len();
        Ok(())
    }

    /// Goes to byte `at`, no farther back than this one.
    pub fn jump(&mut self, at: u64) -> Result<()> {
        match usize::try_from(at)
            .ok()
            .filter(|at| (self.at..=self.bytes.len()).contains(at))
        {
            Some(at) => {
                self.at = at;
                Ok(())
            }
            None => Err(self.fault(format!("points to byte {at}, back or beyond the end"))),
        }
    }

    /// Bytes that are left.
    pub fn left(&self) -> usize {
        self.bytes.len() - self.at
    }

    fn take<const N: usize>(&mut self) -> Result<[u8; N]> {
        let taken = self.bytes[self.at..].first_chunk::<N>().copied();
        let mut taken = taken.ok_or_else(|| self.fault("the file ends within its data"))?;
        self.at += N;
        if self.big_endian {
            taken.reverse();
        }
        Ok(taken)
    }

    /// A binary i32.
    pub fn binary_i32(&mut self) -> Result<i32> {
        self.take().map(i32::from_le_bytes)
    }

    /// A binary u64.
    pub fn binary_u64(&mut self) -> Result<u64> {
        self.take().map(u64::from_le_bytes)
    }

    /// A binary f32.
    pub fn binary_f32(&mut self) -> Result<f32> {
        self.take().map(f32::from_le_bytes)
    }

    /// A binary f64.
    pub fn binary_f64(&mut self) -> Result<f64> {
        self.take().map(f64::from_le_bytes)
    }
}
