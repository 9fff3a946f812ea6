//! What drives a character: its host's bones, springs, its bind pose, or nothing.

use super::character::{Character, Driving};
use crate::model::Frame;
use crate::sim::{Pin, SkinSpring};
use crate::skeleton::{Preload, Spring, Tracking};
use crate::{Error, Result};
use glam::Mat4;

impl Character {
    /// All bones follow the world matrices of the avatar's joints, as the host's animation has them at the end of the
    /// next step: one for each of `avatar().joints`, in that order. What is said before the first step is where it starts.
    ///
    /// # Errors
    /// A wrong count; a matrix that is not finite, scales by more than 1e-3, shears or mirrors.
    pub fn follow_world(&mut self, joints: &[Mat4]) -> Result<()> {
        let mut frames = std::mem::take(&mut self.frames);
        let avatar = &self.avatar;
        let read = avatar
            .joints
            .frames_from_world(&avatar.skeleton, joints, &mut frames);
        let followed = read.and_then(|()| self.follow_frames(&frames));
        self.frames = frames;
        followed
    }

    /// [`Character::follow_world`] with the skinning matrices of a skin of the avatar's file: those that the host's
    /// shader multiplies the skin's vertices by.
    ///
    /// # Errors
    /// As [`Character::follow_world`], and of a skin that is not there.
    pub fn follow_skinning(&mut self, skin: usize, matrices: &[Mat4]) -> Result<()> {
        let mut frames = std::mem::take(&mut self.frames);
        let avatar = &self.avatar;
        let joints = &avatar.joints;
        let read = joints.frames_from_skinning(&avatar.skeleton, skin, matrices, &mut frames);
        let followed = read.and_then(|()| self.follow_frames(&frames));
        self.frames = frames;
        followed
    }

    /// All bones follow `frames`, one for each of [`Character::frames`], exactly.
    ///
    /// # Errors
    /// A wrong count, or a frame that is not rigid.
    pub fn follow_frames(&mut self, frames: &[Frame]) -> Result<()> {
        self.check(frames)?;
        let instance = &mut self.instance;
        instance.targets.clear();
        instance.pins.clear();
        let pins = frames.iter().enumerate();
        (instance.pins).extend(pins.map(|(bone, &frame)| Pin { bone, frame }));
        self.drive_by(Driving::Followed);
        Ok(())
    }

    /// Springs pull all bones to `frames`, one for each of [`Character::frames`]; so the bones give way to what they
    /// meet. `rotation` in N·m/rad and N·m·s, `position` in N/m and N·s/m.
    ///
    /// # Errors
    /// A wrong count, or a frame that is not rigid.
    pub fn track_frames(
        &mut self,
        frames: &[Frame],
        rotation: Spring,
        position: Spring,
    ) -> Result<()> {
        self.check(frames)?;
        let again = self.driving == Driving::Tracked;
        let instance = &mut self.instance;
        instance.pins.clear();
        if !again {
            let current = &instance.state.frames;
            instance.targets.clear();
            let target = |(bone, &frame): (usize, &Frame)| Tracking::new(bone, frame);
            (instance.targets).extend(current[..frames.len()].iter().enumerate().map(target));
        }
        for (target, &frame) in instance.targets.iter_mut().zip(frames) {
            target.frame = frame;
            (target.rotation, target.position) = (Some(rotation), Some(position));
        }
        self.drive_by(Driving::Tracked);
        Ok(())
    }

    /// Adds `offsets` to the skin's rest shape from the next step on: what a model of the host's own (a network, corrective
    /// shapes, morph targets) says of the pose, in addition to the avatar's own pose blend shapes. They are m in the axes of
    /// the bind pose, one for each vertex of `avatar().skin`; the tissue below follows. An empty list takes them away.
    ///
    /// Where nothing touches or moves it, the drawn skin is the skinned X + B_P + offset. New offsets change the shape and
    /// are no motion: they have no inertia, and no friction.
    ///
    /// # Errors
    /// A wrong count; an offset that is not finite, or longer than the skin is large; an avatar that was baked without
    /// [`Avatar::pose_extension`](crate::model::Avatar::pose_extension). The offsets stay what they were.
    pub fn set_pose_offsets(&mut self, offsets: &[[f32; 3]]) -> Result<()> {
        self.instance.pose_offsets.set(&self.avatar, offsets)
    }

    /// Lets bones that follow or are tracked begin on their way to `next`, where they are to be at the end of the next step of
    /// `time_step`, s: as fast as a motion has them there that was on its way before. Without it the first step is one from
    /// rest, which a motion that sets in at full speed makes a blow. It is for after the first frames, and after
    /// [`Character::reset`].
    ///
    /// # Errors
    /// As [`Character::follow_frames`]; a time step that is not positive; bones that nothing drives.
    pub fn begin_moving(&mut self, next: &[Frame], time_step: f64) -> Result<()> {
        self.check(next)?;
        if !(time_step > 0.0 && time_step.is_finite()) {
            let problem = format!("{time_step} is not a positive number of seconds");
            return Err(Error::invalid("time_step", problem));
        }
        if !matches!(self.driving, Driving::Followed | Driving::Tracked) {
            let problem = "nothing drives the bones: say where they are first, by follow_frames or track_frames";
            return Err(Error::invalid("frames", problem));
        }
        let instance = &mut self.instance;
        for (bone, next) in next.iter().enumerate() {
            let now = instance.state.frames[bone];
            let (shift, turn) = now.motion_to(next);
            instance.set_motion(bone, now, shift / time_step, turn / time_step);
            if let Some(pin) = instance.pins.get_mut(bone) {
                pin.frame = *next;
            }
            if let Some(target) = instance.targets.get_mut(bone) {
                (target.frame, target.previous) = (*next, now);
                target.earlier = now.moved(-shift, -turn);
            }
        }
        Ok(())
    }

    /// Springs pull points of the skin, and with them flesh and bones, from the next step on and until others are said; an empty
    /// list lets go. Bones give way as far as what drives them lets them: not at all where they follow.
    pub fn pull_skin(&mut self, springs: &[SkinSpring]) {
        self.instance.skin_springs.clear();
        self.instance.skin_springs.extend_from_slice(springs);
    }

    /// What moves the bones from now on; before the first step it says where they start as well.
    fn drive_by(&mut self, driving: Driving) {
        self.set_driving(driving);
        if self.fresh {
            self.reset();
        }
    }

    /// Says what moves the bones, and so whose springs carry their weight.
    fn set_driving(&mut self, driving: Driving) {
        self.driving = driving;
        self.instance.preload = match driving {
            Driving::Held => Preload::Pose,
            Driving::Followed | Driving::Tracked => Preload::Targets,
            Driving::Ragdoll => Preload::Off,
        };
    }

    /// The root is held where it was put, and springs keep the bind pose: so a character stands of which nothing else is
    /// said. Each joint's spring gives way to the weight that hangs on it by 0.06° at most, and does not swing.
    pub fn hold(&mut self) {
        let root = self.rest_frame(0);
        let instance = &mut self.instance;
        instance.targets.clear();
        instance.pins.clear();
        (instance.pins).push(Pin {
            bone: 0,
            frame: root,
        });
        for (bending, spring) in instance.bending.iter_mut().zip(&*self.pose_springs) {
            (bending.stiffness, bending.damping) = (spring.stiffness, spring.damping);
        }
        self.set_driving(Driving::Held);
    }

    /// Nothing drives it: it falls. Joints keep their ranges, and bend against springs of `bending_stiffness`, N·m/rad, and
    /// against dampers that let a limb of any weight swing out as a relaxed person's does.
    ///
    /// # Errors
    /// A stiffness that is neither 0 nor positive.
    pub fn ragdoll(&mut self, bending_stiffness: f64) -> Result<()> {
        if !(bending_stiffness >= 0.0 && bending_stiffness.is_finite()) {
            let problem =
                format!("{bending_stiffness} is neither 0 nor a positive number of N·m/rad");
            return Err(Error::invalid("bending_stiffness", problem));
        }
        let instance = &mut self.instance;
        instance.targets.clear();
        instance.pins.clear();
        for (bending, spring) in instance.bending.iter_mut().zip(&*self.pose_springs) {
            (bending.stiffness, bending.damping) = (bending_stiffness, spring.relaxed_damping);
        }
        self.set_driving(Driving::Ragdoll);
        Ok(())
    }
}
