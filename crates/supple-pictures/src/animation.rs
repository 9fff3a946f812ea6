//! Pictures that move: APNG, which every browser and most viewers play, and others show the first picture of.

use crate::image::Image;
use std::path::Path;
use supple::internal::write_whole;
use supple::{Error, Result};

/// Pictures of one size, one after the other, again and again.
#[derive(Clone, Debug, PartialEq)]
pub struct Animation {
    /// The pictures.
    pub frames: Vec<Image>,
    /// How long each is seen, s.
    pub frame_time: f64,
}

/// What of a picture differs from the one before: its corner, and that part.
fn changed(before: &Image, now: &Image) -> (usize, usize, Image) {
    let differs = |&i: &usize| before.pixels[i] != now.pixels[i];
    let width = now.width;
    // One pixel where nothing moves: a frame must have one.
    let (mut left, mut right, mut top, mut bottom) = (width - 1, 0, now.height - 1, 0);
    for i in (0..now.pixels.len()).filter(differs) {
        let (x, y) = (i % width, i / width);
        (left, right) = (left.min(x), right.max(x));
        (top, bottom) = (top.min(y), bottom.max(y));
    }
    let (left, top) = (left.min(right), top.min(bottom));
    let rows = (top..=bottom).map(|y| &now.pixels[y * width + left..=y * width + right]);
    let part = Image {
        width: right - left + 1,
        height: bottom - top + 1,
        pixels: rows.flatten().copied().collect(),
    };
    (left, top, part)
}

impl Animation {
    /// The bytes of an APNG file; after the first picture it holds what changes alone.
    ///
    /// # Errors
    /// [`Error::Invalid`] of no picture, an empty one, several sizes, or a time that is not positive.
    pub fn to_png(&self) -> Result<Vec<u8>> {
        let problem = |problem: String| Error::invalid("animation", problem);
        let failed = |e: png::EncodingError| problem(format!("no PNG of it: {e}"));
        let Some(first) = self.frames.first() else {
            return Err(problem("needs a picture".into()));
        };
        let (width, height) = (first.width, first.height);
        let alike = |i: &Image| (i.width, i.height) == (width, height);
        if width * height == 0 || !self.frames.iter().all(alike) {
            return Err(problem("needs pictures of one size".into()));
        }
        let milliseconds = 1e3 * self.frame_time;
        if !(milliseconds >= 1.0 && milliseconds <= f64::from(u16::MAX)) {
            let found = self.frame_time;
            return Err(problem(format!(
                "a picture's time must be 1 ms to 65 s, is {found} s"
            )));
        }
        let mut bytes = Vec::new();
        let mut encoder = first.encoder(&mut bytes);
        encoder
            .set_animated(self.frames.len() as u32, 0)
            .and_then(|()| encoder.set_frame_delay(milliseconds.round() as u16, 1000))
            .map_err(failed)?;
        let mut writer = encoder.write_header().map_err(failed)?;
        let mut write = |(left, top, part): (usize, usize, &Image)| {
            writer.set_frame_position(0, 0)?;
            writer.set_frame_dimension(part.width as u32, part.height as u32)?;
            writer.set_frame_position(left as u32, top as u32)?;
            writer.write_image_data(bytemuck::cast_slice(&part.pixels))
        };
        write((0, 0, first)).map_err(failed)?;
        for pair in self.frames.windows(2) {
            let (left, top, part) = changed(&pair[0], &pair[1]);
            write((left, top, &part)).map_err(failed)?;
        }
        writer.finish().map_err(failed)?;
        Ok(bytes)
    }

    /// Writes an APNG file.
    ///
    /// # Errors
    /// [`Error::Io`], and those of [`Animation::to_png`].
    pub fn write_png(&self, path: &Path) -> Result<()> {
        write_whole(path, self.to_png()?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A spot that wanders, stands still, and jumps.
    fn wandering() -> Animation {
        let frame = |(x, y): (i64, i64)| {
            let mut image = Image::new(9, 7, [1.0; 3]);
            image.fill(x, y, 2, 2, [1.0, 0.0, 0.0]);
            image
        };
        Animation {
            frames: [(0, 0), (1, 1), (1, 1), (7, 5)]
                .into_iter()
                .map(frame)
                .collect(),
            frame_time: 0.05,
        }
    }

    /// Laid over each other, the parts are the pictures.
    #[test]
    fn the_file_plays_the_pictures() {
        let animation = wandering();
        let bytes = animation.to_png().unwrap();
        let mut reader = png::Decoder::new(std::io::Cursor::new(bytes))
            .read_info()
            .unwrap();
        assert_eq!(reader.info().animation_control().unwrap().num_frames, 4);
        let mut shown = Image::new(9, 7, [0.0; 3]);
        for frame in &animation.frames {
            let mut part = vec![0; 9 * 7 * 3];
            let read = reader.next_frame(&mut part).unwrap();
            let control = reader.info().frame_control().unwrap();
            assert_eq!((control.delay_num, control.delay_den), (50, 1000));
            let part = Image {
                width: read.width as usize,
                height: read.height as usize,
                pixels: bytemuck::cast_slice(&part[..read.buffer_size()]).to_vec(),
            };
            shown.paste(control.x_offset as usize, control.y_offset as usize, &part);
            assert_eq!(shown, *frame);
        }
    }

    #[test]
    fn what_is_no_animation_is_an_error() {
        let none = Animation {
            frames: Vec::new(),
            ..wandering()
        };
        assert!(none.to_png().is_err());
        let mut uneven = wandering();
        uneven.frames[2] = Image::new(3, 3, [0.0; 3]);
        assert!(uneven.to_png().is_err());
        for frame_time in [0.0, -1.0, f64::NAN, 100.0] {
            assert!(
                Animation {
                    frame_time,
                    ..wandering()
                }
                .to_png()
                .is_err()
            );
        }
    }
}
