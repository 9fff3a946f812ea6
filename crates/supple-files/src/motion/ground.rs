//! Moves over the ground: turns about the vertical, and shifts.

use glam::{DMat3, DQuat, DVec3};
use supple::model::Frame;

/// x ↦ turn x + shift, `turn` about the vertical.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct GroundMove {
    turn: DMat3,
    shift: DVec3,
}

impl GroundMove {
    pub const NONE: Self = Self {
        turn: DMat3::IDENTITY,
        shift: DVec3::ZERO,
    };

    /// Brings `from` over (not up or down to) `to`, with the same heading: what is left between their
    /// rotations has no part about `up`.
    pub fn between(from: &Frame, to: &Frame, up: DVec3) -> Self {
        let q = DQuat::from_mat3(&(to.rotation * from.rotation.transpose()));
        // The twist of the swing–twist decomposition; none where the swing is half a turn.
        let twist = DQuat::from_xyzw(
            up.x * q.xyz().dot(up),
            up.y * q.xyz().dot(up),
            up.z * q.xyz().dot(up),
            q.w,
        );
        let turn = match twist.length() > 1e-9 {
            true => DMat3::from_quat(twist.normalize()),
            false => DMat3::IDENTITY,
        };
        let shift = to.position - turn * from.position;
        Self {
            turn,
            shift: shift - up * shift.dot(up),
        }
    }

    /// The same, raised.
    pub fn raised(self, by: DVec3) -> Self {
        Self {
            shift: self.shift + by,
            ..self
        }
    }

    pub fn apply(&self, frame: &Frame) -> Frame {
        Frame {
            rotation: self.turn * frame.rotation,
            position: self.turn * frame.position + self.shift,
        }
    }

    /// First `other`, then this.
    fn after(&self, other: &Self) -> Self {
        Self {
            turn: self.turn * other.turn,
            shift: self.turn * other.shift + self.shift,
        }
    }

    /// It, `count` times.
    pub fn repeated(&self, mut count: u64) -> Self {
        let (mut result, mut square) = (Self::NONE, *self);
        while count > 0 {
            if count & 1 == 1 {
                result = square.after(&result);
            }
            square = square.after(&square);
            count >>= 1;
        }
        result
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use supple::internal::math::rotation_exp;

    #[test]
    fn headings_meet_and_heights_stay() {
        let from = Frame {
            rotation: rotation_exp(DVec3::Z * 0.4),
            position: DVec3::new(1.0, 2.0, 3.0),
        };
        let to = Frame {
            rotation: rotation_exp(DVec3::Z * 2.4),
            position: DVec3::new(-1.0, 0.0, 9.0),
        };
        let moved = GroundMove::between(&from, &to, DVec3::Z).apply(&from);
        assert!((moved.position - DVec3::new(-1.0, 0.0, 3.0)).length() < 1e-14);
        assert!((moved.rotation.x_axis - to.rotation.x_axis).length() < 1e-14);
    }

    #[test]
    fn repeated_is_one_after_the_other() {
        let step = GroundMove {
            turn: rotation_exp(DVec3::Y * 0.3),
            shift: DVec3::X,
        };
        let mut expected = GroundMove::NONE;
        for count in 0..12 {
            let found = step.repeated(count);
            assert!((found.shift - expected.shift).length() < 1e-13, "{count}");
            assert!((found.turn.x_axis - expected.turn.x_axis).length() < 1e-13);
            expected = step.after(&expected);
        }
    }
}
