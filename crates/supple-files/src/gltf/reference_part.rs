//! A part's vertices in the reference shape.

use super::nodes::Nodes;
use super::primitive::Part;
use super::rig::{Rig, rest_transform};
use glam::{DAffine3, DMat3, DMat4, DVec3};
use supple::model::SkinWeight;

/// B is not inverted below this determinant: bones turned against each other by more than 150° meet.
const LEAST_DETERMINANT: f64 = 0.05;

/// Where a part's vertices are in the reference shape.
pub(super) struct ReferencePart {
    pub positions: Vec<DVec3>,
    pub skinning: Vec<Vec<SkinWeight>>,
    /// What each vertex's displacements are multiplied with.
    pub linear: Vec<DMat3>,
    /// Whether the node mirrors: its triangles are wound the other way round then (§3.7.4).
    pub mirrored: bool,
    /// Vertices whose weights cancel at rest: their place is that of the bind pose.
    pub cancelled: usize,
}

impl Rig {
    /// The part's vertices in the reference shape; nothing where no bone moves them.
    pub fn place(&self, nodes: &Nodes, part: &Part) -> Option<ReferencePart> {
        let skin = part.skin.and_then(|s| self.skins.get(&s));
        let world = nodes.rest_world[part.node];
        let above = match skin {
            Some(_) => None,
            None => Some(self.bone_above(nodes, part.node)?),
        };
        let mut out = ReferencePart {
            positions: Vec::new(),
            skinning: Vec::new(),
            linear: Vec::new(),
            mirrored: world.matrix3.determinant() < 0.0,
            cancelled: 0,
        };
        for (v, row) in part.positions.iter().zip(part.influences.iter()) {
            let mut skinning: Vec<SkinWeight> = Vec::with_capacity(row.len().max(1));
            // Σ w M of the file, and Σ w (R, c − R J) of this crate.
            let (mut file, mut own) = (DMat4::ZERO, DMat4::ZERO);
            let mut add = |bone: u32, weight: f64, matrix: DAffine3| {
                let (frame, joint) = (
                    self.rest[bone as usize],
                    self.skeleton.joints[bone as usize],
                );
                file += weight * DMat4::from(matrix);
                own += weight * DMat4::from(rest_transform(&frame, joint));
                match skinning.iter_mut().find(|s| s.bone == bone) {
                    Some(same) => same.weight += weight,
                    None => skinning.push(SkinWeight { bone, weight }),
                }
            };
            match (skin, above) {
                (Some(skin), _) => row.iter().for_each(|&(joint, w)| {
                    let joint = joint as usize;
                    add(skin.bones[joint], w, skin.skinning[joint]);
                }),
                (None, bone) => add(bone.unwrap_or(0), 1.0, world),
            }
            let (file, own) = (DAffine3::from_mat4(file), DAffine3::from_mat4(own));
            let map = if own.matrix3.determinant() > LEAST_DETERMINANT {
                own.inverse() * file
            } else {
                out.cancelled += 1;
                skin.map_or(world, |s| s.reference)
            };
            skinning.sort_by_key(|s| s.bone);
            out.positions.push(map.transform_point3(*v));
            out.linear.push(map.matrix3);
            out.skinning.push(skinning);
        }
        Some(out)
    }
}
