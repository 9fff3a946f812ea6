//! Which axis points up, and how what stands along one axis stands along another.

use super::{Avatar, Frame, State};
use glam::{DMat3, DVec3};
use serde::{Deserialize, Serialize};

/// The axis that points up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum UpAxis {
    /// +x.
    X,
    /// +y: glTF, VRM, most BVH files, SMPL's and MANO's templates.
    #[default]
    Y,
    /// +z: AMASS's world, and a scene's unless it says otherwise.
    Z,
}

impl UpAxis {
    /// Its unit vector.
    pub fn direction(self) -> DVec3 {
        match self {
            Self::X => DVec3::X,
            Self::Y => DVec3::Y,
            Self::Z => DVec3::Z,
        }
    }

    /// The rotation that makes what stands along this axis stand along `world`: a quarter turn about the third axis
    /// without rounding, or none.
    ///
    /// With a this axis, b the world's and c = a × b: R = b aᵀ − a bᵀ + c cᵀ.
    pub fn rotation_to(self, world: Self) -> DMat3 {
        let (a, b) = (self.direction(), world.direction());
        if self == world {
            return DMat3::IDENTITY;
        }
        let c = a.cross(b);
        DMat3::from_cols_array_2d(&[0, 1, 2].map(|k| (b * a[k] - a * b[k] + c * c[k]).to_array()))
    }
}

impl Avatar {
    /// The rigid transform of the avatar's own space into a world where `world_up` points up: about the origin of the
    /// character's file, so that soles at height zero of the file stand at height zero of the world.
    pub fn standing(&self, world_up: UpAxis) -> Frame {
        Frame {
            rotation: self.up.rotation_to(world_up),
            position: DVec3::ZERO,
        }
    }

    /// The rest state moved rigidly: `placement` takes the avatar's own space into the world
    /// ([`Avatar::standing`], or further on by [`Frame::compose`]). Rigid bodies, whose places are the world's, stay.
    pub fn placed(&self, placement: &Frame) -> State {
        let mut state = self.rest_state();
        let bones = self.bones();
        (state.frames.iter_mut().take(bones)).for_each(|f| *f = placement.compose(f));
        state
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use UpAxis::{X, Y, Z};

    #[test]
    fn up_becomes_up_by_the_shortest_turn() {
        for from in [X, Y, Z] {
            for to in [X, Y, Z] {
                let turn = from.rotation_to(to);
                assert_eq!(turn * from.direction(), to.direction());
                assert_eq!(turn.transpose() * turn, DMat3::IDENTITY);
                assert_eq!(turn.determinant(), 1.0);
                let trace = turn.x_axis.x + turn.y_axis.y + turn.z_axis.z;
                assert_eq!(trace, if from == to { 3.0 } else { 1.0 });
            }
        }
        // glTF's characters face z; stood up along z they face −y, as Blender has it.
        assert_eq!(Y.rotation_to(Z) * DVec3::Z, DVec3::NEG_Y);
    }
}
