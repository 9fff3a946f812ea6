//! Distance grids of mesh colliders in one texture, stacked along z.

use crate::collider::{Collider, DistanceGrid, MESH_NODES, Shape};
use crate::{GpuError, Result};
use std::sync::Arc;

/// A texture with room for some grids, and whose they are.
#[derive(Debug)]
pub(super) struct Grids {
    texture: wgpu::Texture,
    view: wgpu::TextureView,
    capacity: usize,
    held: Vec<Arc<DistanceGrid>>,
}

/// Nodes along an axis.
const NODES: u32 = MESH_NODES as u32;

impl Grids {
    /// Room for `capacity` grids.
    ///
    /// # Errors
    /// [`GpuError::Limit`] where a texture cannot be so deep.
    pub fn new(device: &wgpu::Device, capacity: usize) -> Result<Self> {
        let (needed, limit) = (
            u64::from(NODES) * capacity.max(1) as u64,
            u64::from(device.limits().max_texture_dimension_3d),
        );
        if needed > limit {
            return Err(GpuError::Limit {
                what: "depth of the texture of mesh colliders".to_owned(),
                needed,
                limit,
                cure: "lower GpuOptions::meshes",
            }
            .into());
        }
        let texture = device.create_texture(&wgpu::TextureDescriptor {
            label: Some("distance_grids"),
            size: wgpu::Extent3d {
                width: NODES,
                height: NODES,
                depth_or_array_layers: needed as u32,
            },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D3,
            format: wgpu::TextureFormat::R32Float,
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        });
        Ok(Self {
            view: texture.create_view(&wgpu::TextureViewDescriptor::default()),
            texture,
            capacity,
            held: Vec::new(),
        })
    }

    pub fn view(&self) -> &wgpu::TextureView {
        &self.view
    }

    /// Index of `collider`'s grid, 0 of a shape without one; a grid that is new is sent.
    ///
    /// # Errors
    /// [`GpuError::Limit`] where there is no room for another grid.
    pub fn index(&mut self, queue: &wgpu::Queue, collider: &Collider) -> Result<usize> {
        let Shape::Mesh(mesh) = &collider.shape else {
            return Ok(0);
        };
        let grid = mesh.grid();
        if let Some(index) = self.held.iter().position(|s| Arc::ptr_eq(s, grid)) {
            return Ok(index);
        }
        let index = self.held.len();
        if index >= self.capacity {
            return Err(GpuError::Limit {
                what: "meshes that are colliders".to_owned(),
                needed: index as u64 + 1,
                limit: self.capacity as u64,
                cure: "raise GpuOptions::meshes",
            }
            .into());
        }
        let size = wgpu::Extent3d {
            width: NODES,
            height: NODES,
            depth_or_array_layers: NODES,
        };
        queue.write_texture(
            wgpu::TexelCopyTextureInfo {
                texture: &self.texture,
                mip_level: 0,
                origin: wgpu::Origin3d {
                    x: 0,
                    y: 0,
                    z: NODES * index as u32,
                },
                aspect: wgpu::TextureAspect::All,
            },
            bytemuck::cast_slice(grid.values()),
            wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(4 * NODES),
                rows_per_image: Some(NODES),
            },
            size,
        );
        self.held.push(grid.clone());
        Ok(index)
    }
}
