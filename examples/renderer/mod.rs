//! A small renderer of a host's own, for the example `window`.

mod app;
mod camera;
mod materials;
mod part;
mod picture;
mod pipeline;
mod posed;
mod textures;

pub use app::open_window;
pub use camera::Camera;
pub use picture::{FORMAT as PICTURE_FORMAT, write_picture};
pub use posed::{Posed, Upload};

use part::{Part, whole_skin};
use pipeline::{bind, pipeline};
use std::path::Path;
use supple::glam::{DVec3, Mat4};
use supple::model::{Avatar, RenderMesh};
use supple::wgpu;

/// Draws a character and the ground.
pub struct Renderer {
    device: wgpu::Device,
    queue: wgpu::Queue,
    format: wgpu::TextureFormat,
    skin: wgpu::RenderPipeline,
    ground: wgpu::RenderPipeline,
    view: wgpu::Buffer,
    views: [wgpu::BindGroup; 2],
    parts: Vec<Part>,
    /// Of which buffers, and where they are bound: made again only where the world has.
    bound: Option<(wgpu::Buffer, wgpu::BindGroup)>,
    /// Size, what is drawn on several times a pixel, depth.
    targets: Option<([u32; 2], [wgpu::TextureView; 2])>,
    /// Where the camera was.
    previous: Option<(Mat4, DVec3)>,
    /// Whether motion vectors are drawn in place of colours.
    pub shows_motion: bool,
}

impl Renderer {
    /// For pictures in `format` of `avatar`, painted as the glTF file at `path` is.
    pub fn new(
        (device, queue): (&wgpu::Device, &wgpu::Queue),
        format: wgpu::TextureFormat,
        avatar: &Avatar,
        path: &Path,
    ) -> Self {
        let shader = device.create_shader_module(wgpu::include_wgsl!("draw.wgsl"));
        let skin = pipeline(device, &shader, ["skin_vertex", "skin_colour"], format);
        let ground = pipeline(device, &shader, ["ground_vertex", "ground_colour"], format);
        let view = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("view"),
            size: 192,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let views =
            [&skin, &ground].map(|pipeline| bind(device, pipeline, 0, &[view.as_entire_binding()]));
        let materials = materials::read(path);
        let whole = [whole_skin(avatar)];
        let parts = match avatar.render_meshes.as_slice() {
            [] => &whole,
            parts => parts,
        };
        let material = |part: &RenderMesh| {
            let of_file = part.material_index.and_then(|m| materials.get(m as usize));
            of_file.unwrap_or(&materials::PLAIN)
        };
        let part = |part| Part::new((device, queue), &skin, part, material(part));
        Self {
            parts: parts.iter().map(part).collect(),
            device: device.clone(),
            queue: queue.clone(),
            format,
            skin,
            ground,
            view,
            views,
            bound: None,
            targets: None,
            previous: None,
            shows_motion: false,
        }
    }

    /// Draws onto `target`, after what has posed the skin on the same queue.
    pub fn draw(
        &mut self,
        posed: &Posed,
        camera: &Camera,
        target: &wgpu::TextureView,
        [width, height]: [u32; 2],
    ) {
        self.look(posed, camera, width as f32 / height as f32);
        let skins = match self.bound.take() {
            Some(bound) if bound.0 == posed.buffers[0] => bound,
            _ => (posed.buffers[0].clone(), self.bind_skins(posed)),
        };
        let targets = match self.targets.take() {
            Some(targets) if targets.0 == [width, height] => targets,
            _ => ([width, height], self.make_targets([width, height])),
        };
        let [samples, depth] = &targets.1;
        let mut encoder = self.device.create_command_encoder(&Default::default());
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: samples,
                depth_slice: None,
                resolve_target: Some(target),
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(BACKGROUND),
                    store: wgpu::StoreOp::Discard,
                },
            })],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: depth,
                depth_ops: Some(wgpu::Operations {
                    load: wgpu::LoadOp::Clear(1.0),
                    store: wgpu::StoreOp::Discard,
                }),
                stencil_ops: None,
            }),
            ..Default::default()
        });
        pass.set_pipeline(&self.ground);
        pass.set_bind_group(0, &self.views[1], &[]);
        pass.draw(0..4, 0..1);
        pass.set_pipeline(&self.skin);
        pass.set_bind_group(0, &self.views[0], &[]);
        pass.set_bind_group(1, &skins.1, &[]);
        for part in &self.parts {
            pass.set_bind_group(2, &part.bindings, &[]);
            pass.set_index_buffer(part.indices.slice(..), wgpu::IndexFormat::Uint32);
            pass.draw_indexed(0..part.count, 0, 0..1);
        }
        drop(pass);
        self.queue.submit([encoder.finish()]);
        (self.bound, self.targets) = (Some(skins), Some(targets));
    }

    /// Says where the camera is and was, and the origins as it sees them.
    fn look(&mut self, posed: &Posed, camera: &Camera, aspect: f32) {
        let now = (camera.view_projection(aspect), camera.target);
        let before = self.previous.replace(now).unwrap_or(now);
        let seen = |place: DVec3, target: DVec3, w: f32| (place - target).as_vec3().extend(w);
        let motion = f32::from(u8::from(self.shows_motion));
        let [skin, previous_skin] = posed.origins;
        let mut numbers = Vec::new();
        for matrix in [now.0, before.0] {
            numbers.extend(matrix.to_cols_array());
        }
        for vector in [
            seen(skin, now.1, motion),
            seen(previous_skin, before.1, 0.0),
            seen(DVec3::ZERO, now.1, 0.0),
            seen(DVec3::ZERO, before.1, 0.0),
        ] {
            numbers.extend(vector.to_array());
        }
        let bytes: &[u8] = bytemuck::cast_slice(&numbers);
        self.queue.write_buffer(&self.view, 0, bytes);
    }

    /// An instance's part of each buffer, as storage: it begins at a multiple of 256 bytes.
    fn bind_skins(&self, posed: &Posed) -> wgpu::BindGroup {
        let bound = posed.buffers.each_ref().map(|buffer| {
            wgpu::BindingResource::Buffer(wgpu::BufferBinding {
                buffer,
                offset: posed.range.start,
                size: std::num::NonZero::new(posed.range.end - posed.range.start),
            })
        });
        bind(&self.device, &self.skin, 1, &bound)
    }

    fn make_targets(&self, size: [u32; 2]) -> [wgpu::TextureView; 2] {
        [self.format, textures::DEPTH].map(|format| {
            let texture = textures::target(&self.device, size, format, textures::SAMPLES);
            texture.create_view(&Default::default())
        })
    }
}

const BACKGROUND: wgpu::Color = wgpu::Color {
    r: 0.55,
    g: 0.6,
    b: 0.66,
    a: 1.0,
};
