//! The baked avatar: everything that stays constant while it is simulated.

use super::{
    Appearance, BoneMass, FineHandles, JointList, PointSet, RigidBody, Skeleton, SkinWeight, Space,
    SpringBones, State, TetMesh, UpAxis,
};
use crate::material::{LocalTissue, Material, MaterialPoint};
use crate::math::Rows;
use crate::model::RenderMesh;
use crate::{Error, Result};
use glam::DVec3;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// The volume between bones and skin, kept for the full-space solve and for reports.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SoftLayer {
    /// The mesh, in the reference shape.
    pub mesh: TetMesh,
    /// The part of each tet that is tissue, in (0, 1]: lattice tets are cut by skin and bones.
    pub tissue_fraction: Vec<f64>,
    /// The bone that holds each node, if one does: U is 0 there.
    pub bone_of_node: Vec<Option<u32>>,
    /// Bones of each node.
    pub skinning: Rows<SkinWeight>,
    /// Handles (index, U) of each node, truncated as at the points.
    pub basis: Rows<(u32, f64)>,
    /// Nodes (index, share) of each skin vertex; one node where the mesh meets the skin.
    pub skin_embedding: Rows<(u32, f64)>,
    /// What the material has of its own in each tet; none where it is [`LocalTissue::default`] everywhere.
    pub tissue: Vec<LocalTissue>,
}

impl SoftLayer {
    /// Whether there is none: the avatar was written with what a step reads and no more.
    pub fn is_empty(&self) -> bool {
        self.mesh.nodes.is_empty()
    }
}

/// A baked avatar, constant while it is simulated. What changes is [`State`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Avatar {
    /// What it is called in reports.
    pub name: String,
    /// Bones.
    pub skeleton: Skeleton,
    /// What the character's file calls its nodes, and which bone goes with each.
    pub joints: JointList,
    /// The axis that points up in the reference shape.
    pub up: UpAxis,
    /// Mass of each bone; [`BoneMass::NONE`] of one that is carried ([`Avatar::is_carried`]).
    pub bone_masses: Vec<BoneMass>,
    /// Carried bones that swing.
    pub springs: SpringBones,
    /// Rest position of each handle, m.
    pub handles: Vec<DVec3>,
    /// Tissue points that carry inertia and elasticity; `measure` is the cubature weight, m³.
    pub cubature: PointSet,
    /// Skin vertices that are drawn and touch; `measure` is the area, m².
    pub skin: PointSet,
    /// Triangles of the skin, those of the bodies last.
    pub triangles: Vec<[u32; 3]>,
    /// Penalty stiffness k of each skin vertex where a collider states none, Pa/m: 100 E/L of tissue with Young's modulus E
    /// and depth L, so that half its compression costs 0.5 % of L; at most [`Collider::STIFFEST`](crate::collider::Collider::STIFFEST) is taken. None at all: that.
    pub contact_stiffness: Vec<f64>,
    /// Skin vertices that are not tissue's but attached to it and come after it: skin vertices (index,
    /// share) that each of them follows. They have no area.
    pub attached: Rows<(u32, f64)>,
    /// E: skin vertices (index, share) whose [`PoseOffsets`](super::PoseOffsets) each cubature point follows; no row at
    /// all where it was not baked.
    pub pose_extension: Rows<(u32, f32)>,
    /// How the body's file draws the skin; none where it is drawn as it is.
    pub render_meshes: Vec<RenderMesh>,
    /// Materials and images of the body's file, which `render_meshes` name; in a section of their own
    /// ([`crate::file`]).
    #[serde(skip)]
    pub appearance: Arc<Appearance>,
    /// What the tissue is made of.
    pub material: Material,
    /// What the material has of its own at each cubature point: stiffness, axes, damping, muscle. None where it is
    /// [`LocalTissue::default`] everywhere, which damps nothing.
    pub tissue: Vec<LocalTissue>,
    /// Density of the tissue, kg/m³.
    pub density: f64,
    /// Whether the rest shape already sags under gravity (a captured shape does); then the tissue's
    /// weight loads the bones and not the handles.
    pub captured_under_gravity: bool,
    /// Handles that sleep beside `handles`, in sections of their own of a file ([`crate::file`]).
    #[serde(skip)]
    pub fine: Arc<FineHandles>,
    /// The mesh behind the cubature; empty where the file was written without it.
    pub layer: SoftLayer,
    /// Rigid bodies in the same system ([`Avatar::with_bodies`]): the last frames, skin vertices and
    /// triangles are theirs. They are no part of a baked file.
    #[serde(skip)]
    pub bodies: Vec<RigidBody>,
    /// Frames at the end that stand for bodies of a world ([`Avatar::with_body_slots`]): they have no mass of their own.
    #[serde(skip)]
    pub body_slots: usize,
}

impl Avatar {
    /// The numbering of the DoFs.
    pub fn space(&self) -> Space {
        Space {
            frames: self.skeleton.len(),
            handles: self.handles.len(),
        }
    }

    /// The bind pose with no displacement, bodies standing in their places.
    pub fn rest_state(&self) -> State {
        let mut frames = self.skeleton.bind_pose();
        let first = self.bones();
        (frames[first..].iter_mut().zip(&self.bodies))
            .for_each(|(f, body)| *f = body.initial_frame);
        State {
            frames,
            handles: vec![DVec3::ZERO; self.handles.len()],
            awake: Vec::with_capacity(self.fine.slots),
        }
    }

    /// The material at cubature point `i`.
    pub fn tissue_at(&self, i: usize) -> MaterialPoint<'_> {
        let local = self.tissue.get(i).copied().unwrap_or_default();
        self.material.at(local)
    }

    /// The material of tet `t` of the layer.
    pub fn tissue_of_tet(&self, t: usize) -> MaterialPoint<'_> {
        let local = self.layer.tissue.get(t).copied().unwrap_or_default();
        self.material.at(local)
    }

    /// What a tissue's own k asks for at skin vertex `v`, Pa/m, before [`Collider::STIFFEST`](crate::collider::Collider::STIFFEST) limits it.
    pub fn contact_stiffness_at(&self, v: usize) -> f64 {
        let of_tissue = self.contact_stiffness.get(v).copied();
        of_tissue.unwrap_or(f64::INFINITY)
    }

    /// Whether any of the tissue damps.
    pub fn is_damped(&self) -> bool {
        self.tissue.iter().any(|local| local.damping_time > 0.0)
    }

    /// Gives all of the tissue one damping time β, s.
    pub fn set_damping_time(&mut self, damping_time: f64) {
        let layer = &mut self.layer;
        for (tissue, count) in [
            (&mut self.tissue, self.cubature.len()),
            (&mut layer.tissue, layer.mesh.tets.len()),
        ] {
            if tissue.is_empty() && damping_time != 0.0 {
                tissue.resize(count, LocalTissue::default());
            }
            (tissue.iter_mut()).for_each(|local| local.damping_time = damping_time);
        }
        if !self.fine.is_empty() {
            let fine = Arc::make_mut(&mut self.fine);
            if fine.tissue.is_empty() && damping_time != 0.0 {
                (fine.tissue).resize(fine.points.len(), LocalTissue::default());
            }
            (fine.tissue.iter_mut()).for_each(|local| local.damping_time = damping_time);
        }
    }

    /// Number of skin vertices that bound tissue; attached ones come after them, and bodies' last.
    pub fn tissue_vertices(&self) -> usize {
        (self.body_vertices(0).start).saturating_sub(self.attached.len())
    }

    /// The frames that may carry colliders: those without a parent that move no tissue.
    pub fn body_frames(&self) -> Vec<u32> {
        let mut has_tissue = vec![false; self.skeleton.len()];
        for w in self.cubature.skinning.entries() {
            has_tissue[w.bone as usize] = true;
        }
        let parents = self.skeleton.parents.iter().zip(&has_tissue);
        (0u32..)
            .zip(parents)
            .filter(|(_, (parent, tissue))| parent.is_none() && !**tissue)
            .map(|(frame, _)| frame)
            .collect()
    }

    /// The mesh behind the cubature, where it is needed.
    ///
    /// # Errors
    /// [`Error::Invalid`] where the avatar was written without it.
    pub fn needed_layer(&self) -> Result<&SoftLayer> {
        match self.layer.is_empty() {
            false => Ok(&self.layer),
            true => Err(Error::invalid(
                "layer",
                "the avatar was written without its soft layer; bake it with it (supple bake, no --without-layer)",
            )),
        }
    }

    /// Whether frame `bone` is that of a bone without mass on or below it, such as one of hair that is merely drawn. It has
    /// no degrees of freedom: a step ends with it where its parent carries it, turned as its target is, or else as before.
    pub fn is_carried(&self, bone: usize) -> bool {
        self.bone_masses.get(bone) == Some(&BoneMass::NONE)
    }

    /// Whether each frame is carried, see [`Avatar::is_carried`].
    pub fn carried(&self) -> Vec<bool> {
        let frames = 0..self.skeleton.len();
        frames.map(|bone| self.is_carried(bone)).collect()
    }

    /// Whether carried bones move only what has no mass and hang on others.
    fn carried_are_sound(&self) -> bool {
        let carried = |bone: u32| self.is_carried(bone as usize);
        let areas = self.skin.skinning.iter().zip(&self.skin.measure);
        let of_skin = areas
            .filter(|(_, area)| **area > 0.0)
            .flat_map(|(row, _)| row);
        let mut moving = of_skin.chain(self.cubature.skinning.entries());
        let hangs = |(bone, parent): (u32, &Option<u32>)| match parent {
            None => !carried(bone),
            Some(parent) => carried(bone) || !carried(*parent),
        };
        !moving.any(|w| w.weight != 0.0 && carried(w.bone))
            && (0..).zip(&self.skeleton.parents).all(hangs)
    }

    /// Mass of the tissue, kg.
    pub fn tissue_mass(&self) -> f64 {
        self.density * self.cubature.measure.iter().sum::<f64>()
    }

    /// Checks every length, index and number, so that no later room has to.
    pub fn validate(&self) -> Result<()> {
        self.skeleton.validate()?;
        self.material.validate()?;
        let (bones, handles) = (self.skeleton.len(), self.handles.len());
        self.cubature
            .validate("cubature", &self.skeleton, handles)?;
        self.skin.validate("skin", &self.skeleton, handles)?;
        self.validate_bodies()?;
        if self.joints.bones() > self.bones() {
            let (of, bones) = (self.joints.bones(), self.bones());
            let problem =
                format!("are of {of} bones; the avatar has {bones}: use JointList::of_bones");
            return Err(Error::invalid("joints", problem));
        }
        let layer = &self.layer;
        let (nodes, tets) = (layer.mesh.nodes.len(), layer.mesh.tets.len());
        layer.skinning.validate("layer.skinning", nodes)?;
        layer.basis.validate("layer.basis", nodes)?;
        if !(layer.is_empty() && layer.skin_embedding.is_empty()) {
            (layer.skin_embedding).validate("layer.skin_embedding", self.tissue_vertices())?;
        }
        self.attached.validate("attached", self.attached.len())?;
        if !self.pose_extension.is_empty() {
            (self.pose_extension).validate("pose_extension", self.cubature.len())?;
        }
        let vertices = self.tissue_vertices() + self.attached.len();
        let sizes = [self.cubature.len(), handles, vertices, nodes];
        self.fine.validate(&self.skeleton, sizes)?;
        (self.render_meshes.iter()).try_for_each(|d| d.validate(self.skin.len()))?;
        let check = |ok: bool, field: &str, problem: &str| {
            if ok {
                Ok(())
            } else {
                Err(Error::invalid(field, problem))
            }
        };
        let below = |index: u32, count: usize| (index as usize) < count;
        check(
            self.bone_masses.len() + self.body_slots == bones,
            "bone_masses",
            "one is needed for each bone",
        )?;
        check(
            self.bone_masses
                .iter()
                .flat_map(|b| b.second_moment.iter().flatten())
                .all(|s| s.is_finite()),
            "bone_masses",
            "holds a value that is not finite",
        )?;
        check(
            self.bone_masses.iter().all(|b| {
                *b == BoneMass::NONE || {
                    let s = &b.second_moment;
                    let pairs = (0..4).flat_map(|i| (0..i).map(move |j| (i, j)));
                    let rounding = |i: usize, j: usize| 1e-9 * (s[i][i] * s[j][j]).sqrt();
                    (0..4).all(|i| s[i][i] > 0.0) && { pairs }
                        .all(|(i, j)| (s[i][j] - s[j][i]).abs() <= rounding(i, j))
                }
            }),
            "bone_masses",
            "must be symmetric with a positive diagonal",
        )?;
        check(
            self.carried_are_sound(),
            "bone_masses",
            "a bone without mass is a root, moves tissue, or carries one with mass",
        )?;
        (self.springs.validate(&self.skeleton.parents)).map_err(|e| e.within("springs"))?;
        let mut sprung = self.springs.joints.iter().map(|joint| joint.bone);
        check(
            sprung.all(|bone| self.is_carried(bone as usize)),
            "springs.joints",
            "a bone has mass on or below it",
        )?;
        check(
            self.handles.iter().all(|h| h.is_finite()),
            "handles",
            "holds a value that is not finite",
        )?;
        check(
            self.cubature.measure.iter().all(|&w| w > 0.0),
            "cubature.measure",
            "weights must be positive",
        )?;
        check(
            self.skin.measure.iter().all(|&area| area >= 0.0),
            "skin.measure",
            "areas must not be negative",
        )?;
        for (tissue, count, field) in [
            (&self.tissue, self.cubature.len(), "tissue"),
            (&layer.tissue, tets, "layer.tissue"),
        ] {
            check(
                (tissue.is_empty() || tissue.len() == count)
                    && tissue.iter().all(LocalTissue::is_valid),
                field,
                "a positive stiffness, a unit quaternion, a damping time that is not negative and a muscle of 0 to 1 are \
                 needed for each point, or nothing at all",
            )?;
        }
        check(
            (self.contact_stiffness.is_empty() || self.contact_stiffness.len() == self.skin.len())
                && self
                    .contact_stiffness
                    .iter()
                    .all(|&k| k > 0.0 && k.is_finite()),
            "contact_stiffness",
            "a positive stiffness (Pa/m) is needed for each skin vertex, or nothing at all",
        )?;
        check(
            self.density > 0.0 && self.density.is_finite(),
            "density",
            "must be positive (kg/m³)",
        )?;
        check(
            self.triangles
                .iter()
                .flatten()
                .all(|&v| below(v, self.skin.len())),
            "triangles",
            "names a vertex that is not there",
        )?;
        check(
            (self.attached.entries().iter())
                .all(|&(v, share)| below(v, self.tissue_vertices()) && share.is_finite())
                && (self.skin.measure[self.tissue_vertices()..self.body_vertices(0).start].iter())
                    .all(|&area| area == 0.0),
            "attached",
            "a vertex follows one that is not there, or has an area",
        )?;
        check(
            (self.pose_extension.entries().iter())
                .all(|&(v, share)| below(v, self.tissue_vertices()) && share.is_finite()),
            "pose_extension",
            "a point follows a vertex that is not there, or by a share that is not finite",
        )?;
        check(
            layer.mesh.tets.iter().flatten().all(|&n| below(n, nodes)),
            "layer.mesh",
            "names a node that is not there",
        )?;
        check(
            layer.mesh.nodes.iter().all(|n| n.is_finite()),
            "layer.mesh",
            "holds a value that is not finite",
        )?;
        check(
            (0..tets).all(|t| layer.mesh.volume(t) > 0.0),
            "layer.mesh",
            "holds a tet that is inverted or flat",
        )?;
        check(
            layer.tissue_fraction.len() == tets
                && layer.tissue_fraction.iter().all(|&f| f > 0.0 && f <= 1.0),
            "layer.tissue_fraction",
            "one in (0, 1] is needed for each tet",
        )?;
        check(
            layer.bone_of_node.len() == nodes
                && layer
                    .bone_of_node
                    .iter()
                    .flatten()
                    .all(|&b| below(b, bones)),
            "layer.bone_of_node",
            "one bone at most, an existing one, is needed for each node",
        )?;
        check(
            layer
                .skinning
                .entries()
                .iter()
                .all(|w| below(w.bone, bones) && w.weight.is_finite())
                && layer
                    .basis
                    .entries()
                    .iter()
                    .all(|u| below(u.0, handles) && u.1.is_finite())
                && layer
                    .skin_embedding
                    .entries()
                    .iter()
                    .all(|e| below(e.0, nodes) && e.1.is_finite()),
            "layer",
            "an entry names what is not there, or is not finite",
        )?;
        check(
            layer
                .basis
                .iter()
                .all(|row| row.is_sorted_by(|a, b| a.0 < b.0)),
            "layer.basis",
            "handles of a node must rise",
        )?;
        check(
            (layer.skinning.iter())
                .all(|row| (row.iter().map(|w| w.weight).sum::<f64>() - 1.0).abs() < 1e-5),
            "layer.skinning",
            "weights of a node do not sum to 1",
        )
    }
}
