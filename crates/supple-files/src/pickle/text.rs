//! Texts as pickles write them.

use std::borrow::Cow;

/// Latin-1: one character a byte.
pub(super) fn from_latin1(bytes: &[u8]) -> Cow<'_, str> {
    match std::str::from_utf8(bytes) {
        Ok(text) if text.is_ascii() => Cow::Borrowed(text),
        _ => bytes.iter().map(|&b| char::from(b)).collect(),
    }
}

/// The bytes of a text whose characters are all below 256.
pub(super) fn to_latin1(text: &str) -> Result<Cow<'_, [u8]>, String> {
    if text.is_ascii() {
        return Ok(Cow::Borrowed(text.as_bytes()));
    }
    let byte = |c: char| u8::try_from(u32::from(c)).ok();
    let bytes: Option<Vec<u8>> = text.chars().map(byte).collect();
    bytes
        .map(Cow::Owned)
        .ok_or_else(|| "a text that stands for bytes holds a character beyond 255".into())
}

/// Python 2's text literal of protocol 0: in quotes, with escapes.
pub(super) fn from_literal(line: &[u8]) -> Result<Vec<u8>, String> {
    let inside = match line {
        [b'\'', inside @ .., b'\''] | [b'"', inside @ .., b'"'] => inside,
        _ => return Err("a text without its quotes".into()),
    };
    let mut bytes = Vec::with_capacity(inside.len());
    let mut rest = inside.iter().copied();
    while let Some(byte) = rest.next() {
        if byte != b'\\' {
            bytes.push(byte);
            continue;
        }
        bytes.push(match rest.next() {
            Some(c @ (b'\\' | b'\'' | b'"')) => c,
            Some(b'n') => b'\n',
            Some(b'r') => b'\r',
            Some(b't') => b'\t',
            Some(b'x') => hexadecimal(&mut rest, 2)? as u8,
            _ => return Err("a text with an unknown escape".into()),
        });
    }
    Ok(bytes)
}

/// Python's `raw-unicode-escape` of protocol 0: Latin-1 with `\uXXXX` and `\UXXXXXXXX`.
pub(super) fn from_raw_unicode(line: &[u8]) -> Result<String, String> {
    let mut text = String::with_capacity(line.len());
    let mut rest = line.iter().copied().peekable();
    while let Some(byte) = rest.next() {
        let escaped = match (byte, rest.peek()) {
            (b'\\', Some(b'u')) => 4,
            (b'\\', Some(b'U')) => 8,
            _ => {
                text.push(char::from(byte));
                continue;
            }
        };
        rest.next();
        let code = hexadecimal(&mut rest, escaped)?;
        text.push(char::from_u32(code).unwrap_or(char::REPLACEMENT_CHARACTER));
    }
    Ok(text)
}

fn hexadecimal(bytes: &mut impl Iterator<Item = u8>, digits: usize) -> Result<u32, String> {
    (0..digits).try_fold(0, |code, _| {
        let digit = bytes.next().and_then(|b| char::from(b).to_digit(16));
        digit
            .map(|d| code << 4 | d)
            .ok_or_else(|| "a text with a broken escape".to_string())
    })
}
