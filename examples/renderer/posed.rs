//! The posed skin on the device, wherever the world computed it.

use std::ops::Range;
use supple::glam::DVec3;
use supple::wgpu;
use supple::world::InstanceId;
use supple::{Result, World};

/// Where the skin is to be pulled from, now and at the step before.
pub struct Posed {
    pub buffers: [wgpu::Buffer; 2],
    pub range: Range<u64>,
    /// What the positions are relative to, m, in the world.
    pub origins: [DVec3; 2],
}

/// What a world on the CPU is uploaded through.
pub struct Upload {
    buffers: [wgpu::Buffer; 2],
    positions: Vec<DVec3>,
    previous: Vec<DVec3>,
    normals: Vec<DVec3>,
    bytes: Vec<[f32; 8]>,
}

impl Upload {
    pub fn new(device: &wgpu::Device, vertices: usize) -> Self {
        let buffer = |_| {
            device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("uploaded skin"),
                size: 32 * vertices as u64,
                usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            })
        };
        Self {
            buffers: [0, 1].map(buffer),
            positions: Vec::new(),
            previous: Vec::new(),
            normals: Vec::new(),
            bytes: Vec::new(),
        }
    }

    /// The skin of an instance: where the world has it on the device, else uploaded.
    pub fn posed(
        &mut self,
        queue: &wgpu::Queue,
        world: &mut World,
        instance: InstanceId,
    ) -> Result<Posed> {
        if let Some(skin) = world.skin_buffer(instance)? {
            return Ok(Posed {
                buffers: [skin.buffer.clone(), skin.previous.clone()],
                range: skin.range,
                origins: [skin.origin, skin.previous_origin],
            });
        }
        world.read_skin_blocking(instance, &mut self.positions, &mut self.normals)?;
        world.read_previous_skin_blocking(instance, &mut self.previous)?;
        // Relative to the root, as f32 is coarse far from the world's origin.
        let origin = world.instance(instance)?.frames()[0].position;
        for (buffer, positions) in self.buffers.iter().zip([&self.positions, &self.previous]) {
            self.bytes.clear();
            let vertices = positions.iter().zip(&self.normals);
            self.bytes.extend(vertices.map(|(position, normal)| {
                let ([x, y, z], [a, b, c]) = (
                    (*position - origin).as_vec3().to_array(),
                    normal.as_vec3().to_array(),
                );
                [x, y, z, 0.0, a, b, c, 0.0]
            }));
            queue.write_buffer(buffer, 0, bytemuck::cast_slice(&self.bytes));
        }
        Ok(Posed {
            buffers: self.buffers.clone(),
            range: 0..32 * self.positions.len() as u64,
            origins: [origin; 2],
        })
    }
}
