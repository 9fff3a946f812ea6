//! Labels, from an 8×8 font smoothed as it is enlarged.

use super::{Colour, Image};

/// Width of `text` at `size` pixels a line, pixels.
pub fn text_width(text: &str, size: usize) -> usize {
    (text.chars().count() as f64 * size as f64 * ADVANCE).ceil() as usize
}

/// Width of a character, in lines.
const ADVANCE: f64 = 0.68;

/// Draws one line of text with its top left corner at (`x`, `y`).
///
/// The font's bits are read as a field, interpolated smoothly and cut at one half: strokes come out
/// round instead of blocky.
pub fn draw_text(image: &mut Image, x: i64, y: i64, size: usize, text: &str, colour: Colour) {
    let scale = 8.0 / size as f64;
    let advance = size as f64 * ADVANCE;
    for (k, character) in text.chars().enumerate() {
        let glyph = glyph(character);
        let left = k as f64 * advance;
        for row in 0..size as i64 {
            for column in left as i64..(left + advance).ceil() as i64 {
                let u = (column as f64 + 0.5 - left) * scale / ADVANCE;
                let v = (row as f64 + 0.5) * scale;
                // The edge is about one pixel wide.
                let alpha = (field(&glyph, u, v) - 0.45) / (1.3 * scale).min(1.0) + 0.5;
                image.blend(x + column, y + row, colour, alpha.clamp(0.0, 1.0) as f32);
            }
        }
    }
}

/// Bilinear interpolation of the glyph's bits at `u` to the right and `v` down, in font pixels.
fn field(glyph: &[u8; 8], u: f64, v: f64) -> f64 {
    let bit = |x: i64, y: i64| {
        let inside = (0..8).contains(&x) && (0..8).contains(&y);
        f64::from(u8::from(
            inside && glyph[y as usize & 7] >> (x as usize & 7) & 1 == 1,
        ))
    };
    let (u, v) = (u - 0.5, v - 0.5);
    let (x, y) = (u.floor(), v.floor());
    let (s, t) = (u - x, v - y);
    let (x, y) = (x as i64, y as i64);
    let top = bit(x, y) * (1.0 - s) + bit(x + 1, y) * s;
    let bottom = bit(x, y + 1) * (1.0 - s) + bit(x + 1, y + 1) * s;
    top * (1.0 - t) + bottom * t
}

/// The bits of a character; a hollow box where the font has none.
fn glyph(character: char) -> [u8; 8] {
    const MISSING: [u8; 8] = [0x7e, 0x42, 0x42, 0x42, 0x42, 0x42, 0x7e, 0];
    let code = character as usize;
    match code {
        0..0x80 => font8x8::legacy::BASIC_LEGACY[code],
        0xa0..0x100 => font8x8::legacy::LATIN_LEGACY[code - 0xa0],
        0x390..0x3ca => font8x8::legacy::GREEK_LEGACY[code - 0x390],
        0x2212 => font8x8::legacy::BASIC_LEGACY['-' as usize],
        _ => MISSING,
    }
}
