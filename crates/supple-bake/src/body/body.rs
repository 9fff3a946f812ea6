//! What baking starts from: a skinned body and the mesh of its soft layer.

use crate::body::attachment::Attachment;
use crate::body::parametric::ParametricModel;
use glam::DVec3;
use std::collections::BTreeMap;
use std::sync::Arc;
use supple::internal::math::Rows;
use supple::model::{
    Appearance, JointList, PoseBlend, RenderMesh, Skeleton, SkinWeight, SpringBones, Surface,
    TetMesh, UpAxis,
};
use supple::{Error, Result};

/// The meshed volume between bones and skin.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LayerMesh {
    /// The mesh, in the reference shape.
    pub mesh: TetMesh,
    /// The part of each tet that is tissue, in (0, 1].
    pub tissue_fraction: Vec<f64>,
    /// The bone that holds each node, if one does.
    pub bone_of_node: Vec<Option<u32>>,
    /// Nodes (index, share) of each skin vertex; one node where the mesh meets the skin.
    pub skin_embedding: Rows<(u32, f64)>,
}

impl LayerMesh {
    /// Volume of the tissue, m³: Σ volume · tissue fraction.
    pub fn tissue_volume(&self) -> f64 {
        (self.tissue_fraction.iter().enumerate())
            .map(|(t, fraction)| fraction * self.mesh.volume(t))
            .sum()
    }

    /// Checks lengths, indices and ranges for a skin of `skin_vertices` over `bones`.
    pub fn validate(&self, skin_vertices: usize, bones: usize) -> Result<()> {
        let nodes = self.mesh.nodes.len();
        let check = |ok: bool, field: &str, problem: &str| {
            ok.then_some(())
                .ok_or_else(|| Error::invalid(field, problem))
        };
        check(
            self.mesh
                .tets
                .iter()
                .flatten()
                .all(|&n| (n as usize) < nodes),
            "layer.mesh",
            "a tet names a node that is not there",
        )?;
        check(
            (0..self.mesh.tets.len()).all(|t| self.mesh.volume(t) > 0.0),
            "layer.mesh",
            "holds a tet that is inverted, flat or not finite",
        )?;
        check(
            self.tissue_fraction.len() == self.mesh.tets.len()
                && self.tissue_fraction.iter().all(|&f| f > 0.0 && f <= 1.0),
            "layer.tissue_fraction",
            "one in (0, 1] is needed for each tet",
        )?;
        check(
            self.bone_of_node.len() == nodes
                && (self.bone_of_node.iter().flatten()).all(|&b| (b as usize) < bones),
            "layer.bone_of_node",
            "one bone at most, an existing one, is needed for each node",
        )?;
        self.skin_embedding
            .validate("layer.skin_embedding", skin_vertices)?;
        check(
            (self.skin_embedding.entries().iter())
                .all(|&(n, share)| (n as usize) < nodes && share.is_finite()),
            "layer.skin_embedding",
            "an entry names a node that is not there, or is not finite",
        )
    }
}

/// A skinned body with its meshed soft layer.
#[derive(Clone, Debug, PartialEq)]
pub struct Body {
    /// What it is called in reports.
    pub name: String,
    /// Bones.
    pub skeleton: Skeleton,
    /// The file's joints, and the bone of each.
    pub joints: JointList,
    /// Bones that swing where they carry no tissue.
    pub springs: SpringBones,
    /// The axis that points up in the reference shape.
    pub up: UpAxis,
    /// The skin that is drawn and touches, in the reference shape; welded. Closed unless the body
    /// is a cut piece.
    pub skin: Surface,
    /// Bones of each skin vertex.
    pub skinning: Rows<SkinWeight>,
    /// Pose blend shapes at the skin vertices.
    pub pose_blend: PoseBlend,
    /// Closed surface of each bone, empty where it is not known; or no surface at all.
    pub bone_surfaces: Vec<Surface>,
    /// The tissue between bones and skin.
    pub layer: LayerMesh,
    /// Maps painted on the skin, by name: a number for each skin vertex, mostly 0 to 1. Recipes name them.
    pub painted: BTreeMap<String, Vec<f64>>,
    /// What is drawn with the skin and is not part of it: clothes, hair, eyes.
    pub attachments: Vec<Attachment>,
    /// How the body's file draws it, seams and all; none where it is drawn as it is.
    pub render_meshes: Vec<RenderMesh>,
    /// Materials and images of the body's file.
    pub appearance: Arc<Appearance>,
}

impl Body {
    /// Shape β of `model`, its layer not yet meshed; y is up. Pose directions that are all 0 are left out.
    pub fn of_model(
        name: &str,
        model: &ParametricModel,
        betas: &[f64],
        bone_surfaces: Vec<Surface>,
    ) -> Self {
        let directions = &model.pose_directions;
        let moves = directions.iter().flatten().any(|d| *d != DVec3::ZERO);
        let pose_blend = if moves {
            PoseBlend {
                features: directions.len(),
                columns: (directions.iter().flatten().map(|d| d.as_vec3().to_array())).collect(),
            }
        } else {
            PoseBlend::default()
        };
        let skeleton = model.skeleton(betas);
        Self {
            name: name.into(),
            joints: JointList::of_bones(&skeleton),
            springs: SpringBones::default(),
            up: UpAxis::Y,
            skeleton,
            skin: Surface {
                positions: model.shaped(betas),
                triangles: model.triangles.clone(),
            },
            skinning: model.weights.clone(),
            pose_blend,
            bone_surfaces,
            layer: LayerMesh::default(),
            painted: BTreeMap::new(),
            attachments: Vec::new(),
            render_meshes: Vec::new(),
            appearance: Default::default(),
        }
    }

    /// The painted map `name`; `field` is where the name stands, for errors.
    ///
    /// # Errors
    /// [`Error::Invalid`] where there is none.
    pub fn painted_map(&self, name: &str, field: &str) -> Result<&[f64]> {
        self.painted.get(name).map(Vec::as_slice).ok_or_else(|| {
            let names: Vec<&str> = self.painted.keys().map(String::as_str).collect();
            let problem = match names[..] {
                [] => format!("no map {name:?}: the body has none; give one under [painted]"),
                _ => format!("no map {name:?}; there are {}", names.join(", ")),
            };
            Error::invalid(field, problem)
        })
    }

    /// Names of the parts that the file draws the tissue's skin with, each once; none where it is drawn as it is.
    pub fn tissue_parts(&self) -> Vec<&str> {
        let vertices = self.skin.positions.len();
        let of_skin = |d: &RenderMesh| {
            let corners = d.triangles.iter().map(|t| d.vertices.get(t[0] as usize));
            let mut drawn = corners.flatten().map(|&v| (v as usize) < vertices);
            drawn.any(|of_skin| of_skin)
        };
        let mut names: Vec<&str> = Vec::new();
        for d in self.render_meshes.iter().filter(|d| of_skin(d)) {
            if !names.contains(&d.name.as_str()) {
                names.push(&d.name);
            }
        }
        names
    }

    /// Makes everything `factor` times as large.
    pub fn scale(&mut self, factor: f64) {
        let surfaces = self.bone_surfaces.iter_mut();
        let attached = self.attachments.iter_mut().map(|a| &mut a.surface);
        let places = (surfaces.chain(attached).chain([&mut self.skin]))
            .flat_map(|s| &mut s.positions)
            .chain(&mut self.skeleton.joints)
            .chain(&mut self.layer.mesh.nodes);
        places.for_each(|p| *p *= factor);
        let blends = self.attachments.iter_mut().map(|a| &mut a.pose_blend);
        let columns = blends
            .chain([&mut self.pose_blend])
            .flat_map(|b| &mut b.columns);
        columns.flatten().for_each(|x| *x *= factor as f32);
        self.joints.scale(factor);
        self.springs.scale(factor);
    }

    /// Checks every length, index and number.
    pub fn validate(&self) -> Result<()> {
        self.skeleton.validate()?;
        let (vertices, bones) = (self.skin.positions.len(), self.skeleton.len());
        if self.joints.bones() != bones {
            let problem = format!("are of {} bones, not of {bones}", self.joints.bones());
            return Err(Error::invalid("joints", problem));
        }
        (self.springs.validate(&self.skeleton.parents)).map_err(|e| e.within("springs"))?;
        self.layer.validate(vertices, bones)?;
        self.skinning.validate("skinning", vertices)?;
        let check = |ok: bool, field: &str, problem: &str| {
            ok.then_some(())
                .ok_or_else(|| Error::invalid(field, problem))
        };
        check(
            self.skin.positions.iter().all(|p| p.is_finite())
                && (self.skin.triangles.iter().flatten()).all(|&v| (v as usize) < vertices),
            "skin",
            "holds a value that is not finite, or names a vertex that is not there",
        )?;
        check(
            (self.skinning.entries().iter())
                .all(|w| (w.bone as usize) < bones && w.weight.is_finite()),
            "skinning",
            "an entry names a bone that is not there, or is not finite",
        )?;
        check(
            self.pose_blend.features.checked_mul(vertices) == Some(self.pose_blend.columns.len()),
            "pose_blend",
            "needs one column for each feature and skin vertex",
        )?;
        let attached = |a: &Attachment| a.surface.positions.len();
        let body_vertices = vertices + self.attachments.iter().map(attached).sum::<usize>();
        (self.attachments.iter()).try_for_each(|a| a.validate(bones))?;
        (self.render_meshes.iter()).try_for_each(|d| d.validate(body_vertices))?;
        for (name, values) in &self.painted {
            check(
                values.len() == vertices && values.iter().all(|v| v.is_finite()),
                &format!("painted.{name}"),
                "needs a finite number for each skin vertex",
            )?;
        }
        check(
            self.bone_surfaces.is_empty() || self.bone_surfaces.len() == bones,
            "bone_surfaces",
            "one is needed for each bone, or none at all",
        )
    }
}
