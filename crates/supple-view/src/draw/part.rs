//! What is constant of a character: its parts and their paint.

use super::gpu::Gpu;
use super::look::{Look, Material};
use super::pipelines::Pipelines;
use super::texture::Mipmaps;
use supple::model::{Avatar, RenderMesh};
use supple::wgpu;

/// A primitive of the character's file on the device.
pub struct Part {
    indices: wgpu::Buffer,
    count: u32,
    bindings: wgpu::BindGroup,
}

impl Part {
    /// All parts of `avatar`, painted as `look` says.
    pub fn all(gpu: &Gpu, pipelines: &Pipelines, avatar: &Avatar, look: &Look) -> Vec<Self> {
        let whole = [whole_skin(avatar)];
        let parts = match avatar.render_meshes.as_slice() {
            [] => &whole,
            parts => parts,
        };
        let upload = |colour: bool| {
            let image =
                move |image: &Option<Mipmaps>| image.as_ref().map(|i| i.upload(gpu, colour));
            look.images.iter().map(image).collect::<Vec<_>>()
        };
        // The same image may be colours to one material and normals to another.
        let [colours, normals] = [true, false].map(upload);
        let white = Mipmaps::of_colour([255; 4]).upload(gpu, true);
        let level = Mipmaps::of_colour([128, 128, 255, 255]).upload(gpu, false);
        let sampler = gpu.device.create_sampler(&wgpu::SamplerDescriptor {
            address_mode_u: wgpu::AddressMode::Repeat,
            address_mode_v: wgpu::AddressMode::Repeat,
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            mipmap_filter: wgpu::MipmapFilterMode::Linear,
            ..Default::default()
        });
        let part = |part: &RenderMesh| {
            let of_file = part
                .material_index
                .and_then(|m| look.materials.get(m as usize));
            let material = of_file.unwrap_or(&Material::PLAIN);
            let find = |list: &[Option<wgpu::TextureView>], at: Option<usize>| {
                at.and_then(|i| list.get(i)?.clone())
            };
            let bump = find(&normals, material.normals);
            let bumps = if bump.is_some() { material.bumps } else { 0.0 };
            let [r, g, b, a] = material.colour;
            let surface = [r, g, b, a, material.cutoff, bumps, material.glow, 0.0];
            let vertices = gpu.filled(&part.name, &vertices(part), wgpu::BufferUsages::STORAGE);
            let surface = gpu.filled(&part.name, &surface, wgpu::BufferUsages::UNIFORM);
            let base = find(&colours, material.image).unwrap_or_else(|| white.clone());
            let indices = part.triangles.as_flattened();
            Self {
                indices: gpu.filled(&part.name, indices, wgpu::BufferUsages::INDEX),
                count: indices.len() as u32,
                bindings: gpu.bind(
                    &pipelines.part_layout,
                    &[
                        vertices.as_entire_binding(),
                        surface.as_entire_binding(),
                        wgpu::BindingResource::TextureView(&base),
                        wgpu::BindingResource::TextureView(bump.as_ref().unwrap_or(&level)),
                        wgpu::BindingResource::Sampler(&sampler),
                    ],
                ),
            }
        };
        parts
            .iter()
            .filter(|p| !p.triangles.is_empty())
            .map(part)
            .collect()
    }

    /// Draws it with whatever pipeline is set.
    pub fn draw(&self, pass: &mut wgpu::RenderPass<'_>) {
        pass.set_bind_group(2, &self.bindings, &[]);
        pass.set_index_buffer(self.indices.slice(..), wgpu::IndexFormat::Uint32);
        pass.draw_indexed(0..self.count, 0, 0..1);
    }
}

/// Of each of a part's own vertices: which of the skin's it is, and its texture coordinates.
fn vertices(part: &RenderMesh) -> Vec<[u32; 3]> {
    let coordinates = |v: usize| part.texture_coordinates.get(v).copied().unwrap_or_default();
    let vertex = |(v, &of_skin): (usize, &u32)| {
        let [u, v] = coordinates(v).map(f32::to_bits);
        [of_skin, u, v]
    };
    part.vertices.iter().enumerate().map(vertex).collect()
}

/// The skin as one part, of a body whose file says nothing of how it is drawn.
fn whole_skin(avatar: &Avatar) -> RenderMesh {
    RenderMesh {
        vertices: (0..avatar.skin.len() as u32).collect(),
        triangles: avatar.triangles.clone(),
        ..RenderMesh::default()
    }
}
