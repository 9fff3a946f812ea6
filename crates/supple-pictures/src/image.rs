//! 8-bit pictures and their PNG files.

use super::Colour;
use super::colour::{from_srgb, mix, to_srgb};
use std::path::Path;
use supple::internal::write_whole;
use supple::{Error, Result};

/// An sRGB picture, rows from the top.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// Pixels in a row.
    pub width: usize,
    /// Number of rows.
    pub height: usize,
    /// `width · height` pixels.
    pub pixels: Vec<[u8; 3]>,
}

impl Image {
    /// A picture of one colour.
    pub fn new(width: usize, height: usize, colour: Colour) -> Self {
        Self {
            width,
            height,
            pixels: vec![to_srgb(colour); width * height],
        }
    }

    /// Lays `colour` over a pixel with opacity `alpha`; pixels outside are ignored.
    pub fn blend(&mut self, x: i64, y: i64, colour: Colour, alpha: f32) {
        let inside = x >= 0 && y >= 0 && x < self.width as i64 && y < self.height as i64;
        if inside && alpha > 0.0 {
            let pixel = &mut self.pixels[y as usize * self.width + x as usize];
            let [r, g, b] = pixel.map(u32::from);
            *pixel = to_srgb(mix(from_srgb(r << 16 | g << 8 | b), colour, alpha.min(1.0)));
        }
    }

    /// Fills a rectangle.
    pub fn fill(&mut self, x: i64, y: i64, width: usize, height: usize, colour: Colour) {
        for row in y..y + height as i64 {
            for column in x..x + width as i64 {
                self.blend(column, row, colour, 1.0);
            }
        }
    }

    /// Copies `other` in with its top left corner at (`x`, `y`); what reaches outside is cut off.
    pub fn paste(&mut self, x: usize, y: usize, other: &Image) {
        let width = other.width.min(self.width.saturating_sub(x));
        for row in 0..other.height.min(self.height.saturating_sub(y)) {
            let to = (y + row) * self.width + x;
            let from = row * other.width;
            self.pixels[to..to + width].copy_from_slice(&other.pixels[from..from + width]);
        }
    }

    /// Lays `other` into the lower right corner, in a thin frame.
    pub fn inset(&mut self, other: &Image, frame: Colour) {
        const FRAME: usize = 2;
        let (width, height) = (other.width + 2 * FRAME, other.height + 2 * FRAME);
        let (x, y) = (
            self.width.saturating_sub(width),
            self.height.saturating_sub(height),
        );
        self.fill(x as i64, y as i64, width, height, frame);
        self.paste(x + FRAME, y + FRAME, other);
    }

    /// What writes PNG files of its size and kind.
    pub(crate) fn encoder<W: std::io::Write>(&self, to: W) -> png::Encoder<'_, W> {
        let mut encoder = png::Encoder::new(to, self.width as u32, self.height as u32);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        encoder
    }

    /// The picture as the bytes of a PNG file.
    pub fn to_png(&self) -> Result<Vec<u8>> {
        let failed = |e: png::EncodingError| Error::invalid("image", format!("no PNG of it: {e}"));
        let mut bytes = Vec::new();
        let mut writer = (self.encoder(&mut bytes).write_header()).map_err(failed)?;
        writer
            .write_image_data(bytemuck::cast_slice(&self.pixels))
            .map_err(failed)?;
        writer.finish().map_err(failed)?;
        Ok(bytes)
    }

    /// Writes a PNG file.
    pub fn write_png(&self, path: &Path) -> Result<()> {
        write_whole(path, self.to_png()?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn png_holds_the_pixels() {
        let mut image = Image::new(5, 3, [1.0, 0.5, 0.0]);
        image.fill(-1, 1, 3, 9, [0.0, 0.0, 1.0]);
        let bytes = image.to_png().unwrap();
        let mut reader = png::Decoder::new(std::io::Cursor::new(bytes))
            .read_info()
            .unwrap();
        let mut pixels = vec![0; 5 * 3 * 3];
        reader.next_frame(&mut pixels).unwrap();
        assert_eq!(pixels, bytemuck::cast_slice::<_, u8>(&image.pixels));
        assert_eq!(image.pixels[5], [0, 0, 255]);
        assert_eq!(image.pixels[2], [255, 188, 0]);
    }
}
