//! Sections `matl` and `layr` of version 1, which have one damping time for all of the tissue and no muscle.

use crate::material::{LocalTissue, Material};
use crate::math::Rows;
use crate::model::{SkinWeight, SoftLayer, TetMesh};
use glam::DQuat;
use serde::{Deserialize, Serialize};

/// What a point had of its own.
#[derive(Serialize, Deserialize)]
pub(super) struct Local {
    stiffness: f64,
    axes: DQuat,
}

/// The tissue's constants.
#[derive(Serialize, Deserialize)]
pub(super) struct Tissue {
    pub material: Material,
    pub local: Vec<Local>,
    pub density: f64,
    pub damping_time: f64,
    pub captured_under_gravity: bool,
}

/// The soft layer.
#[derive(Serialize, Deserialize)]
pub(super) struct Layer {
    mesh: TetMesh,
    tissue_fraction: Vec<f64>,
    bone_of_node: Vec<Option<u32>>,
    skinning: Rows<SkinWeight>,
    basis: Rows<(u32, f64)>,
    skin_embedding: Rows<(u32, f64)>,
    tissue: Vec<Local>,
}

/// What `points` had, undamped.
pub(super) fn local_tissue(points: Vec<Local>) -> Vec<LocalTissue> {
    let local = |Local { stiffness, axes }| LocalTissue {
        stiffness,
        axes,
        ..LocalTissue::default()
    };
    points.into_iter().map(local).collect()
}

impl From<Layer> for SoftLayer {
    fn from(layer: Layer) -> Self {
        Self {
            mesh: layer.mesh,
            tissue_fraction: layer.tissue_fraction,
            bone_of_node: layer.bone_of_node,
            skinning: layer.skinning,
            basis: layer.basis,
            skin_embedding: layer.skin_embedding,
            tissue: local_tissue(layer.tissue),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::file::{AvatarFile, Parts, Section};
    use crate::model::Avatar;
    use crate::random_avatar::random_avatar;
    use std::path::Path;

    fn local(tissue: &[LocalTissue]) -> Vec<Local> {
        let local = |t: &LocalTissue| Local {
            stiffness: t.stiffness,
            axes: t.axes,
        };
        tissue.iter().map(local).collect()
    }

    /// The file of `avatar` as it was written before points had a damping time.
    fn written_before(avatar: &Avatar, damping_time: f64, parts: Parts) -> Vec<u8> {
        let tissue = Tissue {
            material: avatar.material,
            local: local(&avatar.tissue),
            density: avatar.density,
            damping_time,
            captured_under_gravity: avatar.captured_under_gravity,
        };
        let from = avatar.layer.clone();
        let layer = Layer {
            mesh: from.mesh,
            tissue_fraction: from.tissue_fraction,
            bone_of_node: from.bone_of_node,
            skinning: from.skinning,
            basis: from.basis,
            skin_embedding: from.skin_embedding,
            tissue: local(&from.tissue),
        };
        let mut sections = crate::file::parts::of_avatar(avatar, parts).unwrap();
        for section in &mut sections {
            let content = match &section.tag {
                b"matl" => postcard::to_allocvec(&tissue).unwrap(),
                b"layr" => postcard::to_allocvec(&layer).unwrap(),
                _ => continue,
            };
            (section.version, section.content) = (1, content);
        }
        crate::file::sections::join(&sections)
    }

    #[test]
    fn tissue_of_files_written_before_is_damped_as_one_and_all_fat() {
        let path = Path::new("before.supple");
        for (parts, everywhere) in [
            (Parts::All, false),
            (Parts::All, true),
            (Parts::Step, false),
        ] {
            let mut avatar = random_avatar(3, 2, 4, 10, 40);
            for local in avatar.tissue.iter_mut().chain(&mut avatar.layer.tissue) {
                local.muscle = 0.0;
            }
            if parts == Parts::Step {
                avatar.layer = SoftLayer::default();
            }
            if everywhere {
                (avatar.tissue, avatar.layer.tissue) = (Vec::new(), Vec::new());
            }
            let bytes = written_before(&avatar, 0.004, parts);
            avatar.set_damping_time(0.004);
            assert_eq!(avatar.tissue.len(), avatar.cubature.len());
            assert_eq!(avatar.layer.tissue.len(), avatar.layer.mesh.tets.len());
            let read = AvatarFile::from_bytes(&bytes, path).unwrap().avatar;
            assert_eq!(read, avatar);
        }
        let avatar = random_avatar(3, 2, 4, 10, 40);
        let bytes = written_before(&avatar, f64::NAN, Parts::All);
        let error = AvatarFile::from_bytes(&bytes, path).unwrap_err();
        assert!(error.to_string().contains("tissue"), "{error}");
    }

    #[test]
    fn a_section_of_a_version_to_come_asks_for_an_update() {
        let mut avatar = random_avatar(3, 2, 4, 10, 40);
        avatar.layer = SoftLayer::default();
        let sections = crate::file::parts::of_avatar(&avatar, Parts::All).unwrap();
        let later = |s: Section| Section {
            version: s.version + 1,
            ..s
        };
        for at in 0..sections.len() {
            let mut sections = sections.clone();
            sections[at] = later(sections[at].clone());
            let bytes = crate::file::sections::join(&sections);
            let error = AvatarFile::from_bytes(&bytes, Path::new("later.supple")).unwrap_err();
            assert!(error.to_string().contains("update supple"), "{error}");
        }
    }
}
