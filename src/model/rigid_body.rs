//! Rigid bodies in an avatar's system: bones without tissue.

use super::{
    Avatar, BasisEntry, BoneMass, Frame, JointList, PointSet, Skeleton, SkinWeight, SoftLayer,
    Surface, UpAxis,
};
use crate::collider::{Collider, Shape};
use crate::material::{Material, StableNeoHookean};
use crate::math::Rows;
use crate::{Error, Result};
use glam::DVec3;
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// A ball, a box or any other solid that moves with an avatar in one Newton system.
///
/// It is a root frame with a mass. Its surface vertices are skin vertices without handles, so that it
/// rests on kinematic colliders and is pushed by them as the skin is; the avatar's skin meets it as a
/// collider that its frame carries ([`RigidBody::collider`]).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RigidBody {
    /// Unlike every bone's name.
    pub name: String,
    /// The solid, in the body's own frame.
    pub shape: Shape,
    /// Its second moments about the frame's origin.
    pub mass: BoneMass,
    /// Its closed surface in the body's own frame, evenly sampled: each vertex touches with a third of
    /// the area around it.
    pub surface: Surface,
    /// Where it is at first.
    pub initial_frame: Frame,
    /// Penalty stiffness of what touches it, Pa/m; none where it is that of the tissue that it touches.
    pub stiffness: Option<f64>,
    /// Coefficient of friction of what touches it.
    pub friction: f64,
}

/// Vertices of a body's surface, about.
const VERTICES: usize = 300;

impl RigidBody {
    /// A solid of even `density` (kg/m³) at the origin.
    ///
    /// # Errors
    /// [`Error::Invalid`] of sizes or a density that are none, and of a solid without bounds.
    pub fn new(name: impl Into<String>, shape: Shape, density: f64) -> Result<Self> {
        shape.validate().map_err(|e| e.within("shape"))?;
        if !(density > 0.0 && density.is_finite()) {
            let problem = format!("{density}; must be positive (kg/m³)");
            return Err(Error::invalid("density", problem));
        }
        let like = Collider::new(shape.clone(), Frame::IDENTITY);
        Ok(Self {
            name: name.into(),
            mass: shape.mass(density)?,
            surface: shape.sampled(VERTICES)?,
            initial_frame: Frame::IDENTITY,
            stiffness: like.stiffness,
            friction: like.friction,
            shape,
        })
    }

    /// The same body, as dense as makes it weigh `mass`, kg.
    pub fn of_mass(self, mass: f64) -> Self {
        Self {
            mass: self.mass.scaled(mass / self.mass.mass()),
            ..self
        }
    }

    /// The same body that starts at `initial_frame`.
    pub fn at(self, initial_frame: Frame) -> Self {
        Self {
            initial_frame,
            ..self
        }
    }

    /// What the avatar's skin touches of it, carried by frame `body` of the system.
    pub fn collider(&self, body: usize) -> Collider {
        Collider {
            stiffness: self.stiffness,
            friction: self.friction,
            body: Some(body as u32),
            ..Collider::new(self.shape.clone(), Frame::IDENTITY)
        }
    }
}

impl Avatar {
    /// The avatar with `bodies` in its system; see [`Avatar::add_body`].
    ///
    /// # Errors
    /// As [`Avatar::add_body`].
    pub fn with_bodies(mut self, bodies: impl IntoIterator<Item = RigidBody>) -> Result<Self> {
        bodies.into_iter().try_for_each(|b| self.add_body(b))?;
        Ok(self)
    }

    /// Adds a body to the avatar's system, after those that it has. Bones, tissue and drawn parts keep
    /// their places: the body's root frame, its surface's vertices and its triangles come at the end.
    ///
    /// # Errors
    /// [`Error::Invalid`] of a body whose name is taken or whose numbers are unusable; nothing is added then.
    pub fn add_body(&mut self, body: RigidBody) -> Result<()> {
        let frame = self.skeleton.len();
        let field = |key: &str| format!("bodies.{}{key}", body.name);
        if self.skeleton.find(&body.name).is_some() {
            return Err(Error::invalid(field(""), "a bone or body has that name"));
        }
        if !(body.initial_frame.position.is_finite() && body.initial_frame.rotation.is_finite()) {
            return Err(Error::invalid(field(".initial_frame"), "is not finite"));
        }
        if !(body.mass.mass() > 0.0 && body.mass.mass().is_finite()) {
            return Err(Error::invalid(field(".mass"), "must be positive (kg)"));
        }
        (body.collider(frame).validate()).map_err(|e| e.within(&field("")))?;
        self.skeleton.names.push(body.name.clone());
        self.skeleton.parents.push(None);
        self.skeleton.joints.push(body.initial_frame.position);
        self.bone_masses.push(body.mass);
        let first = self.skin.len() as u32;
        let shifted = |t: &[u32; 3]| t.map(|v| first + v);
        self.triangles
            .extend(body.surface.triangles.iter().map(shifted));
        self.skin
            .append_rigid(&body.surface, frame as u32, body.initial_frame.position);
        if !self.contact_stiffness.is_empty() {
            let vertices = self.skin.len();
            self.contact_stiffness.resize(vertices, Collider::STIFFEST);
        }
        self.bodies.push(body);
        Ok(())
    }

    /// The avatar with `count` further root frames, which stand for bodies that others move: they have no mass, and
    /// nothing but colliders that they carry. A world gives them the places of the bodies that the avatar touches.
    ///
    /// # Errors
    /// [`Error::Invalid`] of an avatar that has bodies of its own.
    pub fn with_body_slots(mut self, count: usize) -> Result<Self> {
        if !self.bodies.is_empty() || self.body_slots > 0 {
            let problem = "the avatar has bodies of its own; hand it in without them";
            return Err(Error::invalid("bodies", problem));
        }
        for i in 0..count {
            self.skeleton.names.push(format!("body slot {i}"));
            self.skeleton.parents.push(None);
            self.skeleton.joints.push(DVec3::ZERO);
        }
        self.body_slots = count;
        Ok(self)
    }

    /// Number of the character's own bones: frames before those of the bodies.
    pub fn bones(&self) -> usize {
        (self.skeleton.len()).saturating_sub(self.bodies.len() + self.body_slots)
    }

    /// The character's own bones, without the bodies.
    pub fn character(&self) -> Skeleton {
        self.skeleton.first(self.bones())
    }

    /// Frame of body `i`.
    pub fn body_frame(&self, i: usize) -> usize {
        self.bones() + i
    }

    /// Skin vertices of body `i`; one beyond the last where there is no such body.
    pub fn body_vertices(&self, i: usize) -> Range<usize> {
        let count = |b: &RigidBody| b.surface.positions.len();
        let after: usize = self.bodies.iter().skip(i).map(count).sum();
        let start = self.skin.len().saturating_sub(after);
        start..start + self.bodies.get(i).map_or(0, count)
    }

    /// Triangles of the tissue's skin, those of the bodies left out.
    pub fn skin_triangles(&self) -> &[[u32; 3]] {
        let of_bodies: usize = (self.bodies.iter().map(|b| b.surface.triangles.len())).sum();
        &self.triangles[..self.triangles.len().saturating_sub(of_bodies)]
    }

    /// Colliders of all bodies, each carried by its frame.
    pub fn body_colliders(&self) -> impl Iterator<Item = Collider> {
        (self.bodies.iter().enumerate()).map(|(i, body)| body.collider(self.body_frame(i)))
    }

    /// Checks that every body has its frame, its vertices and its triangles.
    pub(super) fn validate_bodies(&self) -> Result<()> {
        for (i, body) in self.bodies.iter().enumerate() {
            let (frame, vertices) = (self.body_frame(i), self.body_vertices(i));
            let of_body =
                |v: usize| matches!(self.skin.skinning.row(v), [w] if w.bone as usize == frame);
            let sound = self.bodies.len() < self.skeleton.len()
                && self.skeleton.parents[frame].is_none()
                && vertices.clone().all(of_body)
                && vertices.end <= self.skin.len()
                && body.initial_frame.position.is_finite()
                && body.initial_frame.rotation.is_finite();
            if !sound {
                let problem =
                    "has not its own root frame and surface; add it by Avatar::with_bodies";
                return Err(Error::invalid(format!("bodies.{}", body.name), problem));
            }
            let of_body = |e: Error| e.within(&format!("bodies.{}", body.name));
            body.collider(frame).validate().map_err(of_body)?;
        }
        Ok(())
    }
}

impl RigidBody {
    /// The body as an avatar of one bone, which has no tissue: what a world steps it as.
    pub(crate) fn alone(&self) -> Avatar {
        let mut skin = PointSet::default();
        skin.append_rigid(&self.surface, 0, DVec3::ZERO);
        let skeleton = Skeleton {
            names: vec![self.name.clone()],
            parents: vec![None],
            joints: vec![DVec3::ZERO],
            aliases: Vec::new(),
            limits: Vec::new(),
        };
        Avatar {
            name: self.name.clone(),
            joints: JointList::of_bones(&skeleton),
            up: UpAxis::default(),
            skeleton,
            bone_masses: vec![self.mass],
            springs: Default::default(),
            handles: Vec::new(),
            cubature: PointSet::default(),
            skin,
            triangles: self.surface.triangles.clone(),
            contact_stiffness: Vec::new(),
            attached: Rows::default(),
            pose_extension: Rows::default(),
            render_meshes: Vec::new(),
            appearance: Default::default(),
            material: Material::StableNeoHookean(StableNeoHookean {
                youngs_modulus: 1.0,
                poissons_ratio: 0.0,
            }),
            tissue: Vec::new(),
            density: 1.0,
            captured_under_gravity: false,
            fine: Default::default(),
            layer: SoftLayer::default(),
            bodies: Vec::new(),
            body_slots: 0,
        }
    }
}

impl PointSet {
    /// Adds the vertices of a `surface` that bone `frame` carries, whose joint is at `joint`.
    fn append_rigid(&mut self, surface: &Surface, frame: u32, joint: DVec3) {
        let (before, added) = (self.len(), surface.positions.len());
        let blend = &mut self.pose_blend;
        if blend.features > 0 {
            let columns = std::mem::take(&mut blend.columns);
            for column in columns.chunks_exact(before.max(1)) {
                blend.columns.extend(column);
                blend.columns.extend(std::iter::repeat_n([0.0; 3], added));
            }
        }
        self.position
            .extend(surface.positions.iter().map(|p| joint + *p));
        self.measure.extend(surface.vertex_areas());
        for _ in 0..added {
            self.skinning.push([SkinWeight {
                bone: frame,
                weight: 1.0,
            }]);
            self.basis.push(std::iter::empty::<BasisEntry>());
        }
    }
}
