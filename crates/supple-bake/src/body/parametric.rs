//! The parametric skeletal model (SMPL, MANO and their like): equation (1) of the method.

use glam::{DMat3, DVec3};
use supple::internal::features::pose_feature;
use supple::internal::math::Rows;
use supple::model::{Frame, Skeleton, SkinWeight};

/// A linear-blend-skinned surface with shape and pose blend shapes.
///
/// `S(β, θ) = W(T + B_S(β) + B_P(θ), J(β), θ)`; Loper et al. 2015, Romero et al. 2017.
#[derive(Clone, Debug, PartialEq)]
pub struct ParametricModel {
    /// Vertices of the template, m.
    pub template: Vec<DVec3>,
    /// Triangles, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// Shape directions: `shape_directions[k][v]`, m per unit of β_k.
    pub shape_directions: Vec<Vec<DVec3>>,
    /// Pose directions: `pose_directions[k][v]`, m per unit of feature k; 9 (bones − 1) or none.
    pub pose_directions: Vec<Vec<DVec3>>,
    /// Bones of each vertex.
    pub weights: Rows<SkinWeight>,
    /// Joint regressor: vertices of each joint with their share.
    pub joint_regressor: Rows<(u32, f64)>,
    /// Parent of each bone.
    pub parents: Vec<Option<u32>>,
    /// Name of each bone.
    pub names: Vec<String>,
}

impl ParametricModel {
    /// T + B_S(β); missing betas are 0.
    pub fn shaped(&self, betas: &[f64]) -> Vec<DVec3> {
        let mut vertices = self.template.clone();
        for (beta, direction) in betas.iter().zip(&self.shape_directions) {
            vertices
                .iter_mut()
                .zip(direction)
                .for_each(|(v, d)| *v += *beta * *d);
        }
        vertices
    }

    /// J(β), from the shaped vertices.
    pub fn joints(&self, shaped: &[DVec3]) -> Vec<DVec3> {
        self.joint_regressor
            .iter()
            .map(|row| row.iter().map(|&(v, w)| w * shaped[v as usize]).sum())
            .collect()
    }

    /// The skeleton of shape β.
    pub fn skeleton(&self, betas: &[f64]) -> Skeleton {
        let joints = self.joints(&self.shaped(betas));
        Skeleton {
            aliases: Vec::new(),
            limits: Vec::new(),
            names: self.names.clone(),
            parents: self.parents.clone(),
            joints,
        }
    }

    /// x̄ = T + B_S(β) + B_P(θ), with θ given by world frames.
    pub fn unposed(&self, betas: &[f64], frames: &[Frame]) -> Vec<DVec3> {
        let mut vertices = self.shaped(betas);
        let feature = pose_feature(&self.parents, frames);
        for (value, direction) in feature.iter().zip(&self.pose_directions) {
            vertices
                .iter_mut()
                .zip(direction)
                .for_each(|(v, d)| *v += *value * *d);
        }
        vertices
    }

    /// S(β, θ): skinned vertices for rotations relative to the parents, the root joint staying at
    /// its reference place plus `translation`.
    pub fn evaluate(
        &self,
        betas: &[f64],
        local_rotations: &[DMat3],
        translation: DVec3,
    ) -> Vec<DVec3> {
        let skeleton = self.skeleton(betas);
        let frames = skeleton.forward_kinematics(local_rotations, skeleton.joints[0] + translation);
        let unposed = self.unposed(betas, &frames);
        let skin = |(x, row): (&DVec3, &[SkinWeight])| {
            row.iter()
                .map(|w| {
                    let j = w.bone as usize;
                    w.weight * frames[j].transform(*x - skeleton.joints[j])
                })
                .sum()
        };
        unposed.iter().zip(self.weights.iter()).map(skin).collect()
    }
}
