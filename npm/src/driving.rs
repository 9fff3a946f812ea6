//! What moves the bones.

use crate::avatar::{Core, frame, now};
use crate::error::{OrThrow, Thrown, invalid};
use supple::glam::{DMat4, Mat4};
use supple::model::Frame;
use supple::skeleton::{Preload, Spring, Tracking};
use supple::world::Driving;
use wasm_bindgen::prelude::*;

/// k and d.
fn spring(values: &[f64], field: &str) -> Thrown<Option<Spring>> {
    match *values {
        [] => Ok(None),
        [stiffness, damping] => Ok(Some(Spring { stiffness, damping })),
        _ => Err(invalid(field, "is a stiffness and a damping")),
    }
}

impl Core {
    /// Reads matrices, column by column, into memory that stays.
    fn read_matrices(&mut self, numbers: &[f32]) -> Thrown<Vec<Mat4>> {
        let (columns, rest) = numbers.as_chunks::<16>();
        if !rest.is_empty() {
            let problem = format!(
                "has {} numbers; hand in 16 a joint, column by column",
                numbers.len()
            );
            return Err(invalid("matrices", problem));
        }
        let mut matrices = std::mem::take(&mut self.matrices);
        matrices.clear();
        matrices.extend(columns.iter().map(Mat4::from_cols_array));
        Ok(matrices)
    }

    fn joint_bone(&self, joint: usize) -> Thrown<usize> {
        let joints = self.avatar.joints.joints();
        let joint = joints.get(joint).ok_or_else(|| {
            let problem = format!("there is no joint {joint}; there are {}", joints.len());
            invalid("joint", problem)
        })?;
        Ok(joint.bone.bone())
    }
}

#[wasm_bindgen]
impl Core {
    /// All bones follow world matrices of the joints.
    pub fn follow(&mut self, matrices: &[f32]) -> Thrown<()> {
        let matrices = self.read_matrices(matrices)?;
        let done = self.character()?.follow_world(&matrices).or_throw();
        self.matrices = matrices;
        done
    }

    /// All bones follow the skinning matrices of one of the file's skins.
    pub fn follow_skinning(&mut self, skin: usize, matrices: &[f32]) -> Thrown<()> {
        let matrices = self.read_matrices(matrices)?;
        let done = (self.character()?)
            .follow_skinning(skin, &matrices)
            .or_throw();
        self.matrices = matrices;
        done
    }

    /// Springs draw all bones to world matrices of the joints. k and d of rotations and places.
    pub fn track(&mut self, matrices: &[f32], rotation: &[f64], position: &[f64]) -> Thrown<()> {
        let rotation = spring(rotation, "rotation")?;
        let position = spring(position, "position")?;
        let (Some(rotation), Some(position)) = (rotation, position) else {
            return Err(invalid("springs", "both are needed: rotation and position"));
        };
        let matrices = self.read_matrices(matrices)?;
        let mut frames = Vec::new();
        let read = (self.avatar.joints)
            .frames_from_world(&self.avatar.skeleton, &matrices, &mut frames)
            .or_throw();
        self.matrices = matrices;
        read?;
        (self.character()?)
            .track_frames(&frames, rotation, position)
            .or_throw()
    }

    /// The root is held, and springs keep the bind pose.
    pub fn hold(&mut self) -> Thrown<()> {
        self.character()?.hold();
        Ok(())
    }

    /// Nothing drives it. Joints bend against a stiffness, N·m/rad, and a damping, N·m·s, which is a relaxed person's where none is
    /// given.
    pub fn ragdoll(&mut self, stiffness: f64, damping: Option<f64>) -> Thrown<()> {
        let character = self.character()?;
        character.ragdoll(stiffness).or_throw()?;
        if let Some(damping) = damping {
            if !(damping >= 0.0 && damping.is_finite()) {
                let problem = format!("{damping} is neither 0 nor a positive number of N·m·s");
                return Err(invalid("damping", problem));
            }
            let bending = &mut character.instance_mut().bending;
            bending.iter_mut().for_each(|b| b.damping = damping);
        }
        Ok(())
    }

    /// Springs draw the bone of a joint to where the joint is to be, whose world matrix is given column by column; one that
    /// has both springs bears its own weight. Besides `hold` and `ragdoll` only.
    pub fn pull(
        &mut self,
        joint: usize,
        matrix: &[f64],
        rotation: &[f64],
        position: &[f64],
    ) -> Thrown<()> {
        let bone = self.joint_bone(joint)?;
        let Ok(columns) = <&[f64; 16]>::try_from(matrix) else {
            let problem = format!("has {} numbers; hand in 16", matrix.len());
            return Err(invalid("matrix", problem));
        };
        let bind = DMat4::from(self.avatar.joints.joints()[joint].bind);
        let moved = DMat4::from_cols_array(columns) * bind.inverse();
        let (scale, rotated, place) = moved.to_scale_rotation_translation();
        if !(moved.is_finite() && (scale - 1.0).abs().max_element() < 1e-3) {
            let problem = "scales, shears, mirrors or is not finite; hand in a rigid motion of the joint as the file has it";
            return Err(invalid("matrix", problem));
        }
        let quaternion = rotated.normalize().to_array();
        let frame: Frame = frame(&place.to_array(), &quaternion)?;
        let rotation = spring(rotation, "rotation")?;
        let position = spring(position, "position")?;
        let character = self.character()?;
        if matches!(character.driving(), Driving::Followed | Driving::Tracked) {
            let problem = "all bones follow the page's; call hold() or ragdoll() first";
            return Err(invalid("pull", problem));
        }
        let instance = character.instance_mut();
        if matches!(instance.preload, Preload::Off) {
            instance.preload = Preload::Targets;
        }
        let known = instance.targets.iter_mut().find(|t| t.bone == bone);
        match known {
            Some(target) => {
                target.frame = frame;
                (target.rotation, target.position) = (rotation, position);
            }
            None => {
                let at = instance.state.frames[bone];
                let mut target = Tracking::new(bone, at);
                target.frame = frame;
                (target.rotation, target.position) = (rotation, position);
                instance.targets.push(target);
            }
        }
        Ok(())
    }

    /// Takes the springs of a joint's bone away.
    pub fn release(&mut self, joint: usize) -> Thrown<()> {
        let bone = self.joint_bone(joint)?;
        let targets = &mut self.character()?.instance_mut().targets;
        targets.retain(|target| target.bone != bone);
        Ok(())
    }

    /// Puts the file's own space elsewhere, with all that drives it; nothing of that is felt.
    pub fn teleport(&mut self, position: &[f64], rotation: &[f64]) -> Thrown<()> {
        let placement = frame(position, rotation)?;
        let standing = self.avatar.standing(self.world.up());
        let character = self.character()?;
        character
            .teleport_to(&placement.compose(&standing))
            .or_throw()?;
        self.pose()
    }

    /// Puts it where it is driven to, at rest.
    pub fn reset(&mut self) -> Thrown<()> {
        self.character()?.reset();
        self.pose()
    }

    /// Brings it into equilibrium with what drives and touches it, at rest; how far that moved it, m.
    pub fn settle(&mut self) -> Thrown<f64> {
        let moved = now(self.world.settle())?;
        self.pose()?;
        Ok(moved)
    }

    /// Whether its tissue moves.
    pub fn set_awake(&mut self, awake: bool) -> Thrown<()> {
        let character = self.character()?;
        match awake {
            true => character.wake(),
            false => character.sleep(),
        }
        Ok(())
    }
}
