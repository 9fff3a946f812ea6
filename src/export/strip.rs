//! Several pictures on one sheet, with captions and a colour legend.

use super::text::{draw_text, text_width};
use super::{Colour, Image, colour_map, from_srgb};

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
    /// Value of the darkest colour; the lightest is 0.
    pub maximum: f64,
}

/// A sheet of panels side by side.
#[derive(Clone, Debug, Default)]
pub struct Strip {
    /// The panels, from the left.
    pub panels: Vec<Panel>,
    /// Below them, if there is something to read off.
    pub legend: Option<Legend>,
    /// What colours stand for, below that.
    pub key: Vec<(Colour, String)>,
}

const INK: u32 = 0x33302c;
const GAP: usize = 6;

impl Strip {
    /// Draws the sheet.
    pub fn compose(&self, background: Colour) -> Image {
        let panels = &self.panels;
        let height = panels.iter().map(|p| p.image.height).max().unwrap_or(0);
        let gaps = GAP * panels.len().saturating_sub(1);
        let width = panels.iter().map(|p| p.image.width).sum::<usize>() + gaps;
        let size = (height / 24).clamp(12, 28);
        let legend_rows = if self.legend.is_some() { 4 * size } else { 0 };
        let key = KeyLayout::new(&self.key, width, size);
        let rows = height + 2 * size + legend_rows;
        let mut sheet = Image::new(width, rows + key.height(), background);
        key.draw(&self.key, &mut sheet, rows as i64);
        let ink = from_srgb(INK);
        let mut left = 0;
        for panel in panels {
            sheet.paste(left, 0, &panel.image);
            // A caption stays under its own picture.
            let room = panel.image.width;
            let fits = |s: &usize| text_width(&panel.caption, *s) <= room;
            let letters = (8..=size).rev().find(fits).unwrap_or(8);
            let wide = text_width(&panel.caption, letters) as i64;
            let x = left as i64 + (room as i64 - wide) / 2;
            let y = (height + size / 2) as i64;
            draw_text(&mut sheet, x, y, letters, &panel.caption, ink);
            left += panel.image.width + GAP;
        }
        if let Some(legend) = &self.legend {
            legend.draw(&mut sheet, (height + 2 * size) as i64, size);
        }
        sheet
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
        for x in 0..length {
            let colour = colour_map((x as f64 + 0.5) / length as f64);
            sheet.fill(left + x as i64, bar, 1, size * 3 / 4, colour);
        }
        // Numbers that would touch stand twice as far apart.
        let mut step = tick_step(self.maximum);
        let widest = text_width(&format!("{:.0}  ", self.maximum), size) as f64;
        while step > 0.0 && step / self.maximum * (length as f64) < widest {
            step *= 2.0;
        }
        let ticks = (self.maximum / step + 1e-9).floor() as usize;
        for k in (0..=ticks).filter(|_| step > 0.0) {
            let value = k as f64 * step;
            let x = left + (value / self.maximum * (length - 1) as f64).round() as i64;
            sheet.fill(x, bar + line * 3 / 4, 1, size / 4, ink);
            let decimals = if step < 1.0 {
                (-step.log10().floor()) as usize
            } else {
                0
            };
            centred(sheet, &format!("{value:.decimals$}"), x, bar + line * 9 / 8);
        }
    }
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
