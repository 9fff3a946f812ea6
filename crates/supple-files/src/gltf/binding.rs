//! How skins bind to bones: R of each joint, and G ([`super::rig`]).

use super::bone_tree::BoneTree;
use super::container::File;
use super::nodes::Nodes;
use super::polar::polar_factor;
use super::rig::name;
use glam::{DAffine3, DMat3, DMat4};
use supple::Result;

/// A skin whose joints are bones.
#[derive(Debug)]
pub(super) struct BoundSkin {
    /// Bone of each joint.
    pub bones: Vec<u32>,
    /// Of each joint.
    pub inverse_binds: Vec<DAffine3>,
    /// M_j at rest, of each joint.
    pub skinning: Vec<DAffine3>,
    /// G: what takes the mesh to the reference shape, if it is the same for all joints.
    pub reference: DAffine3,
}

/// Rotations of bones as skin after skin is bound.
pub(super) struct Binding<'a> {
    pub file: &'a File,
    pub nodes: &'a Nodes,
    pub tree: &'a BoneTree,
    /// Sum of the weights of each node.
    pub weight: &'a [f64],
    /// R of each bone at rest, where a skin has said it.
    pub rotation: Vec<Option<DMat3>>,
}

impl Binding<'_> {
    /// Binds a skin whose joints are `bones`; nothing where there are none.
    pub fn bind(&mut self, skin: usize, bones: Vec<u32>) -> Result<Option<BoundSkin>> {
        let inverse_binds = inverse_bind_matrices(self.file, skin)?;
        let node = |k: usize| self.tree.nodes[bones[k] as usize];
        let skinning: Vec<DAffine3> = (0..bones.len())
            .map(|k| self.nodes.rest_world[node(k)] * inverse_binds[k])
            .collect();
        // M_j without the scale of a node that is scaled to nothing.
        let linear_of =
            |k: usize| self.nodes.rest_with_inverse(node(k)).matrix3 * inverse_binds[k].matrix3;
        // The bone nearest to the root that another skin has placed, or else that has weight.
        let best = (0..bones.len()).min_by_key(|&k| {
            let bone = bones[k] as usize;
            let flat = polar_factor(skinning[k].matrix3).is_none();
            let weighted = self.weight[node(k)] > 0.0;
            (flat, self.rotation[bone].is_none(), !weighted, bone)
        });
        let Some(best) = best else { return Ok(None) };
        let known = self.rotation[bones[best] as usize].unwrap_or(DMat3::IDENTITY);
        let linear = known.transpose() * linear_of(best);
        for (k, &bone) in bones.iter().enumerate() {
            if self.rotation[bone as usize].is_some() {
                continue;
            }
            let found = polar_factor(linear_of(k) * linear.inverse()).ok_or_else(|| {
                let name = name(self.file, node(k));
                let problem = format!(
                    "its inverse bind matrix of joint {name} flattens space: bind the skin anew"
                );
                self.file.broken(format!("skins[{skin}]"), problem)
            })?;
            // A bone that is mirrored against the others: the mirror is in the shape.
            self.rotation[bone as usize] = Some(found * found.determinant().signum());
        }
        Ok(Some(BoundSkin {
            bones,
            inverse_binds,
            skinning,
            reference: DAffine3::from_mat3(linear),
        }))
    }
}

/// The inverse bind matrices of a skin, the identity where there are none.
fn inverse_bind_matrices(file: &File, skin: usize) -> Result<Vec<DAffine3>> {
    let field = || format!("skins[{skin}].inverseBindMatrices");
    let found = &file.document.skins[skin];
    let Some(accessor) = found.inverse_bind_matrices else {
        return Ok(vec![DAffine3::IDENTITY; found.joints.len()]);
    };
    let matrices = file.vectors::<16>(accessor)?;
    if matrices.len() < found.joints.len() {
        let problem = format!("{} for {} joints", matrices.len(), found.joints.len());
        return Err(file.broken(field(), problem));
    }
    let affine = |m: &[f64; 16]| {
        let m = DMat4::from_cols_array(m);
        let last = (m.row(3) - glam::DVec4::W).abs().max_element();
        let sound = last < 1e-6 && m.determinant().abs() > 1e-30;
        sound.then(|| DAffine3::from_mat4(m)).ok_or_else(|| {
            file.broken(
                field(),
                "one has no inverse, or a last row that is not 0 0 0 1",
            )
        })
    };
    matrices
        .iter()
        .take(found.joints.len())
        .map(affine)
        .collect()
}
