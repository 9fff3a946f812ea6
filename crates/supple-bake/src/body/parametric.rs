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
    /// Where the joints are.
    pub joints: Joints,
    /// Parent of each bone.
    pub parents: Vec<Option<u32>>,
    /// Name of each bone.
    pub names: Vec<String>,
}

/// Joints of a shape.
#[derive(Clone, Debug, PartialEq)]
pub enum Joints {
    /// Joint regressor: vertices of each joint with their share.
    Regressor(Rows<(u32, f64)>),
    /// Places, and how shapes move them.
    Given {
        /// Joints of the template, m.
        template: Vec<DVec3>,
        /// `directions[k][j]`, m per unit of β_k; joints that are given for one shape have none.
        directions: Vec<Vec<DVec3>>,
    },
}

impl ParametricModel {
    /// T + B_S(β); missing betas are 0.
    pub fn shaped(&self, betas: &[f64]) -> Vec<DVec3> {
        along(&self.template, betas, &self.shape_directions)
    }

    /// J(β).
    pub fn joints(&self, betas: &[f64]) -> Vec<DVec3> {
        match &self.joints {
            Joints::Regressor(rows) => {
                let shaped = self.shaped(betas);
                let part = |&(v, share): &(u32, f64)| share * shaped[v as usize];
                rows.iter().map(|row| row.iter().map(part).sum()).collect()
            }
            Joints::Given {
                template,
                directions,
            } => along(template, betas, directions),
        }
    }

    /// The skeleton of shape β.
    pub fn skeleton(&self, betas: &[f64]) -> Skeleton {
        let joints = self.joints(betas);
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

/// Points plus Σ β_k direction_k.
fn along(points: &[DVec3], betas: &[f64], directions: &[Vec<DVec3>]) -> Vec<DVec3> {
    let mut moved = points.to_vec();
    for (beta, direction) in betas.iter().zip(directions) {
        let both = moved.iter_mut().zip(direction);
        both.for_each(|(p, d)| *p += *beta * *d);
    }
    moved
}
