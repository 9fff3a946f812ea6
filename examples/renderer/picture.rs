//! A picture off screen.

use super::{Camera, Posed, Renderer, textures};
use std::error::Error;
use std::path::Path;
use supple::wgpu;

/// A row of this width is a multiple of 256 bytes, as copies want it.
const SIZE: [u32; 2] = [960, 720];

/// The format of what [`write_picture`] draws on.
pub const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8UnormSrgb;

/// Draws into a PNG, with no window.
pub fn write_picture(
    renderer: &mut Renderer,
    posed: &Posed,
    camera: &Camera,
    path: &Path,
) -> Result<(), Box<dyn Error>> {
    let (device, queue) = (renderer.device.clone(), renderer.queue.clone());
    let texture = textures::target(&device, SIZE, FORMAT, 1);
    renderer.draw(
        posed,
        camera,
        &texture.create_view(&Default::default()),
        SIZE,
    );
    let [width, height] = SIZE;
    let copy = device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("picture"),
        size: u64::from(4 * width * height),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let mut encoder = device.create_command_encoder(&Default::default());
    let layout = wgpu::TexelCopyBufferLayout {
        offset: 0,
        bytes_per_row: Some(4 * width),
        rows_per_image: None,
    };
    let to = wgpu::TexelCopyBufferInfo {
        buffer: &copy,
        layout,
    };
    encoder.copy_texture_to_buffer(texture.as_image_copy(), to, textures::size(SIZE));
    queue.submit([encoder.finish()]);
    copy.map_async(wgpu::MapMode::Read, .., |_| ());
    device.poll(wgpu::PollType::wait_indefinitely())?;
    let bytes = copy.get_mapped_range(..)?;
    if let Some(folder) = path.parent().filter(|f| !f.as_os_str().is_empty()) {
        std::fs::create_dir_all(folder)?;
    }
    image::save_buffer(path, &bytes, width, height, image::ColorType::Rgba8)?;
    println!("{}", path.display());
    Ok(())
}
