//! The posed skin on the device, wherever the world computed it, and the colours that are shown on it.

use super::gpu::Gpu;
use super::pipelines::Pipelines;
use glam::DVec3;
use std::ops::Range;
use supple::wgpu;

/// Where a skin is to be pulled from.
#[derive(Clone, Debug)]
pub struct Posed {
    /// What holds it.
    pub buffer: wgpu::Buffer,
    /// Its bytes there.
    pub range: Range<u64>,
    /// What its positions are relative to, m, in the world.
    pub origin: DVec3,
}

/// A character's skin: one buffer that uploads go into, one of colours, and what binds them.
pub struct Skin {
    uploaded: wgpu::Buffer,
    colours: wgpu::Buffer,
    vertices: usize,
    /// Memory of uploads.
    bytes: Vec<[f32; 8]>,
    /// What is bound, and where that is from: made again only where the world has made its buffer anew.
    bound: Option<(wgpu::Buffer, Range<u64>, wgpu::BindGroup)>,
}

impl Skin {
    /// Room for so many `vertices`, no colour shown.
    pub fn new(gpu: &Gpu, vertices: usize) -> Self {
        let storage = wgpu::BufferUsages::STORAGE;
        let colours = vec![[0f32; 4]; vertices];
        Self {
            uploaded: gpu.buffer("uploaded skin", 32 * vertices as u64, storage),
            colours: gpu.filled("shown values", &colours, storage),
            vertices,
            bytes: Vec::with_capacity(vertices),
            bound: None,
        }
    }

    /// Uploads positions (m, world) and normals; `origin` is near them.
    pub fn upload(
        &mut self,
        gpu: &Gpu,
        positions: &[DVec3],
        normals: &[DVec3],
        origin: DVec3,
    ) -> Posed {
        self.bytes.clear();
        let vertices = positions.iter().zip(normals).take(self.vertices);
        self.bytes.extend(vertices.map(|(position, normal)| {
            let [x, y, z] = (*position - origin).as_vec3().to_array();
            let [a, b, c] = normal.as_vec3().to_array();
            [x, y, z, 0.0, a, b, c, 0.0]
        }));
        let bytes = bytemuck::cast_slice(&self.bytes);
        gpu.queue.write_buffer(&self.uploaded, 0, bytes);
        Posed {
            buffer: self.uploaded.clone(),
            range: 0..32 * self.vertices as u64,
            origin,
        }
    }

    /// Shows a colour on each vertex: linear red, green, blue, and how much of it.
    pub fn show(&self, gpu: &Gpu, colours: &[[f32; 4]]) {
        let count = colours.len().min(self.vertices);
        let bytes = bytemuck::cast_slice(&colours[..count]);
        gpu.queue.write_buffer(&self.colours, 0, bytes);
    }

    /// The bind group of `posed`.
    pub fn bind(&mut self, gpu: &Gpu, pipelines: &Pipelines, posed: &Posed) -> wgpu::BindGroup {
        if let Some((buffer, range, group)) = &self.bound
            && *buffer == posed.buffer
            && *range == posed.range
        {
            return group.clone();
        }
        let skin = wgpu::BindingResource::Buffer(wgpu::BufferBinding {
            buffer: &posed.buffer,
            offset: posed.range.start,
            size: std::num::NonZero::new(posed.range.end - posed.range.start),
        });
        let resources = [skin, self.colours.as_entire_binding()];
        let group = gpu.bind(&pipelines.skin_layout, &resources);
        self.bound = Some((posed.buffer.clone(), posed.range.clone(), group.clone()));
        group
    }
}
