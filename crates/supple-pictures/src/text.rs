//! Labels, in DejaVu Sans.

use super::{Colour, Image};
use ab_glyph::{Font, FontRef, Glyph, PxScaleFont, ScaleFont, point};
use std::sync::LazyLock;

/// DejaVu Sans, cut as `assets/README.md` says: a TrueType file.
pub const FONT_FILE: &[u8] = include_bytes!("../assets/DejaVuSans-subset.ttf");

static FONT: LazyLock<FontRef<'static>> =
    LazyLock::new(|| FontRef::try_from_slice(FONT_FILE).expect("the font in this crate is sound"));

/// Of a line's height, how much lies above the letters' feet: capitals stand in its middle.
const BASELINE: f32 = 0.865;

/// Width of `text` with letters of `size` pixels, pixels.
pub fn text_width(text: &str, size: usize) -> usize {
    let (_, width) = set(text, size);
    width.ceil() as usize
}

/// Draws one line of text, `size` pixels high, with its top left corner at (`x`, `y`). Descenders, and
/// accents of capitals, reach a tenth of it beyond. How much of a pixel a letter covers is how much of its light is the
/// letter's.
pub fn draw_text(image: &mut Image, x: i64, y: i64, size: usize, text: &str, colour: Colour) {
    for glyph in set(text, size).0 {
        // White space has no outline.
        let Some(outline) = FONT.outline_glyph(glyph) else {
            continue;
        };
        let corner = outline.px_bounds().min;
        let (left, top) = (x + corner.x as i64, y + corner.y as i64);
        outline.draw(|column, row, covered| {
            image.blend(
                left + i64::from(column),
                top + i64::from(row),
                colour,
                covered,
            );
        });
    }
}

/// The letters of a line in their places, kerned, and the line's width.
fn set(text: &str, size: usize) -> (Vec<Glyph>, f32) {
    let font = font(size);
    let baseline = (BASELINE * size as f32).round();
    let (mut glyphs, mut width) = (Vec::<Glyph>::new(), 0.0);
    for character in text.chars() {
        let id = font.glyph_id(character);
        width += glyphs.last().map_or(0.0, |before| font.kern(before.id, id));
        glyphs.push(id.with_scale_and_position(font.scale(), point(width, baseline)));
        width += font.h_advance(id);
    }
    (glyphs, width)
}

/// The font with an em of `size` pixels.
fn font(size: usize) -> PxScaleFont<&'static FontRef<'static>> {
    let em = FONT.units_per_em().unwrap_or(FONT.height_unscaled());
    FONT.as_scaled(size as f32 * FONT.height_unscaled() / em)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::colour::{mix, to_srgb};

    const PAPER: Colour = [1.0, 0.9, 0.7];
    const INK: Colour = [0.0, 0.1, 0.2];

    #[test]
    fn letters_stay_in_their_line() {
        for size in [8, 13, 28] {
            let text = "ÅgjW|";
            let width = text_width(text, size);
            let mut image = Image::new(width + 40, 2 * size + 40, PAPER);
            draw_text(&mut image, 20, 20, size, text, INK);
            let mut inked = image
                .pixels
                .iter()
                .zip(0..)
                .filter(|p| *p.0 != to_srgb(PAPER));
            assert!(inked.clone().count() > size * size / 2);
            let beyond = size.div_ceil(8);
            let rows = 20 - beyond..20 + size + beyond;
            let inside = |at: usize| {
                let (column, row) = (at % image.width, at / image.width);
                (19..=20 + width).contains(&column) && rows.contains(&row)
            };
            assert!(inked.all(|(_, at)| inside(at)), "{size}");
        }
        assert!(text_width("iii", 20) < text_width("WWW", 20));
        assert_eq!(text_width("", 20), 0);
    }

    #[test]
    fn edges_are_mixed_as_light() {
        let mut image = Image::new(12, 60, PAPER);
        // A bar whose left and right edges cross pixels.
        draw_text(&mut image, 2, 10, 30, "|", INK);
        let row = &image.pixels[30 * 12..31 * 12];
        let mut sum = 0.0;
        for pixel in row {
            let (covered, expected) = (0..=1000)
                .map(|k| k as f32 / 1000.0)
                .map(|t| (t, to_srgb(mix(PAPER, INK, t))))
                .min_by_key(|(_, c)| (0..3).map(|k| c[k].abs_diff(pixel[k])).max())
                .unwrap();
            sum += covered;
            assert!(
                (0..3).all(|k| expected[k].abs_diff(pixel[k]) <= 1),
                "{pixel:?}"
            );
        }
        // The bar's outline is 170 of 2048 units wide.
        let width = 30.0 * 170.0 / 2048.0;
        assert!((sum - width).abs() < 0.02, "{sum} for {width}");
    }

    #[test]
    fn what_captions_say_has_letters() {
        for character in "aZ09éöß²³¹½°µ·×–−…‖†′≤≥≈≠∞√∑∂∇∝→⁻ⁿ₁₂ᵀΔΣΩαδλμνπρφω".chars()
        {
            assert_ne!(FONT.glyph_id(character).0, 0, "{character}");
        }
        assert_eq!(FONT.glyph_id('字').0, 0);
    }
}
