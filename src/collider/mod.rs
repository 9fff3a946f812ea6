//! What an avatar touches: one file a shape with its signed distance and outward normal in f64, and
//! the name of its kernel.

mod r#box;
mod capsule;
mod cylinder;
mod half_space;
mod mass;
pub(crate) mod mesh;
mod sampled;
mod sphere;

#[cfg(feature = "gpu")]
pub(crate) use mesh::MESH_NODES;
pub use mesh::{DistanceGrid, MeshShape};

use crate::model::{Frame, UpAxis};
use crate::{Error, Result};
use glam::{DMat3, DVec3};
use serde::{Deserialize, Serialize};

/// The shape of a collider, in its own frame, m. A new shape is one file, its kernel, and its lines here.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Shape {
    /// The solid below the plane z = 0.
    HalfSpace,
    /// A ball about the origin.
    Sphere {
        /// Radius.
        radius: f64,
    },
    /// A ball swept along z from −half_length to half_length.
    Capsule {
        /// Radius.
        radius: f64,
        /// Half the length of the axis, without the caps.
        half_length: f64,
    },
    /// A flat-ended cylinder along z.
    Cylinder {
        /// Radius.
        radius: f64,
        /// Half the height.
        half_length: f64,
    },
    /// A box about the origin.
    Box {
        /// Half the extents along x, y, z.
        half_extents: [f64; 3],
    },
    /// What is inside a closed triangle mesh.
    Mesh(MeshShape),
}

/// Where a point stands to a solid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SignedDistance {
    /// d, m: negative inside.
    pub distance: f64,
    /// ∇d, exactly: the outward unit normal, but of a mesh, whose d is interpolated, unit up to its grid's error. Where d
    /// has a crease (an axis, a medial plane) one side's is taken.
    pub normal: DVec3,
}

impl Shape {
    /// One of each shape, in the order of [`Shape::index`]: what loops over all shapes loops over.
    pub fn examples() -> Vec<Self> {
        vec![
            Self::HalfSpace,
            Self::Sphere { radius: 0.03 },
            Self::Capsule {
                radius: 0.01,
                half_length: 0.03,
            },
            Self::Cylinder {
                radius: 0.008,
                half_length: 0.05,
            },
            Self::Box {
                half_extents: [0.02, 0.03, 0.01],
            },
            Self::Mesh(MeshShape::example()),
        ]
    }

    /// Files of the kernels under `kernels/`, in the order of [`Shape::index`].
    pub const KERNELS: [&'static str; 6] = [
        "collider/half_space.wgsl",
        "collider/sphere.wgsl",
        "collider/capsule.wgsl",
        "collider/cylinder.wgsl",
        "collider/box.wgsl",
        "collider/mesh.wgsl",
    ];

    /// Number of the shape, by which the kernel switches.
    pub fn index(&self) -> u32 {
        match self {
            Self::HalfSpace => 0,
            Self::Sphere { .. } => 1,
            Self::Capsule { .. } => 2,
            Self::Cylinder { .. } => 3,
            Self::Box { .. } => 4,
            Self::Mesh(_) => 5,
        }
    }

    /// Its sizes as the kernel reads them; of a mesh the slot of its grid is left open.
    pub fn parameters(&self) -> [f32; 4] {
        match *self {
            Self::HalfSpace => [0.0; 4],
            Self::Mesh(ref mesh) => mesh.grid().spacing().as_vec3().extend(0.0).to_array(),
            Self::Sphere { radius } => [radius as f32, 0.0, 0.0, 0.0],
            Self::Capsule {
                radius,
                half_length,
            }
            | Self::Cylinder {
                radius,
                half_length,
            } => [radius as f32, half_length as f32, 0.0, 0.0],
            Self::Box {
                half_extents: [x, y, z],
            } => [x as f32, y as f32, z as f32, 0.0],
        }
    }

    /// File of the kernel under `kernels/`.
    pub fn kernel(&self) -> &'static str {
        Self::KERNELS[self.index() as usize]
    }

    /// Distance and normal at `point` of the shape's own frame.
    pub fn signed_distance(&self, point: DVec3) -> SignedDistance {
        match *self {
            Self::HalfSpace => half_space::signed_distance(point),
            Self::Sphere { radius } => sphere::signed_distance(radius, point),
            Self::Capsule {
                radius,
                half_length,
            } => capsule::signed_distance(radius, half_length, point),
            Self::Cylinder {
                radius,
                half_length,
            } => cylinder::signed_distance(radius, half_length, point),
            Self::Box { half_extents } => {
                r#box::signed_distance(DVec3::from_array(half_extents), point)
            }
            Self::Mesh(ref mesh) => mesh.grid().signed_distance(point),
        }
    }

    /// ∇²d at `point` of the shape's own frame, 1/m; 0 where it is singular.
    pub fn curvature(&self, point: DVec3) -> DMat3 {
        match *self {
            Self::HalfSpace => DMat3::ZERO,
            Self::Sphere { .. } => sphere::curvature(point),
            Self::Capsule { half_length, .. } => capsule::curvature(half_length, point),
            Self::Cylinder {
                radius,
                half_length,
            } => cylinder::curvature(radius, half_length, point),
            Self::Box { half_extents } => r#box::curvature(DVec3::from_array(half_extents), point),
            Self::Mesh(ref mesh) => mesh.grid().curvature(point),
        }
    }

    /// Checks the sizes.
    pub fn validate(&self) -> Result<()> {
        let sizes: &[(&str, f64)] = match self {
            // A mesh was checked when it was made.
            Self::HalfSpace | Self::Mesh(_) => &[],
            Self::Sphere { radius } => &[("radius", *radius)],
            Self::Capsule {
                radius,
                half_length,
            }
            | Self::Cylinder {
                radius,
                half_length,
            } => &[("radius", *radius), ("half_length", *half_length)],
            Self::Box {
                half_extents: [x, y, z],
            } => &[
                ("half_extents[0]", *x),
                ("half_extents[1]", *y),
                ("half_extents[2]", *z),
            ],
        };
        for (field, size) in sizes {
            positive(field, *size, "m")?;
        }
        Ok(())
    }
}

/// A rigid solid that the skin cannot enter: kinematic, or fixed to a frame of the system.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Collider {
    /// Its shape.
    pub shape: Shape,
    /// Where it is at the end of the step; with a body, where it is in that frame (a point x of the
    /// collider is at R (frame x) + c).
    pub frame: Frame,
    /// Where it was at the start of the step; not read where there is a body.
    pub previous: Frame,
    /// Penalty stiffness k, Pa/m; none where it is that of the tissue that it touches
    /// ([`Avatar::contact_stiffness`](crate::model::Avatar::contact_stiffness)).
    #[serde(with = "stated")]
    pub stiffness: Option<f64>,
    /// d̂: distance at which contact begins, m.
    pub margin: f64,
    /// Coefficient of friction μ; 0 slides freely.
    pub friction: f64,
    /// The frame of the system that it is fixed to, and pushes: none where its motion is given.
    pub body: Option<u32>,
}

impl Collider {
    /// Above it μ is taken for a mistake.
    pub const MOST_FRICTION: f64 = 10.0;

    /// The stiffest penalty that nobody asked for, Pa/m: of skin without tissue, and of tissue that is stiffer or thinner.
    pub const STIFFEST: f64 = 1e8;

    /// A collider that stands still: k is the tissue's, else [`Collider::STIFFEST`], no margin, no friction, no body.
    pub fn new(shape: Shape, frame: Frame) -> Self {
        Self {
            shape,
            frame,
            previous: frame,
            stiffness: None,
            margin: 0.0,
            friction: 0.0,
            body: None,
        }
    }

    /// Everything below height zero of a world in which `up` points up.
    pub fn ground(up: UpAxis) -> Self {
        let frame = Frame {
            rotation: UpAxis::Z.rotation_to(up),
            position: DVec3::ZERO,
        };
        Self::new(Shape::HalfSpace, frame)
    }

    /// Where it stands at the end of the step, the system's frames being `frames`.
    pub fn world_frame(&self, frames: &[Frame]) -> Frame {
        match self.body {
            None => self.frame,
            Some(body) => frames[body as usize].compose(&self.frame),
        }
    }

    /// Where it stood at the start of the step, the system's frames being `frames` then.
    pub fn previous_world_frame(&self, frames: &[Frame]) -> Frame {
        match self.body {
            None => self.previous,
            Some(_) => self.world_frame(frames),
        }
    }

    /// Distance and normal at a world point, the collider standing at `frame`.
    pub fn signed_distance(&self, frame: &Frame, point: DVec3) -> SignedDistance {
        let local = self.shape.signed_distance(frame.inverse_transform(point));
        SignedDistance {
            distance: local.distance,
            normal: frame.rotation * local.normal,
        }
    }

    /// ∇²d at a world point, 1/m, the collider standing at `frame`.
    pub fn curvature(&self, frame: &Frame, point: DVec3) -> DMat3 {
        let r = frame.rotation;
        r * self.shape.curvature(frame.inverse_transform(point)) * r.transpose()
    }

    /// k, Pa/m, where it meets tissue that would have `tissue` of itself.
    pub(crate) fn stiffness_on(&self, tissue: f64) -> f64 {
        self.stiffness.unwrap_or(tissue.min(Self::STIFFEST))
    }

    /// The collider seen from `origin`: both frames shifted by −origin, unless they are its body's.
    pub fn relative_to(&self, origin: DVec3) -> Self {
        let shift = if self.body.is_none() {
            origin
        } else {
            DVec3::ZERO
        };
        let shifted = |frame: Frame| Frame {
            position: frame.position - shift,
            ..frame
        };
        Self {
            frame: shifted(self.frame),
            previous: shifted(self.previous),
            ..self.clone()
        }
    }

    /// Checks sizes, frames, stiffness, margin and friction; whether there is such a body, the potential checks. As every
    /// `validate` of a value that others hold, it names the field as seen from the value.
    pub fn validate(&self) -> Result<()> {
        self.shape.validate().map_err(|e| e.within("shape"))?;
        for (field, frame) in [("frame", self.frame), ("previous", self.previous)] {
            let r = frame.rotation;
            let skewness = (r.transpose() * r - DMat3::IDENTITY).to_cols_array();
            let is_rotation =
                skewness.iter().all(|s| s.abs() < 1e-6) && (r.determinant() - 1.0).abs() < 1e-6;
            if !(is_rotation && frame.position.is_finite()) {
                return Err(Error::invalid(field, "is not a finite rigid placement"));
            }
        }
        if let Some(stiffness) = self.stiffness {
            positive("stiffness", stiffness, "Pa/m")?;
        }
        if !(self.margin >= 0.0 && self.margin.is_finite()) {
            return Err(Error::invalid(
                "margin",
                format!("{}; must be zero or positive (m)", self.margin),
            ));
        }
        if !(0.0..=Self::MOST_FRICTION).contains(&self.friction) {
            return Err(Error::invalid(
                "friction",
                format!("{}; must be 0 to {}", self.friction, Self::MOST_FRICTION),
            ));
        }
        Ok(())
    }
}

/// How the stiffness is written: 0 where it is the tissue's.
mod stated {
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    pub fn serialize<S: Serializer>(stiffness: &Option<f64>, to: S) -> Result<S::Ok, S::Error> {
        stiffness.unwrap_or(0.0).serialize(to)
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Option<f64>, D::Error> {
        let stiffness = f64::deserialize(from)?;
        Ok((stiffness != 0.0).then_some(stiffness))
    }
}

fn positive(field: &str, value: f64, unit: &str) -> Result<()> {
    if value > 0.0 && value.is_finite() {
        return Ok(());
    }
    Err(Error::invalid(
        field,
        format!("{value}; must be positive ({unit})"),
    ))
}

/// Length and direction of `v`, without overflow or underflow; along `fallback` where v = 0.
fn length_and_direction(v: DVec3, fallback: DVec3) -> (f64, DVec3) {
    let scale = v.abs().max_element();
    if scale < f64::MIN_POSITIVE {
        return (0.0, fallback);
    }
    let scaled = v / scale;
    let length = scaled.length();
    (scale * length, scaled / length)
}

/// (I − n nᵀ)/r: how the normal n turns on a ball of radius r; 0 at its centre.
fn ball_curvature(normal: DVec3, radius: f64) -> DMat3 {
    if radius <= 0.0 {
        return DMat3::ZERO;
    }
    let outer = DMat3::from_cols(normal * normal.x, normal * normal.y, normal * normal.z);
    (DMat3::IDENTITY - outer) * radius.recip()
}

#[cfg(test)]
mod tests;
