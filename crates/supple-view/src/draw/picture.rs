//! Pictures off screen.

use super::gpu::Gpu;
use super::texture::{extent, target};
use std::path::Path;
use supple::wgpu;
use supple::{Error, GpuError, Result};

/// What pictures are in.
pub const PICTURE_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8UnormSrgb;

/// Pixels, row by row from above: red, green, blue, opacity.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Picture {
    /// Width and height.
    pub size: [u32; 2],
    /// Four bytes a pixel.
    pub bytes: Vec<u8>,
}

/// What `draw` draws on a texture of this size and [`PICTURE_FORMAT`].
///
/// # Errors
/// What `draw` says; a lost device.
pub async fn picture(
    gpu: &Gpu,
    size: [u32; 2],
    draw: impl FnOnce(&wgpu::TextureView) -> Result<()>,
) -> Result<Picture> {
    let texture = target(gpu, size, PICTURE_FORMAT, 1, wgpu::TextureUsages::COPY_SRC);
    draw(&texture.create_view(&Default::default()))?;
    let [width, height] = size;
    // Copies want rows of a multiple of 256 bytes.
    let row = (4 * width).next_multiple_of(256);
    let copy = gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("picture"),
        size: u64::from(row * height),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    let to = wgpu::TexelCopyBufferInfo {
        buffer: &copy,
        layout: wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(row),
            rows_per_image: None,
        },
    };
    encoder.copy_texture_to_buffer(texture.as_image_copy(), to, extent(size));
    gpu.queue.submit([encoder.finish()]);
    let lost = |e: &dyn std::fmt::Display| Error::from(GpuError::DeviceLost(e.to_string()));
    let (sender, receiver) = std::sync::mpsc::channel();
    copy.map_async(wgpu::MapMode::Read, .., move |mapped| {
        // Nobody waits any more where this fails.
        let _ = sender.send(mapped);
    });
    (gpu.device.poll(wgpu::PollType::wait_indefinitely())).map_err(|e| lost(&e))?;
    let mapped = receiver.recv().map_err(|e| lost(&e))?;
    mapped.map_err(|e| lost(&e))?;
    let bytes = copy.get_mapped_range(..).map_err(|e| lost(&e))?;
    let rows = bytes.chunks_exact(row as usize);
    Ok(Picture {
        size,
        bytes: rows
            .flat_map(|r| r[..4 * width as usize].to_vec())
            .collect(),
    })
}

impl Picture {
    /// Red, green and blue of a pixel.
    pub fn at(&self, x: u32, y: u32) -> [u8; 3] {
        let at = 4 * (y * self.size[0] + x) as usize;
        [self.bytes[at], self.bytes[at + 1], self.bytes[at + 2]]
    }

    /// Writes a PNG.
    ///
    /// # Errors
    /// [`Error::Io`] where it cannot be written.
    pub fn write_png(&self, path: &Path) -> Result<()> {
        let [width, height] = self.size;
        let rgb: Vec<u8> = (self.bytes.chunks_exact(4))
            .flat_map(|p| [p[0], p[1], p[2]])
            .collect();
        let saved = image::save_buffer(path, &rgb, width, height, image::ColorType::Rgb8);
        saved.map_err(|e| Error::io(path, std::io::Error::other(e)))
    }
}
