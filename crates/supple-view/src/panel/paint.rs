//! Paints what egui lays out.

use crate::draw::Gpu;
use crate::draw::pipelines::{layout, pipeline_layout};
use egui::epaint::{ImageDelta, Primitive};
use egui::{ClippedPrimitive, ImageData, TextureId, TexturesDelta};
use std::collections::HashMap;
use supple::wgpu;
use wgpu::ShaderStages as Stages;

/// Paints onto a target of one format.
pub struct Painter {
    gpu: Gpu,
    pipeline: wgpu::RenderPipeline,
    texture_layout: wgpu::BindGroupLayout,
    sampler: wgpu::Sampler,
    screen: wgpu::Buffer,
    screen_group: wgpu::BindGroup,
    textures: HashMap<TextureId, (wgpu::Texture, wgpu::BindGroup)>,
    /// Vertices and indices; made anew where there are more than ever.
    buffers: [Option<wgpu::Buffer>; 2],
    vertices: Vec<egui::epaint::Vertex>,
    indices: Vec<u32>,
}

/// How large the target is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Screen {
    /// Pixels.
    pub size: [u32; 2],
    /// Pixels a point.
    pub scale: f32,
}

impl Painter {
    /// For targets in `format`, whose numbers are sRGB.
    pub fn new(gpu: &Gpu, format: wgpu::TextureFormat) -> Self {
        let device = &gpu.device;
        let uniform = wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Uniform,
            has_dynamic_offset: false,
            min_binding_size: None,
        };
        let image = wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Float { filterable: true },
            view_dimension: wgpu::TextureViewDimension::D2,
            multisampled: false,
        };
        let sampler = wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering);
        let screen_layout = layout(device, &[(Stages::VERTEX, uniform)]);
        let texture_layout = layout(
            device,
            &[(Stages::FRAGMENT, image), (Stages::FRAGMENT, sampler)],
        );
        let screen = gpu.buffer("screen", 16, wgpu::BufferUsages::UNIFORM);
        Self {
            pipeline: pipeline(
                device,
                &pipeline_layout(device, &[&screen_layout, &texture_layout]),
                format,
            ),
            screen_group: gpu.bind(&screen_layout, &[screen.as_entire_binding()]),
            sampler: device.create_sampler(&wgpu::SamplerDescriptor {
                mag_filter: wgpu::FilterMode::Linear,
                min_filter: wgpu::FilterMode::Linear,
                ..Default::default()
            }),
            gpu: gpu.clone(),
            texture_layout,
            screen,
            textures: HashMap::new(),
            buffers: [None, None],
            vertices: Vec::new(),
            indices: Vec::new(),
        }
    }

    /// Records `primitives` onto `target`, over what is there.
    pub fn paint(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        target: &wgpu::TextureView,
        screen: Screen,
        primitives: &[ClippedPrimitive],
        changed: &TexturesDelta,
    ) {
        for (id, delta) in &changed.set {
            self.set_texture(*id, delta);
        }
        let size = screen.size.map(|n| n as f32 / screen.scale);
        let points = [size[0], size[1], 0.0, 0.0];
        (self.gpu.queue).write_buffer(&self.screen, 0, bytemuck::cast_slice(&points));
        self.vertices.clear();
        self.indices.clear();
        let mut draws = Vec::with_capacity(primitives.len());
        for ClippedPrimitive {
            clip_rect,
            primitive,
        } in primitives
        {
            // Callbacks are of hosts that paint by egui.
            let Primitive::Mesh(mesh) = primitive else {
                continue;
            };
            let (first, base) = (self.indices.len() as u32, self.vertices.len() as i32);
            self.vertices.extend_from_slice(&mesh.vertices);
            self.indices.extend_from_slice(&mesh.indices);
            if let Some(clip) = scissor(*clip_rect, screen) {
                draws.push((
                    clip,
                    mesh.texture_id,
                    first..self.indices.len() as u32,
                    base,
                ));
            }
        }
        let uploads: [(&[u8], _); 2] = [
            (
                bytemuck::cast_slice(&self.vertices),
                wgpu::BufferUsages::VERTEX,
            ),
            (
                bytemuck::cast_slice(&self.indices),
                wgpu::BufferUsages::INDEX,
            ),
        ];
        for (buffer, (bytes, usage)) in self.buffers.iter_mut().zip(uploads) {
            let needed = bytes.len() as u64;
            let buffer = match buffer.take().filter(|b| b.size() >= needed) {
                Some(there) => buffer.insert(there),
                None => {
                    let size = needed.next_power_of_two().max(1 << 16);
                    buffer.insert(self.gpu.buffer("interface", size, usage))
                }
            };
            self.gpu.queue.write_buffer(buffer, 0, bytes);
        }
        if let [Some(vertices), Some(indices)] = &self.buffers {
            let mut pass = over(encoder, target);
            pass.set_pipeline(&self.pipeline);
            pass.set_bind_group(0, &self.screen_group, &[]);
            pass.set_vertex_buffer(0, vertices.slice(..));
            pass.set_index_buffer(indices.slice(..), wgpu::IndexFormat::Uint32);
            for ([x, y, width, height], texture, range, base) in draws {
                if let Some((_, group)) = self.textures.get(&texture) {
                    pass.set_scissor_rect(x, y, width, height);
                    pass.set_bind_group(1, group, &[]);
                    pass.draw_indexed(range, base, 0..1);
                }
            }
        }
        for id in &changed.free {
            self.textures.remove(id);
        }
    }

    /// Makes a texture, or changes a part of it.
    fn set_texture(&mut self, id: TextureId, delta: &ImageDelta) {
        let ImageData::Color(image) = &delta.image;
        let [width, height] = image.size.map(|n| n as u32);
        let extent = wgpu::Extent3d {
            width,
            height,
            depth_or_array_layers: 1,
        };
        if delta.pos.is_none() {
            let texture = self.gpu.device.create_texture(&wgpu::TextureDescriptor {
                label: Some("interface"),
                size: extent,
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format: wgpu::TextureFormat::Rgba8Unorm,
                usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
                view_formats: &[],
            });
            let view = texture.create_view(&Default::default());
            let resources = [
                wgpu::BindingResource::TextureView(&view),
                wgpu::BindingResource::Sampler(&self.sampler),
            ];
            let group = self.gpu.bind(&self.texture_layout, &resources);
            self.textures.insert(id, (texture, group));
        }
        let Some((texture, _)) = self.textures.get(&id) else {
            return;
        };
        let [x, y] = delta.pos.unwrap_or_default().map(|n| n as u32);
        self.gpu.queue.write_texture(
            wgpu::TexelCopyTextureInfo {
                origin: wgpu::Origin3d { x, y, z: 0 },
                ..texture.as_image_copy()
            },
            bytemuck::cast_slice(&image.pixels),
            wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(4 * width),
                rows_per_image: None,
            },
            extent,
        );
    }
}

/// The pixels of a rectangle of points: left, top, width, height; none where it has none on the screen.
fn scissor(clip: egui::Rect, screen: Screen) -> Option<[u32; 4]> {
    let pixel = |points: f32, most: u32| {
        // What is not a number is 0.
        ((points * screen.scale).round().max(0.0) as u32).min(most)
    };
    let [width, height] = screen.size;
    let (left, right) = (pixel(clip.min.x, width), pixel(clip.max.x, width));
    let (top, bottom) = (pixel(clip.min.y, height), pixel(clip.max.y, height));
    (left < right && top < bottom).then(|| [left, top, right - left, bottom - top])
}

/// A pass over what is there.
fn over<'a>(
    encoder: &'a mut wgpu::CommandEncoder,
    target: &wgpu::TextureView,
) -> wgpu::RenderPass<'a> {
    encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some("interface"),
        color_attachments: &[Some(wgpu::RenderPassColorAttachment {
            view: target,
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations {
                load: wgpu::LoadOp::Load,
                store: wgpu::StoreOp::Store,
            },
        })],
        ..Default::default()
    })
}

fn pipeline(
    device: &wgpu::Device,
    layout: &wgpu::PipelineLayout,
    format: wgpu::TextureFormat,
) -> wgpu::RenderPipeline {
    let shader = device.create_shader_module(wgpu::include_wgsl!("paint.wgsl"));
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some("interface"),
        layout: Some(layout),
        vertex: wgpu::VertexState {
            module: &shader,
            entry_point: Some("vertex"),
            compilation_options: Default::default(),
            buffers: &[Some(wgpu::VertexBufferLayout {
                array_stride: 20,
                step_mode: wgpu::VertexStepMode::Vertex,
                attributes: &wgpu::vertex_attr_array![0 => Float32x2, 1 => Float32x2, 2 => Unorm8x4],
            })],
        },
        primitive: wgpu::PrimitiveState::default(),
        depth_stencil: None,
        multisample: wgpu::MultisampleState::default(),
        fragment: Some(wgpu::FragmentState {
            module: &shader,
            entry_point: Some("fragment"),
            compilation_options: Default::default(),
            targets: &[Some(wgpu::ColorTargetState {
                format,
                blend: Some(wgpu::BlendState::PREMULTIPLIED_ALPHA_BLENDING),
                write_mask: wgpu::ColorWrites::ALL,
            })],
        }),
        multiview_mask: None,
        cache: None,
    })
}
