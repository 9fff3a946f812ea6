//! What is constant of a primitive of the character's file.

use super::materials::Material;
use super::pipeline::bind;
use super::textures;
use supple::model::{Avatar, RenderMesh};
use supple::wgpu;
use wgpu::util::DeviceExt;

/// A primitive of the character's file on the device.
pub struct Part {
    pub indices: wgpu::Buffer,
    pub count: u32,
    pub bindings: wgpu::BindGroup,
}

impl Part {
    pub fn new(
        gpu: (&wgpu::Device, &wgpu::Queue),
        pipeline: &wgpu::RenderPipeline,
        part: &RenderMesh,
        material: &Material,
    ) -> Self {
        let device = gpu.0;
        let coordinates = |v: usize| part.texture_coordinates.get(v).copied().unwrap_or_default();
        let vertex = |(v, &of_skin): (usize, &u32)| {
            let [u, v] = coordinates(v).map(f32::to_bits);
            [of_skin, u, v]
        };
        let vertices: Vec<[u32; 3]> = part.vertices.iter().enumerate().map(vertex).collect();
        let buffer = |contents: &[u8], usage| {
            device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
                label: Some(&part.name),
                contents,
                usage,
            })
        };
        let indices = part.triangles.as_flattened();
        let [r, g, b, a] = material.colour;
        let surface = [r, g, b, a, material.cutoff, 0.0, 0.0, 0.0];
        let sampler = device.create_sampler(&wgpu::SamplerDescriptor {
            address_mode_u: wgpu::AddressMode::Repeat,
            address_mode_v: wgpu::AddressMode::Repeat,
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            mipmap_filter: wgpu::MipmapFilterMode::Linear,
            ..Default::default()
        });
        let vertices = buffer(bytemuck::cast_slice(&vertices), wgpu::BufferUsages::STORAGE);
        let surface = buffer(bytemuck::cast_slice(&surface), wgpu::BufferUsages::UNIFORM);
        let image = textures::image(gpu, material.image.as_ref());
        let bindings = [
            vertices.as_entire_binding(),
            surface.as_entire_binding(),
            wgpu::BindingResource::TextureView(&image),
            wgpu::BindingResource::Sampler(&sampler),
        ];
        Self {
            indices: buffer(bytemuck::cast_slice(indices), wgpu::BufferUsages::INDEX),
            count: indices.len() as u32,
            bindings: bind(device, pipeline, 2, &bindings),
        }
    }
}

/// The skin as one part, of a body whose file says nothing of how it is drawn.
pub fn whole_skin(avatar: &Avatar) -> RenderMesh {
    RenderMesh {
        vertices: (0..avatar.skin.len() as u32).collect(),
        triangles: avatar.triangles.clone(),
        ..RenderMesh::default()
    }
}
