//! What the sections of an avatar hold, and what stands in for one that is not there.
//!
//! | tag | what | without it |
//! |---|---|---|
//! | `bone` | name, skeleton, bone masses | refused |
//! | `join` | the file's joints and skins, and the bone of each joint | each bone is a joint with F = 1 |
//! | `sprg` | spring bones: chains, joints, colliders | nothing swings |
//! | `upax` | the axis that points up in the reference shape | y |
//! | `hndl` | rest positions of the handles | no handles |
//! | `cuba` | cubature points | refused |
//! | `skin` | skin vertices and triangles | refused |
//! | `matl` | material, what it has of its own at each cubature point, density | refused |
//! | `cpos`, `spos` | pose blend shapes of cubature points and skin, without their zeros | none |
//! | `exte` | how cubature points follow offsets of the skin | no offsets are taken |
//! | `cstf` | penalty stiffness of each skin vertex | the stiffest everywhere |
//! | `atta` | what attached vertices follow | nothing is attached |
//! | `draw` | how the body's file draws the skin | the skin is drawn as it is |
//! | `shad` | index of the material and tangents of each part of `draw` | none |
//! | `vatt` | normals, colours and further texture coordinates of each part of `draw` | none |
//! | `look` | materials, textures and images of the body's file | parts are drawn in plain colours |
//! | `fine`, `fcub` | handles that sleep, and the cubature points around them | none can wake |
//! | `layr` | mesh, basis and embedding of the soft layer: for reports, bakes and the full space | none |
//!
//! Sections are of version 1, but `matl` and `layr` of version 2: those of version 1 have one damping time for all of the
//! tissue, and no muscle ([`super::version_1`]).

use super::Parts;
use super::sections::{Section, tag_name};
use super::sparse_columns::SparseColumns;
use super::version_1;
use crate::material::{LocalTissue, Material};
use crate::math::Rows;
use crate::model::{
    Appearance, Avatar, BasisEntry, BoneMass, FineHandles, JointList, PointSet, PoseBlend,
    RenderMesh, Skeleton, SkinWeight, SoftLayer, SpringBones, UpAxis,
};
use crate::{Error, Result};
use glam::DVec3;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use std::path::Path;
use std::sync::Arc;

const BONES: [u8; 4] = *b"bone";
const JOINTS: [u8; 4] = *b"join";
const SPRINGS: [u8; 4] = *b"sprg";
const UP_AXIS: [u8; 4] = *b"upax";
const HANDLES: [u8; 4] = *b"hndl";
const CUBATURE: [u8; 4] = *b"cuba";
const SKIN: [u8; 4] = *b"skin";
const MATERIAL: [u8; 4] = *b"matl";
const CUBATURE_POSE: [u8; 4] = *b"cpos";
const SKIN_POSE: [u8; 4] = *b"spos";
const EXTENSION: [u8; 4] = *b"exte";
const CONTACT_STIFFNESS: [u8; 4] = *b"cstf";
const ATTACHED: [u8; 4] = *b"atta";
const DRAWN: [u8; 4] = *b"draw";
const SHADING: [u8; 4] = *b"shad";
const VERTEX_ATTRIBUTES: [u8; 4] = *b"vatt";
const APPEARANCE: [u8; 4] = *b"look";
const FINE: [u8; 4] = *b"fine";
const FINE_CUBATURE: [u8; 4] = *b"fcub";
const LAYER: [u8; 4] = *b"layr";

type Bones<'a> = (Cow<'a, str>, Cow<'a, Skeleton>, Cow<'a, [BoneMass]>);
type Triangles<'a> = Cow<'a, [[u32; 3]]>;
/// What a [`RenderMesh`] has beside its own section.
type Shading = (Option<u32>, Vec<[f32; 4]>);
/// And besides: normals, colours, further texture coordinates.
type VertexAttributes = (Vec<[f32; 3]>, Vec<[f32; 4]>, Vec<Vec<[f32; 2]>>);

/// A [`PointSet`] without its pose blend shapes.
#[derive(Serialize, Deserialize)]
struct Points<'a> {
    position: Cow<'a, [DVec3]>,
    measure: Cow<'a, [f64]>,
    skinning: Cow<'a, Rows<SkinWeight>>,
    basis: Basis<'a>,
}

/// The basis at points, with its gradients where there are any.
#[derive(Serialize, Deserialize)]
enum Basis<'a> {
    Values(Rows<(u32, f64)>),
    Gradients(Cow<'a, Rows<BasisEntry>>),
}

/// The tissue's constants.
#[derive(Serialize, Deserialize)]
struct Tissue<'a> {
    material: Material,
    local: Cow<'a, [LocalTissue]>,
    density: f64,
    captured_under_gravity: bool,
}

/// The version of a section as this build writes it.
fn version(tag: [u8; 4]) -> u32 {
    match tag {
        MATERIAL | LAYER => 2,
        _ => 1,
    }
}

/// The sections of `avatar`; a part that is its default is left out.
pub(super) fn of_avatar(avatar: &Avatar, parts: Parts) -> Result<Vec<Section>> {
    let bones: Bones<'_> = (
        (&avatar.name).into(),
        Cow::Borrowed(&avatar.skeleton),
        (&avatar.bone_masses).into(),
    );
    let tissue = Tissue {
        material: avatar.material,
        local: (&avatar.tissue).into(),
        density: avatar.density,
        captured_under_gravity: avatar.captured_under_gravity,
    };
    let triangles: Triangles<'_> = (&avatar.triangles).into();
    let mut sections = vec![
        section(BONES, &bones)?,
        section(HANDLES, &avatar.handles)?,
        section(CUBATURE, &Points::of(&avatar.cubature))?,
        section(SKIN, &(Points::of(&avatar.skin), triangles))?,
        section(MATERIAL, &tissue)?,
    ];
    if avatar.joints != JointList::of_bones(&avatar.skeleton) {
        sections.push(section(JOINTS, &avatar.joints)?);
    }
    if avatar.springs != SpringBones::default() {
        sections.push(section(SPRINGS, &avatar.springs)?);
    }
    if avatar.up != UpAxis::default() {
        sections.push(section(UP_AXIS, &avatar.up)?);
    }
    for (tag, set) in [(CUBATURE_POSE, &avatar.cubature), (SKIN_POSE, &avatar.skin)] {
        if set.pose_blend != PoseBlend::default() {
            sections.push(section(
                tag,
                &SparseColumns::of(&set.pose_blend, set.len()),
            )?);
        }
    }
    if !avatar.pose_extension.is_empty() {
        sections.push(section(EXTENSION, &avatar.pose_extension)?);
    }
    if !avatar.contact_stiffness.is_empty() {
        let rounded: Vec<f32> = avatar.contact_stiffness.iter().map(|k| *k as f32).collect();
        sections.push(section(CONTACT_STIFFNESS, &rounded)?);
    }
    if !avatar.attached.is_empty() {
        sections.push(section(ATTACHED, &avatar.attached)?);
    }
    if !avatar.render_meshes.is_empty() {
        sections.push(section(DRAWN, &avatar.render_meshes)?);
    }
    if (avatar.render_meshes.iter()).any(|d| d.material_index.is_some() || !d.tangents.is_empty()) {
        let of = |d: &RenderMesh| (d.material_index, d.tangents.clone());
        let shading: Vec<Shading> = avatar.render_meshes.iter().map(of).collect();
        sections.push(section(SHADING, &shading)?);
    }
    let attributed = |d: &RenderMesh| {
        !(d.normals.is_empty() && d.colours.is_empty() && d.further_coordinates.is_empty())
    };
    if avatar.render_meshes.iter().any(attributed) {
        let of = |d: &RenderMesh| {
            (
                d.normals.clone(),
                d.colours.clone(),
                d.further_coordinates.clone(),
            )
        };
        let attributes: Vec<VertexAttributes> = avatar.render_meshes.iter().map(of).collect();
        sections.push(section(VERTEX_ATTRIBUTES, &attributes)?);
    }
    if parts == Parts::All && !avatar.appearance.is_empty() {
        sections.push(section(APPEARANCE, &*avatar.appearance)?);
    }
    if !avatar.fine.is_empty() {
        sections.push(section(FINE, &*avatar.fine)?);
        sections.push(section(FINE_CUBATURE, &Points::of(&avatar.fine.points))?);
    }
    if parts == Parts::All && avatar.layer != SoftLayer::default() {
        sections.push(section(LAYER, &avatar.layer)?);
    }
    Ok(sections)
}

/// The avatar in `sections`, which keep what is no part of it.
pub(super) fn to_avatar(sections: &mut Vec<Section>, path: &Path) -> Result<Avatar> {
    let mut reader = Reader { sections, path };
    let (name, skeleton, masses): Bones<'static> = reader.required(BONES)?;
    let cubature: Points<'static> = reader.required(CUBATURE)?;
    let (skin, triangles): (Points<'static>, Triangles<'static>) = reader.required(SKIN)?;
    let (tissue, damping_time) = reader.tissue()?;
    let joints = match reader.optional(JOINTS)? {
        Some(joints) => joints,
        None => JointList::of_bones(&skeleton),
    };
    let mut avatar = Avatar {
        name: name.into_owned(),
        joints,
        up: reader.optional(UP_AXIS)?.unwrap_or_default(),
        skeleton: skeleton.into_owned(),
        bone_masses: masses.into_owned(),
        springs: reader.optional(SPRINGS)?.unwrap_or_default(),
        handles: reader.optional(HANDLES)?.unwrap_or_default(),
        cubature: reader.points(cubature, CUBATURE_POSE)?,
        skin: reader.points(skin, SKIN_POSE)?,
        triangles: triangles.into_owned(),
        pose_extension: reader.optional(EXTENSION)?.unwrap_or_default(),
        contact_stiffness: (reader
            .optional::<Vec<f32>>(CONTACT_STIFFNESS)?
            .unwrap_or_default())
        .into_iter()
        .map(f64::from)
        .collect(),
        attached: reader.optional(ATTACHED)?.unwrap_or_default(),
        render_meshes: reader.render_meshes()?,
        appearance: Arc::new(
            reader
                .optional::<Appearance>(APPEARANCE)?
                .unwrap_or_default(),
        ),
        material: tissue.material,
        tissue: tissue.local.into_owned(),
        density: tissue.density,
        captured_under_gravity: tissue.captured_under_gravity,
        fine: Arc::new(reader.fine()?),
        layer: reader.layer()?,
        bodies: Vec::new(),
        body_slots: 0,
    };
    if let Some(damping_time) = damping_time {
        avatar.set_damping_time(damping_time);
    }
    Ok(avatar)
}

fn section(tag: [u8; 4], value: &impl Serialize) -> Result<Section> {
    let content = postcard::to_allocvec(value)
        .map_err(|e| Error::invalid("avatar", format!("cannot be written: {e}")))?;
    Ok(Section {
        tag,
        version: version(tag),
        content,
    })
}

/// A section without which there is no avatar.
fn needed<T>(path: &Path, tag: [u8; 4], found: Option<T>) -> Result<T> {
    found.ok_or_else(|| {
        let problem = "is not there, and no avatar is without it; bake it again";
        Error::format(path, tag_name(tag), problem)
    })
}

impl<'a> Points<'a> {
    fn of(set: &'a PointSet) -> Self {
        let flat = |u: &BasisEntry| u.gradient.to_array().map(f64::to_bits) == [0; 3];
        Self {
            position: (&set.position).into(),
            measure: (&set.measure).into(),
            skinning: Cow::Borrowed(&set.skinning),
            basis: match set.basis.entries().iter().all(flat) {
                true => Basis::Values(set.basis.map(|u| (u.handle, u.value))),
                false => Basis::Gradients(Cow::Borrowed(&set.basis)),
            },
        }
    }

    /// The set that they are, without pose blend shapes.
    fn without_pose(self) -> PointSet {
        let no_gradient = |&(handle, value): &(u32, f64)| BasisEntry {
            handle,
            value,
            gradient: DVec3::ZERO,
        };
        PointSet {
            position: self.position.into_owned(),
            measure: self.measure.into_owned(),
            skinning: self.skinning.into_owned(),
            basis: match self.basis {
                Basis::Values(rows) => rows.map(no_gradient),
                Basis::Gradients(rows) => rows.into_owned(),
            },
            pose_blend: PoseBlend::default(),
        }
    }
}

/// Takes sections out of a file.
struct Reader<'a> {
    sections: &'a mut Vec<Section>,
    path: &'a Path,
}

impl Reader<'_> {
    fn optional<T: DeserializeOwned>(&mut self, tag: [u8; 4]) -> Result<Option<T>> {
        self.of_version(tag, version(tag))
    }

    /// The tissue's constants, and the damping time of all of it where the file has one.
    fn tissue(&mut self) -> Result<(Tissue<'static>, Option<f64>)> {
        if !self.is_of_version_1(MATERIAL) {
            return Ok((self.required(MATERIAL)?, None));
        }
        let tissue: version_1::Tissue = needed(self.path, MATERIAL, self.of_version(MATERIAL, 1)?)?;
        let damping_time = tissue.damping_time;
        let tissue = Tissue {
            material: tissue.material,
            local: version_1::local_tissue(tissue.local).into(),
            density: tissue.density,
            captured_under_gravity: tissue.captured_under_gravity,
        };
        Ok((tissue, Some(damping_time)))
    }

    /// The fine handles; none where the file has none.
    fn fine(&mut self) -> Result<FineHandles> {
        let Some(fine) = self.optional::<FineHandles>(FINE)? else {
            return Ok(FineHandles::default());
        };
        let points: Points<'static> = self.required(FINE_CUBATURE)?;
        Ok(FineHandles {
            points: points.without_pose(),
            ..fine
        })
    }

    /// The soft layer; empty where the file has none.
    fn layer(&mut self) -> Result<SoftLayer> {
        let layer = match self.is_of_version_1(LAYER) {
            true => (self.of_version(LAYER, 1)?).map(|layer: version_1::Layer| layer.into()),
            false => self.optional(LAYER)?,
        };
        Ok(layer.unwrap_or_default())
    }

    fn is_of_version_1(&self, tag: [u8; 4]) -> bool {
        (self.sections.iter()).any(|s| s.tag == tag && s.version == 1)
    }

    /// A section that must be of version `known`.
    fn of_version<T: DeserializeOwned>(&mut self, tag: [u8; 4], known: u32) -> Result<Option<T>> {
        let Some(at) = self.sections.iter().position(|s| s.tag == tag) else {
            return Ok(None);
        };
        let section = self.sections.remove(at);
        let fail = |problem: String| Err(Error::format(self.path, tag_name(tag), problem));
        if section.version != known {
            let version = section.version;
            return fail(format!(
                "version {version}, this build reads {known}; update supple"
            ));
        }
        match postcard::take_from_bytes(&section.content) {
            Ok((value, [])) => Ok(Some(value)),
            Ok((_, rest)) => fail(format!("{} bytes too many", rest.len())),
            Err(e) => fail(format!("{e}; bake it again")),
        }
    }

    fn required<T: DeserializeOwned>(&mut self, tag: [u8; 4]) -> Result<T> {
        let found = self.optional(tag)?;
        needed(self.path, tag, found)
    }

    /// How the file draws the skin, with what the shading needs where the file has it.
    fn render_meshes(&mut self) -> Result<Vec<RenderMesh>> {
        let mut drawn: Vec<RenderMesh> = self.optional(DRAWN)?.unwrap_or_default();
        let shading = self.of_parts::<Shading>(SHADING, drawn.len())?;
        for (part, shading) in drawn.iter_mut().zip(shading) {
            (part.material_index, part.tangents) = shading;
        }
        let attributes = self.of_parts::<VertexAttributes>(VERTEX_ATTRIBUTES, drawn.len())?;
        for (part, attributes) in drawn.iter_mut().zip(attributes) {
            (part.normals, part.colours, part.further_coordinates) = attributes;
        }
        Ok(drawn)
    }

    /// A section with an entry for each drawn part, or nothing.
    fn of_parts<T: DeserializeOwned>(&mut self, tag: [u8; 4], parts: usize) -> Result<Vec<T>> {
        let found: Option<Vec<T>> = self.optional(tag)?;
        match found {
            Some(found) if found.len() != parts => {
                let problem = format!("is of {} parts; there are {parts}", found.len());
                Err(Error::format(self.path, tag_name(tag), problem))
            }
            found => Ok(found.unwrap_or_default()),
        }
    }

    /// The set of `points`, with the pose blend shapes of section `pose`.
    fn points(&mut self, points: Points<'_>, pose: [u8; 4]) -> Result<PointSet> {
        let count = points.position.len();
        let pose_blend = match self.optional::<SparseColumns>(pose)? {
            None => PoseBlend::default(),
            Some(sparse) => (sparse.columns(count))
                .map_err(|problem| Error::format(self.path, tag_name(pose), problem))?,
        };
        Ok(PointSet {
            pose_blend,
            ..points.without_pose()
        })
    }
}
