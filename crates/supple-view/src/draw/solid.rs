//! Solids: the ground, colliders, bodies, arrows and dots. A mesh is made once for each form, and drawn wherever it stands.

use super::gpu::Gpu;
use glam::{DMat3, DVec3};
use std::f64::consts::{PI, TAU};
use supple::collider::Shape;
use supple::model::{Frame, Surface};
use supple::wgpu;
use supple_files::{Colour, solid_surface};

/// What a solid looks like.
#[derive(Clone, Debug, PartialEq)]
pub enum Form {
    /// A collider's shape; a half-space is the ground.
    Of(Shape),
    /// An arrow a metre long, along z.
    Arrow,
    /// A ball of one metre's radius with few corners.
    Dot,
}

/// A solid that stands somewhere.
#[derive(Clone, Debug, PartialEq)]
pub struct Solid {
    /// What it looks like.
    pub form: Form,
    /// Where it stands.
    pub frame: Frame,
    /// By how much its form is stretched along its own axes.
    pub scale: DVec3,
    /// Linear red, green, blue.
    pub colour: Colour,
    /// Whether it is seen through everything, and casts no shadow.
    pub overlay: bool,
}

impl Solid {
    /// A collider's or a body's shape.
    pub fn of_shape(shape: &Shape, frame: Frame, colour: Colour) -> Self {
        Self {
            form: Form::Of(shape.clone()),
            frame,
            scale: DVec3::ONE,
            colour,
            overlay: false,
        }
    }

    /// An arrow between two places, `width` m thick.
    pub fn arrow(from: DVec3, to: DVec3, width: f64, colour: Colour) -> Self {
        let way = to - from;
        let along = way.try_normalize().unwrap_or(DVec3::Z);
        let (right, up) = along.any_orthonormal_pair();
        Self {
            form: Form::Arrow,
            frame: Frame {
                rotation: DMat3::from_cols(right, up, along),
                position: from,
            },
            scale: DVec3::new(width, width, way.length()),
            colour,
            overlay: true,
        }
    }

    /// A dot of this radius, m.
    pub fn dot(position: DVec3, radius: f64, colour: Colour) -> Self {
        Self {
            form: Form::Dot,
            frame: Frame {
                position,
                ..Frame::IDENTITY
            },
            scale: DVec3::splat(radius),
            colour,
            overlay: true,
        }
    }

    /// Rows of its matrix relative to `origin`, and its colour; that of the ground is marked by an alpha of 0.
    fn instance(&self, origin: DVec3) -> [[f32; 4]; 4] {
        let matrix = self.frame.rotation * DMat3::from_diagonal(self.scale);
        let place = self.frame.position - origin;
        let row = |k: usize| matrix.row(k).as_vec3().extend(place[k] as f32).to_array();
        let [r, g, b] = self.colour;
        let ground = self.form == Form::Of(Shape::HalfSpace);
        let alpha = if ground { 0.0 } else { 1.0 };
        [row(0), row(1), row(2), [r, g, b, alpha]]
    }
}

struct Mesh {
    form: Form,
    vertices: wgpu::Buffer,
    indices: wgpu::Buffer,
    count: u32,
}

/// The solids of a picture on the device.
#[derive(Default)]
pub struct Solids {
    meshes: Vec<Mesh>,
    /// Where instances are written; made anew where there are more than ever.
    instances: Option<wgpu::Buffer>,
    bytes: Vec<[[f32; 4]; 4]>,
    /// Mesh, first instance and number of each batch, those that are seen through everything last.
    batches: Vec<(usize, std::ops::Range<u32>, bool)>,
}

impl Solids {
    /// Writes `solids` for a picture whose places are relative to `origin`.
    pub fn set(&mut self, gpu: &Gpu, solids: &[Solid], origin: DVec3) {
        self.bytes.clear();
        self.batches.clear();
        let mut order: Vec<(bool, usize, &Solid)> = Vec::with_capacity(solids.len());
        for solid in solids {
            order.push((solid.overlay, self.mesh(gpu, &solid.form), solid));
        }
        order.sort_by_key(|(overlay, mesh, _)| (*overlay, *mesh));
        for (overlay, mesh, solid) in order {
            let at = self.bytes.len() as u32;
            self.bytes.push(solid.instance(origin));
            match self.batches.last_mut() {
                Some((of, range, over)) if *of == mesh && *over == overlay => range.end += 1,
                _ => self.batches.push((mesh, at..at + 1, overlay)),
            }
        }
        let needed = 64 * self.bytes.len() as u64;
        let room = self.instances.as_ref().map_or(0, wgpu::Buffer::size);
        if room < needed {
            let size = needed.next_power_of_two();
            self.instances = Some(gpu.buffer("solids", size, wgpu::BufferUsages::VERTEX));
        }
        if let Some(buffer) = &self.instances {
            gpu.queue
                .write_buffer(buffer, 0, bytemuck::cast_slice(&self.bytes));
        }
    }

    /// Draws them with whatever pipeline is set: those that are seen through everything, or the others.
    pub fn draw(&self, pass: &mut wgpu::RenderPass<'_>, overlays: bool) {
        let Some(instances) = &self.instances else {
            return;
        };
        pass.set_vertex_buffer(1, instances.slice(..));
        for (mesh, range, _) in self.batches.iter().filter(|b| b.2 == overlays) {
            let mesh = &self.meshes[*mesh];
            pass.set_vertex_buffer(0, mesh.vertices.slice(..));
            pass.set_index_buffer(mesh.indices.slice(..), wgpu::IndexFormat::Uint32);
            pass.draw_indexed(0..mesh.count, 0, range.clone());
        }
    }

    /// The mesh of a form, made where it is new.
    fn mesh(&mut self, gpu: &Gpu, form: &Form) -> usize {
        if let Some(at) = self.meshes.iter().position(|mesh| mesh.form == *form) {
            return at;
        }
        /// Half the side of the ground, m.
        const EXTENT: f64 = 40.0;
        let surface = match form {
            Form::Of(shape) => solid_surface(shape, EXTENT),
            Form::Arrow => {
                revolved(&[(0.0, 0.0), (0.35, 0.0), (0.35, 0.8), (1.0, 0.8), (0.0, 1.0)])
            }
            Form::Dot => {
                let ring = |k: u32| (PI * f64::from(k) / 6.0).sin_cos();
                let profile: Vec<_> = (0..=6).map(ring).map(|(r, z)| (r, -z)).collect();
                revolved(&profile)
            }
        };
        let normals = surface.vertex_normals();
        let vertices: Vec<[[f32; 3]; 2]> = (surface.positions.iter().zip(&normals))
            .map(|(p, n)| [p.as_vec3().to_array(), n.as_vec3().to_array()])
            .collect();
        let indices = surface.triangles.as_flattened();
        self.meshes.push(Mesh {
            form: form.clone(),
            vertices: gpu.filled("solid", &vertices, wgpu::BufferUsages::VERTEX),
            indices: gpu.filled("solid", indices, wgpu::BufferUsages::INDEX),
            count: indices.len() as u32,
        });
        self.meshes.len() - 1
    }
}

/// A coarse surface that a profile (radius, height) sweeps about z.
fn revolved(profile: &[(f64, f64)]) -> Surface {
    const SECTORS: u32 = 12;
    let mut surface = Surface::default();
    for (ring, (radius, height)) in (0u32..).zip(profile) {
        for k in 0..SECTORS {
            let (sin, cos) = (TAU * f64::from(k) / f64::from(SECTORS)).sin_cos();
            (surface.positions).push(DVec3::new(radius * cos, radius * sin, *height));
            if ring > 0 {
                let (b, next) = (ring * SECTORS, (k + 1) % SECTORS);
                let a = b - SECTORS;
                let corners = [[a + k, a + next, b + next], [a + k, b + next, b + k]];
                surface.triangles.extend(corners);
            }
        }
    }
    surface
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_arrow_goes_from_place_to_place() {
        let (from, to) = (DVec3::new(1.0, 2.0, 3.0), DVec3::new(0.5, 2.5, 4.0));
        let arrow = Solid::arrow(from, to, 0.01, [1.0; 3]);
        let tip = arrow.frame.transform(arrow.scale * DVec3::Z);
        assert!(tip.distance(to) < 1e-12 && arrow.frame.is_rigid());
        let relative = arrow.instance(from);
        assert_eq!([0, 1, 2].map(|k| relative[k][3]), [0.0; 3]);
    }

    #[test]
    fn a_dot_is_closed_and_round() {
        let ring = |k: u32| (PI * f64::from(k) / 6.0).sin_cos();
        let profile: Vec<_> = (0..=6).map(ring).map(|(r, z)| (r, -z)).collect();
        let volume = revolved(&profile).volume();
        assert!(
            (0.8..1.0).contains(&(volume / (4.0 / 3.0 * PI))),
            "{volume}"
        );
    }
}
