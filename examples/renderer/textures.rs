//! Textures of the renderer's.

use image::imageops::{FilterType, resize};
use image::{Rgba, RgbaImage};
use supple::wgpu;
use wgpu::util::{DeviceExt, TextureDataOrder};

pub const SAMPLES: u32 = 4;
pub const DEPTH: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

/// An image with its mipmaps; white where there is none.
pub fn image(gpu: (&wgpu::Device, &wgpu::Queue), image: Option<&RgbaImage>) -> wgpu::TextureView {
    let white = RgbaImage::from_pixel(1, 1, Rgba([255; 4]));
    let mut level = image.unwrap_or(&white).clone();
    let (width, height) = level.dimensions();
    let levels = width.max(height).ilog2() + 1;
    let mut bytes = level.to_vec();
    for _ in 1..levels {
        let (width, height) = level.dimensions();
        let half = |size: u32| (size / 2).max(1);
        level = resize(&level, half(width), half(height), FilterType::Triangle);
        bytes.extend_from_slice(&level);
    }
    let descriptor = wgpu::TextureDescriptor {
        label: Some("base colour"),
        size: size([width, height]),
        mip_level_count: levels,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba8UnormSrgb,
        usage: wgpu::TextureUsages::TEXTURE_BINDING,
        view_formats: &[],
    };
    let (device, queue) = gpu;
    let order = TextureDataOrder::LayerMajor;
    let texture = device.create_texture_with_data(queue, &descriptor, order, &bytes);
    texture.create_view(&Default::default())
}

/// Something to draw on, `samples` times.
pub fn target(
    device: &wgpu::Device,
    [width, height]: [u32; 2],
    format: wgpu::TextureFormat,
    samples: u32,
) -> wgpu::Texture {
    use wgpu::TextureUsages as Usages;
    device.create_texture(&wgpu::TextureDescriptor {
        label: Some("target"),
        size: size([width, height]),
        mip_level_count: 1,
        sample_count: samples,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: match samples {
            1 => Usages::RENDER_ATTACHMENT | Usages::COPY_SRC,
            _ => Usages::RENDER_ATTACHMENT,
        },
        view_formats: &[],
    })
}

pub fn size([width, height]: [u32; 2]) -> wgpu::Extent3d {
    wgpu::Extent3d {
        width,
        height,
        depth_or_array_layers: 1,
    }
}
