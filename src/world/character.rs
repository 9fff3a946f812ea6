//! One avatar that stands in a world: what drives it, between steps.

use crate::model::{Avatar, Frame, State};
use crate::potential::TissueFactors;
use crate::sim::{Instance, InstanceReport, Pin, Settings};
use crate::skeleton::{Spring, Tracking};
use crate::{Error, Result};
use glam::{DVec3, Mat4};
use serde::{Deserialize, Serialize};
use std::borrow::{Borrow, BorrowMut};
use std::sync::Arc;

/// What moves the bones of a [`Character`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[non_exhaustive]
pub enum Driving {
    /// The root is held where it is put, and springs keep the bind pose: nothing has been said.
    #[default]
    Held,
    /// All bones follow the host's exactly.
    Followed,
    /// Springs draw all bones to the host's.
    Drawn,
    /// Nothing does: it falls, its joints limited and bent by their springs.
    Ragdoll,
}

/// An avatar that stands in a [`World`](super::World).
///
/// What is written here counts from the next step on. On error everything stays as it was.
#[derive(Clone, Debug)]
pub struct Character {
    pub(super) avatar: Arc<Avatar>,
    pub(super) instance: Instance,
    driving: Driving,
    /// Stiffness of each joint's spring that holds the bind pose, N·m/rad.
    pose_stiffness: Arc<[f64]>,
    /// Where the asset's own space is in the world.
    placement: Frame,
    pub(super) report: InstanceReport,
    /// Memory of frames that are being checked.
    frames: Vec<Frame>,
    /// Whether the host has it take part.
    pub(super) awake: bool,
}

impl Borrow<Instance> for Character {
    fn borrow(&self) -> &Instance {
        &self.instance
    }
}

impl BorrowMut<Instance> for Character {
    fn borrow_mut(&mut self) -> &mut Instance {
        &mut self.instance
    }
}

impl Character {
    /// At rest with its asset's space at `placement`.
    pub(super) fn new(
        avatar: &Arc<Avatar>,
        settings: &Settings,
        gravity: DVec3,
        pose_stiffness: &Arc<[f64]>,
        placement: &Frame,
    ) -> Self {
        let mut instance = Instance::new(avatar, settings);
        instance.gravity = gravity;
        let mut out = Self {
            avatar: avatar.clone(),
            instance,
            driving: Driving::Held,
            pose_stiffness: pose_stiffness.clone(),
            placement: *placement,
            report: InstanceReport::default(),
            frames: Vec::new(),
            awake: true,
        };
        out.hold();
        out.reset();
        out
    }

    /// The asset.
    pub fn avatar(&self) -> &Avatar {
        &self.avatar
    }

    /// What moves its bones.
    pub fn driving(&self) -> Driving {
        self.driving
    }

    /// What the last step said of it.
    pub fn report(&self) -> &InstanceReport {
        &self.report
    }

    /// Frames of its bones, in world space.
    pub fn frames(&self) -> &[Frame] {
        &self.instance.state.frames[..self.bones()]
    }

    /// Displacements φ of its handles in unposed space, m.
    pub fn handles(&self) -> &[DVec3] {
        &self.instance.state.handles
    }

    /// Where the asset's own space was put, see [`Character::teleport_to`].
    pub fn placement(&self) -> Frame {
        self.placement
    }

    /// What the layer below knows of it.
    pub fn instance(&self) -> &Instance {
        &self.instance
    }

    /// Ranges of joints, springs and targets, for those who know the layer below: its frames, and what drives its pose,
    /// are this type's own.
    pub fn instance_mut(&mut self) -> &mut Instance {
        &mut self.instance
    }

    fn bones(&self) -> usize {
        self.avatar.bones()
    }

    /// All bones follow the world matrices of the avatar's joints, as the host's animation has them at the end of the
    /// next step: one for each entry of [`Avatar::joints`], in its order.
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
        self.driving = Driving::Followed;
        Ok(())
    }

    /// Springs draw all bones to `frames`, one for each of [`Character::frames`]; so the bones give way to what they
    /// meet. `rotation` in N·m/rad and N·m·s, `position` in N/m and N·s/m.
    ///
    /// # Errors
    /// A wrong count, or a frame that is not rigid.
    pub fn draw_to_frames(
        &mut self,
        frames: &[Frame],
        rotation: Spring,
        position: Spring,
    ) -> Result<()> {
        self.check(frames)?;
        let again = self.driving == Driving::Drawn;
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
        self.driving = Driving::Drawn;
        Ok(())
    }

    /// The root is held where it was put, and springs keep the bind pose: so a character stands of which nothing else is
    /// said. Each joint's spring gives way to the weight that hangs on it by a degree at most.
    pub fn hold(&mut self) {
        let root = self.rest_frame(0);
        let instance = &mut self.instance;
        instance.targets.clear();
        instance.pins.clear();
        (instance.pins).push(Pin {
            bone: 0,
            frame: root,
        });
        let bending = instance.bending.iter_mut().zip(&*self.pose_stiffness);
        bending.for_each(|(bending, &stiffness)| bending.stiffness = stiffness);
        self.driving = Driving::Held;
    }

    /// Nothing drives it: it falls. Joints keep their ranges, and bend against springs of `bending_stiffness`, N·m/rad.
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
        (instance.bending.iter_mut()).for_each(|bending| bending.stiffness = bending_stiffness);
        self.driving = Driving::Ragdoll;
        Ok(())
    }

    /// Moves it, with all that drives it, so that its asset's own space stands at `placement`: nothing of that is felt.
    ///
    /// # Errors
    /// A placement that is not rigid.
    pub fn teleport_to(&mut self, placement: &Frame) -> Result<()> {
        rigid("placement", placement)?;
        let old = self.placement;
        let back = Frame {
            rotation: old.rotation.transpose(),
            position: old.inverse_transform(DVec3::ZERO),
        };
        let motion = placement.compose(&back);
        let bones = self.bones();
        let instance = &mut self.instance;
        let move_frame =
            |frame: &mut Frame| *frame = motion.compose(frame).moved(DVec3::ZERO, DVec3::ZERO);
        for state in [&mut instance.state, &mut instance.previous] {
            state.frames[..bones].iter_mut().for_each(move_frame);
        }
        (instance.pins.iter_mut()).for_each(|pin| move_frame(&mut pin.frame));
        for target in &mut instance.targets {
            move_frame(&mut target.frame);
            move_frame(&mut target.previous);
        }
        self.placement = *placement;
        Ok(())
    }

    /// Puts it where it is driven to, at rest with no displacement.
    pub fn reset(&mut self) {
        self.snap();
        let state = &mut self.instance.state;
        state.handles.fill(DVec3::ZERO);
        self.instance.previous.clone_from(state);
    }

    /// From the next step on its tissue does not move: the bones go on following what drives them.
    pub fn sleep(&mut self) {
        self.awake = false;
    }

    /// Its tissue moves again, from where it was and at rest against the bones.
    pub fn wake(&mut self) {
        if !self.awake {
            let instance = &mut self.instance;
            instance
                .previous
                .handles
                .clone_from(&instance.state.handles);
        }
        self.awake = true;
    }

    /// Whether its tissue moves, see [`Character::sleep`].
    pub fn is_awake(&self) -> bool {
        self.awake
    }

    /// Factors of the tissue's stiffness, damping, gravity and friction from the next step on; 1 is as it was baked.
    ///
    /// # Errors
    /// A factor that is unusable.
    pub fn set_factors(&mut self, factors: TissueFactors) -> Result<()> {
        factors.validate()?;
        self.instance.factors = factors;
        Ok(())
    }

    /// The world matrices of the avatar's joints as they are simulated, in the order of [`Avatar::joints`].
    ///
    /// # Errors
    /// None: there are as many frames as bones.
    pub fn joint_matrices(&self, out: &mut Vec<Mat4>) -> Result<()> {
        self.avatar.joints.joint_matrices(self.frames(), out)
    }

    /// Where the driver wants bone `j` of the bind pose.
    fn rest_frame(&self, bone: usize) -> Frame {
        let joint = self.avatar.skeleton.joints[bone];
        Frame {
            rotation: self.placement.rotation,
            position: self.placement.transform(joint),
        }
    }

    /// Puts the bones where they are driven to: the bind pose where nothing says more. Velocities are the host's to
    /// set again.
    pub(super) fn snap(&mut self) {
        for bone in 0..self.bones() {
            self.instance.state.frames[bone] = match self.driving {
                Driving::Held | Driving::Ragdoll => self.rest_frame(bone),
                Driving::Followed => self.instance.pins[bone].frame,
                Driving::Drawn => self.instance.targets[bone].frame,
            };
        }
    }

    /// A step of one that sleeps: the bones follow, the tissue rides on them.
    pub(super) fn ride(&mut self) {
        let instance = &mut self.instance;
        instance.previous.clone_from(&instance.state);
        if matches!(self.driving, Driving::Followed | Driving::Drawn) {
            self.snap();
        }
        for target in &mut self.instance.targets {
            target.previous = target.frame;
        }
    }

    /// A step too long to be one: the bones are where they are driven to, at rest.
    pub(super) fn jump(&mut self) {
        if matches!(self.driving, Driving::Followed | Driving::Drawn) {
            self.snap();
        }
        let instance = &mut self.instance;
        instance.previous.clone_from(&instance.state);
        for target in &mut instance.targets {
            target.previous = target.frame;
        }
    }

    /// Gives the frames that stand for bodies room.
    pub(super) fn set_avatar(&mut self, avatar: &Arc<Avatar>) {
        self.avatar = avatar.clone();
        let frames = avatar.skeleton.len();
        let instance = &mut self.instance;
        for state in [&mut instance.state, &mut instance.previous] {
            state.frames.resize(frames, Frame::IDENTITY);
        }
        let bending = instance.bending[0];
        instance.bending.resize(frames, bending);
    }

    /// Sets what a snapshot says of the driver, whose pins and targets are there.
    pub(super) fn restore_driving(
        &mut self,
        driving: Driving,
        placement: &Frame,
        awake: bool,
    ) -> Result<()> {
        rigid("placement", placement)?;
        let (bones, instance) = (self.bones(), &self.instance);
        let pins = instance.pins.iter().map(|pin| pin.bone).eq(0..bones);
        let targets = instance.targets.iter().map(|t| t.bone).eq(0..bones);
        let complete = match driving {
            Driving::Held | Driving::Ragdoll => true,
            Driving::Followed => pins,
            Driving::Drawn => targets,
        };
        if !complete {
            let problem = "does not say where each bone goes";
            return Err(Error::invalid("driver", problem));
        }
        (self.driving, self.placement, self.awake) = (driving, *placement, awake);
        Ok(())
    }

    /// Errors of frames that cannot be followed.
    fn check(&self, frames: &[Frame]) -> Result<()> {
        let names = &self.avatar.skeleton.names;
        if frames.len() != self.bones() {
            let problem = format!("{} given for {} bones", frames.len(), self.bones());
            return Err(Error::invalid("frames", problem));
        }
        for (frame, name) in frames.iter().zip(names) {
            rigid(&format!("frames.{name}"), frame)?;
        }
        Ok(())
    }

    /// The state.
    pub fn state(&self) -> &State {
        &self.instance.state
    }
}

/// An error unless a frame is finite with a rotation.
pub(super) fn rigid(field: &str, frame: &Frame) -> Result<()> {
    if frame.is_rigid() {
        return Ok(());
    }
    let problem = format!("{frame:?} is not finite, or its rotation is none");
    Err(Error::invalid(field, problem))
}

/// Stiffness of the springs that keep each joint as it is bound, N·m/rad: the weight of what hangs on it, on the longest
/// lever that it has, turns it by [`SAG`] at most. What hangs on a joint is its own bone's matter and its descendants'.
pub(super) fn pose_stiffness(avatar: &Avatar) -> Arc<[f64]> {
    /// rad.
    const SAG: f64 = 0.01;
    const GRAVITY: f64 = 9.81;
    let (skeleton, bones) = (&avatar.skeleton, avatar.bones());
    // Mass and first moment about the file's origin.
    let mut matter = vec![(0.0, DVec3::ZERO); skeleton.len()];
    for (j, mass) in avatar.bone_masses.iter().enumerate() {
        let (total, first) = mass.moments();
        matter[j] = (total, first + total * skeleton.joints[j]);
    }
    let cubature = &avatar.cubature;
    for i in 0..cubature.len() {
        for weight in cubature.skinning.row(i) {
            let mass = avatar.density * cubature.measure[i] * weight.weight;
            let (total, first) = &mut matter[weight.bone as usize];
            *total += mass;
            *first += mass * cubature.position[i];
        }
    }
    for j in (0..bones).rev() {
        if let Some(parent) = skeleton.parents[j] {
            let (mass, first) = matter[j];
            let (total, of_all) = &mut matter[parent as usize];
            *total += mass;
            *of_all += first;
        }
    }
    let stiffness = |(&(mass, first), joint): (&(f64, DVec3), &DVec3)| {
        let lever = (first - mass * *joint).length();
        lever * GRAVITY / SAG
    };
    matter.iter().zip(&skeleton.joints).map(stiffness).collect()
}
