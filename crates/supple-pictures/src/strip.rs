//! Several pictures on one sheet, with captions and a colour legend.

use super::text::{draw_text, text_width};
use super::{Colour, ColourScale, Image, from_srgb};

/// One picture of a strip.
#[derive(Clone, Debug)]
pub struct Panel {
    /// The picture.
    pub image: Image,
    /// One line below it.
    pub caption: String,
}

/// A colour bar with its scale.
#[derive(Clone, Debug)]
pub struct Legend {
    /// What is shown, with its unit.
    pub title: String,
    /// Which colours stand for which values.
    pub scale: ColourScale,
}

/// A sheet of panels side by side.
#[derive(Clone, Debug, Default)]
pub struct Strip {
    /// The panels, row by row from the left.
    pub panels: Vec<Panel>,
    /// Panels in a row; 0 puts all of them into one.
    pub columns: usize,
    /// Below them, if there is something to read off.
    pub legend: Option<Legend>,
    /// What colours stand for, below that.
    pub key: Vec<(Colour, String)>,
}

const INK: u32 = 0x33302c;
const GAP: usize = 6;

impl Strip {
    /// Draws the sheet. A row is as high, and a column as wide, as its largest picture.
    pub fn compose(&self, background: Colour) -> Image {
        let columns = match self.columns {
            0 => self.panels.len().max(1),
            n => n.min(self.panels.len().max(1)),
        };
        let rows: Vec<&[Panel]> = self.panels.chunks(columns).collect();
        let tallest = |row: &&[Panel]| row.iter().map(|p| p.image.height).max().unwrap_or(0);
        let heights: Vec<usize> = rows.iter().map(tallest).collect();
        let widest = |c: usize| {
            let column = rows.iter().filter_map(|row| row.get(c));
            column.map(|p| p.image.width).max().unwrap_or(0)
        };
        let widths: Vec<usize> = (0..columns).map(widest).collect();
        let width = widths.iter().sum::<usize>() + GAP * (columns - 1);
        let size = (heights.iter().max().unwrap_or(&0) / 24).clamp(12, 28);
        let legend_rows = if self.legend.is_some() { 4 * size } else { 0 };
        let key = KeyLayout::new(&self.key, width, size);
        let pictures = heights.iter().map(|h| h + 2 * size).sum::<usize>();
        let below = pictures + legend_rows;
        let mut sheet = Image::new(width, below + key.height(), background);
        key.draw(&self.key, &mut sheet, below as i64);
        let mut top = 0;
        for (row, height) in rows.iter().zip(&heights) {
            let mut left = 0;
            for (panel, width) in row.iter().zip(&widths) {
                let indent = (width - panel.image.width) / 2;
                sheet.paste(left + indent, top, &panel.image);
                panel.write_caption(&mut sheet, left, top + height + size / 2, *width, size);
                left += width + GAP;
            }
            top += height + 2 * size;
        }
        if let Some(legend) = &self.legend {
            legend.draw(&mut sheet, pictures as i64, size);
        }
        sheet
    }
}

impl Panel {
    /// Writes the caption, with letters of `size` pixels or as small as stay under the picture.
    fn write_caption(&self, sheet: &mut Image, left: usize, y: usize, room: usize, size: usize) {
        let fits = |s: &usize| text_width(&self.caption, *s) <= room;
        let letters = (8..=size).rev().find(fits).unwrap_or(8);
        let wide = text_width(&self.caption, letters) as i64;
        let x = left as i64 + (room as i64 - wide) / 2;
        draw_text(sheet, x, y as i64, letters, &self.caption, from_srgb(INK));
    }
}

/// A key's entries in columns of equal width.
struct KeyLayout {
    columns: usize,
    rows: usize,
    column_width: usize,
    size: usize,
}

impl KeyLayout {
    /// Columns of the longest name, with letters no larger than fit the sheet.
    fn new(key: &[(Colour, String)], width: usize, size: usize) -> Self {
        let size = (3 * size / 4).max(10);
        let names = key.iter().map(|(_, name)| text_width(name, size));
        let column_width = names.max().unwrap_or(0) + 3 * size;
        let columns = (width / column_width.max(1)).clamp(1, key.len().max(1));
        Self {
            columns,
            rows: key.len().div_ceil(columns),
            column_width,
            size,
        }
    }

    fn height(&self) -> usize {
        match self.rows {
            0 => 0,
            rows => (3 * rows + 2) * self.size / 2,
        }
    }

    /// Draws the entries column by column from row `y` on.
    fn draw(&self, key: &[(Colour, String)], sheet: &mut Image, y: i64) {
        let left = sheet.width.saturating_sub(self.columns * self.column_width) / 2;
        for (k, (colour, name)) in key.iter().enumerate() {
            let x = (left + k / self.rows * self.column_width + self.size / 2) as i64;
            let y = y + (k % self.rows * self.size * 3 / 2) as i64;
            sheet.fill(x, y, self.size, self.size, *colour);
            let beside = x + (3 * self.size / 2) as i64;
            draw_text(sheet, beside, y, self.size, name, from_srgb(INK));
        }
    }
}

impl Legend {
    /// Draws title, bar and numbers centred, four lines of `size` pixels from row `y` on.
    fn draw(&self, sheet: &mut Image, y: i64, size: usize) {
        let ink = from_srgb(INK);
        let length = (sheet.width / 2).clamp(1, 24 * size);
        let left = sheet.width.saturating_sub(length) as i64 / 2;
        let centred = |sheet: &mut Image, text: &str, x: i64, y: i64| {
            draw_text(
                sheet,
                x - text_width(text, size) as i64 / 2,
                y,
                size,
                text,
                ink,
            );
        };
        let line = size as i64;
        centred(sheet, &self.title, left + length as i64 / 2, y + line / 4);
        let bar = y + line * 3 / 2;
        let ColourScale { low, high, .. } = self.scale;
        let span = high - low;
        for x in 0..length {
            let value = low + span * (x as f64 + 0.5) / length as f64;
            sheet.fill(
                left + x as i64,
                bar,
                1,
                size * 3 / 4,
                self.scale.colour(value),
            );
        }
        // Numbers that would touch stand twice as far apart.
        let mut step = tick_step(span);
        let room = |step: f64| step / span * length as f64;
        let widest = |step: f64| text_width(&tick_label(high, step), size) + size;
        while step > 0.0 && room(step) < widest(step) as f64 {
            step *= 2.0;
        }
        if step == 0.0 {
            return;
        }
        let first = (low / step - 1e-9).ceil() as i64;
        let last = (high / step + 1e-9).floor() as i64;
        for k in first..=last {
            let value = k as f64 * step;
            let x = left + ((value - low) / span * (length - 1) as f64).round() as i64;
            sheet.fill(x, bar + line * 3 / 4, 1, size / 4, ink);
            centred(sheet, &tick_label(value, step), x, bar + line * 9 / 8);
        }
    }
}

/// `value` with as many decimals as tell it from those a `step` away.
fn tick_label(value: f64, step: f64) -> String {
    let decimals = (-step.log10().floor()).max(0.0) as usize;
    format!("{value:.decimals$}")
}

/// A round step (1, 2 or 5 times a power of ten) that gives four to ten ticks up to `maximum`.
fn tick_step(maximum: f64) -> f64 {
    if !(maximum > 0.0 && maximum.is_finite()) {
        return 0.0;
    }
    let power = 10f64.powf((maximum / 4.0).log10().floor());
    let steps = [5.0, 2.0, 1.0].map(|s| s * power);
    steps
        .into_iter()
        .find(|s| maximum / s >= 4.0)
        .unwrap_or(power)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_few() {
        for (maximum, step) in [(5.0, 1.0), (12.0, 2.0), (0.03, 0.005), (100.0, 20.0)] {
            assert!((tick_step(maximum) / step - 1.0).abs() < 1e-9, "{maximum}");
        }
        assert_eq!(tick_step(0.0), 0.0);
        assert_eq!(tick_step(f64::NAN), 0.0);
    }

    #[test]
    fn an_empty_strip_is_still_a_picture() {
        let sheet = Strip::default().compose([1.0; 3]);
        assert_eq!(sheet.pixels.len(), sheet.width * sheet.height);
    }
}
