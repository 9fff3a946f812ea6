//! Drawing: a character on its ground under one sun, with what touches it. No buffer or pipeline is made in a frame whose
//! character, window and solids are those of the frame before.
//!
//! | file | what is in it |
//! |---|---|
//! | `gpu` | the device |
//! | `texture` | images with their smaller copies, and what is drawn on |
//! | `look` | how a file paints its parts |
//! | `camera` | where it is looked from |
//! | `pipelines` | all pipelines |
//! | `part`, `skin`, `solid` | what is drawn |
//! | `picture` | off screen |

mod camera;
mod gpu;
mod look;
mod part;
#[cfg(not(target_arch = "wasm32"))]
mod picture;
pub(crate) mod pipelines;
mod skin;
mod solid;
mod texture;

pub use camera::{Camera, Ray};
pub use gpu::Gpu;
pub use look::Look;
#[cfg(not(target_arch = "wasm32"))]
pub use picture::{PICTURE_FORMAT, Picture, picture};
pub use skin::Posed;
pub use solid::Solid;

use glam::{DVec3, Mat4, Vec3};
use part::Part;
use pipelines::Pipelines;
use skin::Skin;
use solid::Solids;
use supple::model::Avatar;
use supple::wgpu;
use texture::{DEPTH, SAMPLES, target};

/// Side of the texture of what the sun sees, pixels.
const SHADOW: u32 = 2048;

/// Where nothing is.
const BACKGROUND: wgpu::Color = wgpu::Color {
    r: 0.55,
    g: 0.6,
    b: 0.66,
    a: 1.0,
};

/// A character's constant parts and its skin on the device.
pub struct Drawn {
    parts: Vec<Part>,
    /// Its skin.
    pub skin: Skin,
}

/// What a picture shows besides a character.
#[derive(Clone, Copy, Debug)]
pub struct Sight<'a> {
    /// From where.
    pub camera: &'a Camera,
    /// What else stands there.
    pub solids: &'a [Solid],
    /// The size of what is looked at, m: shadows fall within twice that.
    pub extent: f64,
    /// Part of the skin's own colour that is kept where values are shown on it.
    pub own_colour: f32,
}

/// Draws characters and solids.
pub struct Renderer {
    gpu: Gpu,
    format: wgpu::TextureFormat,
    pipelines: Pipelines,
    view: wgpu::Buffer,
    shadow: wgpu::TextureView,
    /// The view alone, and with the shadows.
    groups: [wgpu::BindGroup; 2],
    solids: Solids,
    /// Size, what is drawn on several times a pixel, depths.
    targets: Option<([u32; 2], [wgpu::TextureView; 2])>,
}

impl Renderer {
    /// For pictures in `format`.
    pub fn new(gpu: &Gpu, format: wgpu::TextureFormat) -> Self {
        let pipelines = Pipelines::new(gpu, format);
        let view = gpu.buffer("view", 224, wgpu::BufferUsages::UNIFORM);
        let usage = wgpu::TextureUsages::TEXTURE_BINDING;
        let shadow = target(gpu, [SHADOW; 2], DEPTH, 1, usage).create_view(&Default::default());
        let sampler = gpu.device.create_sampler(&wgpu::SamplerDescriptor {
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            compare: Some(wgpu::CompareFunction::LessEqual),
            ..Default::default()
        });
        let frame = [
            view.as_entire_binding(),
            wgpu::BindingResource::TextureView(&shadow),
            wgpu::BindingResource::Sampler(&sampler),
        ];
        let groups = [
            gpu.bind(&pipelines.view_layout, &frame[..1]),
            gpu.bind(&pipelines.frame_layout, &frame),
        ];
        Self {
            gpu: gpu.clone(),
            format,
            pipelines,
            view,
            groups,
            shadow,
            solids: Solids::default(),
            targets: None,
        }
    }

    /// The device.
    pub fn gpu(&self) -> &Gpu {
        &self.gpu
    }

    /// Brings a character onto the device.
    pub fn character(&self, avatar: &Avatar, look: &Look) -> Drawn {
        Drawn {
            parts: Part::all(&self.gpu, &self.pipelines, avatar, look),
            skin: Skin::new(&self.gpu, avatar.skin.len()),
        }
    }

    /// Records a picture of `sight` and a character, if there is one, into the part of `target` that begins at the left
    /// above and is `size` large.
    pub fn draw(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        character: Option<(&mut Drawn, &Posed)>,
        sight: &Sight<'_>,
        target: &wgpu::TextureView,
        [size, whole]: [[u32; 2]; 2],
    ) {
        let skin_origin = character
            .as_ref()
            .map_or(DVec3::ZERO, |(_, posed)| posed.origin);
        self.look(sight, skin_origin, f64::from(size[0]) / f64::from(size[1]));
        (self.solids).set(&self.gpu, sight.solids, sight.camera.target);
        let targets = match self.targets.take() {
            Some(targets) if targets.0 == whole => targets,
            _ => (whole, self.make_targets(whole)),
        };
        let bound = character.map(|(drawn, posed)| {
            let group = drawn.skin.bind(&self.gpu, &self.pipelines, posed);
            (&*drawn, group)
        });
        let pipelines = &self.pipelines;
        let draw_skin = |pass: &mut wgpu::RenderPass<'_>, pipeline| {
            if let Some((drawn, group)) = &bound {
                pass.set_pipeline(pipeline);
                pass.set_bind_group(1, group, &[]);
                drawn.parts.iter().for_each(|part| part.draw(pass));
            }
        };
        {
            let pass = &mut pass(encoder, None, &self.shadow);
            pass.set_bind_group(0, &self.groups[0], &[]);
            draw_skin(pass, &pipelines.skin_shadow);
            pass.set_pipeline(&pipelines.solid_shadow);
            self.solids.draw(pass, false);
        }
        let [samples, depth] = &targets.1;
        {
            let pass = &mut pass(encoder, Some((samples, target)), depth);
            pass.set_viewport(0.0, 0.0, size[0] as f32, size[1] as f32, 0.0, 1.0);
            pass.set_bind_group(0, &self.groups[1], &[]);
            pass.set_pipeline(&pipelines.solid);
            self.solids.draw(pass, false);
            draw_skin(pass, &pipelines.skin);
            pass.set_pipeline(&pipelines.overlay);
            self.solids.draw(pass, true);
        }
        self.targets = Some(targets);
    }

    /// Says where the camera and the sun are.
    fn look(&mut self, sight: &Sight<'_>, skin_origin: DVec3, aspect: f64) {
        let camera = sight.camera;
        let up = camera.up.direction();
        let relative = |place: DVec3| (place - camera.target).as_vec3();
        let standing = supple::model::UpAxis::Z.rotation_to(camera.up);
        let sun = (standing * DVec3::new(-0.35, -0.5, 0.8).normalize()).as_vec3();
        let reach = 2.0 * sight.extent.max(0.1) as f32;
        let mut numbers = Vec::with_capacity(56);
        numbers.extend(camera.view_projection(aspect).to_cols_array());
        numbers.extend(sun_projection(sun, up.as_vec3(), reach).to_cols_array());
        let horizon = (6.0 * camera.distance + 4.0 * sight.extent) as f32;
        for (vector, last) in [
            (relative(camera.eye()), sight.own_colour),
            (sun, horizon),
            (up.as_vec3(), square(sight.extent) as f32),
            (relative(skin_origin), 0.0),
            (relative(DVec3::ZERO), 0.0),
        ] {
            numbers.extend(vector.extend(last).to_array());
        }
        let bytes: &[u8] = bytemuck::cast_slice(&numbers);
        self.gpu.queue.write_buffer(&self.view, 0, bytes);
    }

    fn make_targets(&self, size: [u32; 2]) -> [wgpu::TextureView; 2] {
        [self.format, DEPTH].map(|format| {
            let texture = target(
                &self.gpu,
                size,
                format,
                SAMPLES,
                wgpu::TextureUsages::empty(),
            );
            texture.create_view(&Default::default())
        })
    }
}

/// Side of the ground's squares under something of this size, m: a power of ten.
fn square(extent: f64) -> f64 {
    10f64.powf((0.3 * extent).log10().round())
}

/// From places relative to the target to the sun's picture of them, `reach` m to each side.
fn sun_projection(sun: Vec3, up: Vec3, reach: f32) -> Mat4 {
    let right = up.cross(sun).normalize();
    let axes = glam::Mat3::from_cols(right, sun.cross(right), sun).transpose();
    // Depth 0 is twice as far towards the sun as it reaches aside, 1 as far away from it.
    let squeeze = Mat4::from_scale(Vec3::new(1.0 / reach, 1.0 / reach, -0.25 / reach));
    Mat4::from_translation(Vec3::new(0.0, 0.0, 0.5)) * squeeze * Mat4::from_mat3(axes)
}

/// A pass that begins with nothing: of colours, drawn several times a pixel and resolved, and depths, or of depths alone.
fn pass<'a>(
    encoder: &'a mut wgpu::CommandEncoder,
    colours: Option<(&wgpu::TextureView, &wgpu::TextureView)>,
    depths: &wgpu::TextureView,
) -> wgpu::RenderPass<'a> {
    let colours = colours.map(|(samples, target)| wgpu::RenderPassColorAttachment {
        view: samples,
        depth_slice: None,
        resolve_target: Some(target),
        ops: wgpu::Operations {
            load: wgpu::LoadOp::Clear(BACKGROUND),
            store: wgpu::StoreOp::Discard,
        },
    });
    let kept = match &colours {
        Some(_) => wgpu::StoreOp::Discard,
        None => wgpu::StoreOp::Store,
    };
    let attachments = [colours];
    encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: None,
        color_attachments: match attachments[0] {
            Some(_) => &attachments,
            None => &[],
        },
        depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
            view: depths,
            depth_ops: Some(wgpu::Operations {
                load: wgpu::LoadOp::Clear(1.0),
                store: kept,
            }),
            stencil_ops: None,
        }),
        ..Default::default()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sun_sees_what_is_within_reach_and_what_is_nearer_to_it_first() {
        let sun = Vec3::new(0.3, -0.5, 0.8).normalize();
        let project = sun_projection(sun, Vec3::Z, 2.0);
        let near = project.transform_point3(0.5 * sun);
        let far = project.transform_point3(-0.5 * sun);
        assert!(near.z < far.z && near.z > 0.0 && far.z < 1.0);
        assert!(near.truncate().length() < 1e-6);
        let aside = sun.any_orthonormal_vector();
        let edge = project.transform_point3(1.99 * aside).truncate();
        assert!((edge.length() - 0.995).abs() < 1e-5, "{edge}");
    }
}
