//! Textures: images with their smaller copies, and what is drawn on.

use super::gpu::Gpu;
use image::RgbaImage;
use supple::wgpu;
use wgpu::util::{DeviceExt, TextureDataOrder};

/// Samples a pixel of the scene.
pub const SAMPLES: u32 = 4;
/// Of depths.
pub const DEPTH: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

/// An image and its copies of half the size, down to a pixel: ready for the device, and made beside it.
#[derive(Clone, Debug)]
pub struct Mipmaps {
    size: [u32; 2],
    levels: u32,
    bytes: Vec<u8>,
}

impl Mipmaps {
    /// Of an image.
    pub fn new(image: RgbaImage) -> Self {
        let (width, height) = image.dimensions();
        let (mut size, mut levels) = ([width.max(1), height.max(1)], 1);
        let mut level = image.into_raw();
        level.resize(4 * (size[0] * size[1]) as usize, 255);
        let mut bytes = level.clone();
        while size != [1, 1] {
            (size, level) = halved(size, &level);
            bytes.extend_from_slice(&level);
            levels += 1;
        }
        Self {
            size: [width.max(1), height.max(1)],
            levels,
            bytes,
        }
    }

    /// One pixel of this colour.
    pub fn of_colour(colour: [u8; 4]) -> Self {
        Self {
            size: [1, 1],
            levels: 1,
            bytes: colour.to_vec(),
        }
    }

    /// On the device; `colour` says that its numbers are sRGB.
    pub fn upload(&self, gpu: &Gpu, colour: bool) -> wgpu::TextureView {
        let [width, height] = self.size;
        let descriptor = wgpu::TextureDescriptor {
            label: Some("image"),
            size: extent([width, height]),
            mip_level_count: self.levels,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: match colour {
                true => wgpu::TextureFormat::Rgba8UnormSrgb,
                false => wgpu::TextureFormat::Rgba8Unorm,
            },
            usage: wgpu::TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        };
        let order = TextureDataOrder::LayerMajor;
        let (device, queue) = (&gpu.device, &gpu.queue);
        let texture = device.create_texture_with_data(queue, &descriptor, order, &self.bytes);
        texture.create_view(&Default::default())
    }
}

/// The mean of each two by two pixels.
fn halved([width, height]: [u32; 2], of: &[u8]) -> ([u32; 2], Vec<u8>) {
    let size = [(width / 2).max(1), (height / 2).max(1)];
    let mut out = Vec::with_capacity(4 * (size[0] * size[1]) as usize);
    for y in 0..size[1] {
        for x in 0..size[0] {
            for c in 0..4 {
                let at = |dx: u32, dy: u32| {
                    let (x, y) = ((2 * x + dx).min(width - 1), (2 * y + dy).min(height - 1));
                    u32::from(of[(4 * (y * width + x) + c) as usize])
                };
                let sum = at(0, 0) + at(1, 0) + at(0, 1) + at(1, 1);
                out.push(((sum + 2) / 4) as u8);
            }
        }
    }
    (size, out)
}

/// Something to draw on, `samples` times a pixel.
pub fn target(
    gpu: &Gpu,
    size: [u32; 2],
    format: wgpu::TextureFormat,
    samples: u32,
    usage: wgpu::TextureUsages,
) -> wgpu::Texture {
    gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("target"),
        size: extent(size),
        mip_level_count: 1,
        sample_count: samples,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | usage,
        view_formats: &[],
    })
}

/// A texture's extent.
pub fn extent([width, height]: [u32; 2]) -> wgpu::Extent3d {
    wgpu::Extent3d {
        width,
        height,
        depth_or_array_layers: 1,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_image_has_all_its_smaller_copies() {
        let image = RgbaImage::from_fn(5, 2, |x, _| image::Rgba([10 * x as u8, 0, 0, 255]));
        let mipmaps = Mipmaps::new(image);
        // 5 × 2, 2 × 1, 1 × 1.
        assert_eq!((mipmaps.levels, mipmaps.bytes.len()), (3, 4 * (10 + 2 + 1)));
        let red: Vec<u8> = mipmaps.bytes[40..].iter().step_by(4).copied().collect();
        assert_eq!(red, [5, 25, 15]);
    }
}
