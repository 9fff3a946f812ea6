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

impl ReferencePart {
    /// Normals of the vertices in the reference shape, of those that the file has in the mesh's own coordinates: the
    /// planes go with the part, n ∝ A⁻ᵀ n.
    pub fn normals(&self, of_mesh: &[[f64; 3]]) -> Vec<[f32; 3]> {
        let normal = |(n, linear): (&[f64; 3], &DMat3)| {
            let n = cofactor(linear) * DVec3::from_array(*n);
            let sign = if linear.determinant() < 0.0 {
                -1.0
            } else {
                1.0
            };
            (sign * n.normalize_or_zero()).as_vec3().to_array()
        };
        of_mesh.iter().zip(&self.linear).map(normal).collect()
    }

    /// Tangents of the vertices in the reference shape, of those that the file has in the mesh's own coordinates.
    pub fn tangents(&self, of_mesh: &[[f64; 4]]) -> Vec<[f32; 4]> {
        let tangent = |(&[x, y, z, sign], linear): (&[f64; 4], &DMat3)| {
            let tangent = (*linear * DVec3::new(x, y, z)).normalize_or_zero();
            // A mirror turns n × t the other way round.
            let sign = sign * linear.determinant();
            let sign = if sign < 0.0 { -1.0 } else { 1.0 };
            let [x, y, z] = tangent.as_vec3().to_array();
            [x, y, z, sign]
        };
        of_mesh.iter().zip(&self.linear).map(tangent).collect()
    }
}

/// det(A) A⁻ᵀ, also where A is singular: its columns are cross products of those of A.
fn cofactor(a: &DMat3) -> DMat3 {
    let [x, y, z] = [a.x_axis, a.y_axis, a.z_axis];
    DMat3::from_cols(y.cross(z), z.cross(x), x.cross(y))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The bitangent is where the map takes it, also through a mirror.
    #[test]
    fn tangents_go_with_their_part() {
        let turn = DMat3::from_rotation_z(1.0) * DMat3::from_diagonal(DVec3::splat(3.0));
        let mirror = turn * DMat3::from_diagonal(DVec3::new(1.0, -1.0, 1.0));
        let (normal, tangent) = (DVec3::Z, DVec3::X);
        for (linear, sign) in [(turn, 1.0), (turn, -1.0), (mirror, 1.0), (mirror, -1.0)] {
            let part = ReferencePart {
                positions: Vec::new(),
                skinning: Vec::new(),
                linear: vec![linear],
                mirrored: false,
                cancelled: 0,
            };
            let [x, y, z] = tangent.to_array();
            let [[x, y, z, w]] = part.tangents(&[[x, y, z, sign]])[..] else {
                panic!("one tangent");
            };
            let moved = glam::Vec3::new(x, y, z).as_dvec3();
            assert!(moved.distance((linear * tangent).normalize()) < 1e-6);
            let normal = (linear.inverse().transpose() * normal).normalize();
            let bitangent = f64::from(w) * normal.cross(moved);
            let want = (linear * (sign * DVec3::Z.cross(tangent))).normalize();
            assert!(bitangent.distance(want) < 1e-6, "{bitangent} {want}");
        }
    }
}
