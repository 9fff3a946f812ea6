//! One avatar that stands in a world: what drives it, between steps.

use super::pose_springs::PoseSpring;
use crate::model::{Avatar, Frame, Integrator, State};
use crate::potential::TissueFactors;
use crate::potential::cpu::skin_displacement;
use crate::sim::{Instance, InstanceReport, Settings, SpringMode};
use crate::skeleton::Tracking;
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
    /// Springs pull all bones to the host's.
    Tracked,
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
    pub(super) driving: Driving,
    /// Stiffness of each joint's spring that holds the bind pose, N·m/rad.
    pub(super) pose_springs: Arc<[PoseSpring]>,
    /// Where the asset's own space is in the world.
    placement: Frame,
    pub(super) report: InstanceReport,
    /// Memory of frames that are being checked.
    pub(super) frames: Vec<Frame>,
    /// Whether the host has it take part.
    pub(super) awake: bool,
    /// Whether no step has moved it yet: then the first bones that are said are where it starts.
    pub(super) fresh: bool,
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
        pose_springs: &Arc<[PoseSpring]>,
        placement: &Frame,
    ) -> Self {
        let mut instance = Instance::new(avatar, settings);
        instance.gravity = gravity;
        let mut out = Self {
            avatar: avatar.clone(),
            instance,
            driving: Driving::Held,
            pose_springs: pose_springs.clone(),
            placement: *placement,
            report: InstanceReport::default(),
            frames: Vec::new(),
            awake: true,
            fresh: true,
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

    /// What the last step said of it. On the GPU its energies, contacts and loads of pins are of where the step before
    /// ended, except after the first step: so that nobody waits for them, they come with the next step's results.
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

    /// How far the tissue is off the skinned shape at each vertex of [`Avatar::skin`], before the pose, m: U φ.
    pub fn displacement(&self) -> Vec<DVec3> {
        skin_displacement(&self.avatar, &self.instance.state)
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

    pub(super) fn bones(&self) -> usize {
        self.avatar.bones()
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
        let past = instance.history.states_mut().iter_mut();
        for state in std::iter::once(&mut instance.state).chain(past) {
            state.frames[..bones].iter_mut().for_each(move_frame);
        }
        (instance.pins.iter_mut()).for_each(|pin| move_frame(&mut pin.frame));
        for target in &mut instance.targets {
            move_frame(&mut target.frame);
            move_frame(&mut target.previous);
            move_frame(&mut target.earlier);
        }
        instance.was_put = true;
        self.placement = *placement;
        Ok(())
    }

    /// Puts it where it is driven to, at rest with no displacement.
    pub fn reset(&mut self) {
        self.snap();
        let state = &mut self.instance.state;
        state.handles.fill(DVec3::ZERO);
        self.instance.history.rest(state);
        self.instance.targets.iter_mut().for_each(Tracking::rest);
        self.instance.was_put = true;
    }

    /// From the next step on its tissue does not move: the bones go on following what drives them.
    pub fn sleep(&mut self) {
        self.awake = false;
    }

    /// Its tissue moves again, from where it was and at rest against the bones.
    pub fn wake(&mut self) {
        if !self.awake {
            let instance = &mut self.instance;
            for past in instance.history.states_mut() {
                past.handles.clone_from(&instance.state.handles);
            }
        }
        self.awake = true;
    }

    /// Whether its tissue moves, see [`Character::sleep`].
    pub fn is_awake(&self) -> bool {
        self.awake
    }

    /// Factors of the tissue's stiffness, damping, gravity and friction from the next step on, and the tension of its muscle; 1, and
    /// tension 0, is as it was baked.
    ///
    /// # Errors
    /// A factor that is unusable.
    pub fn set_factors(&mut self, factors: TissueFactors) -> Result<()> {
        factors.validate()?;
        self.instance.factors = factors;
        Ok(())
    }

    /// The share of the root's acceleration that tissue ignores from the next step on, 0 to 1; 0 at first. With 1 a character
    /// that is thrown about as a whole does not swing. Beyond
    /// [`Settings::largest_acceleration`] nothing is felt anyway.
    ///
    /// # Errors
    /// A share that is none.
    pub fn set_inertia_share(&mut self, share: f64) -> Result<()> {
        if !(0.0..=1.0).contains(&share) {
            let problem = format!("{share} is not within 0 and 1");
            return Err(Error::invalid("inertia_share", problem));
        }
        self.instance.inertia_share = share;
        Ok(())
    }

    /// Which spring bones swing from the next step on ([`Avatar::springs`]: hair, skirts, ears, tails). At first
    /// [`SpringMode::Free`]: a host whose matrices [`Character::follow_world`] takes has springs of its own. With
    /// [`SpringMode::All`] its matrices of them say where they are at rest, as those of [`Character::track_frames`] always do.
    pub fn set_spring_mode(&mut self, mode: SpringMode) {
        self.instance.springs = mode;
    }

    /// The world matrices of the avatar's joints as they are simulated, in the order of [`Avatar::joints`].
    ///
    /// # Errors
    /// None: there are as many frames as bones.
    pub fn joint_matrices(&self, out: &mut Vec<Mat4>) -> Result<()> {
        self.avatar.joints.joint_matrices(self.frames(), out)
    }

    /// Where the driver wants bone `j` of the bind pose.
    pub(super) fn rest_frame(&self, bone: usize) -> Frame {
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
                Driving::Tracked => self.instance.targets[bone].frame,
            };
        }
    }

    /// A step of one that sleeps: the bones follow, the tissue rides on them.
    pub(super) fn ride(&mut self, integrator: Integrator, time_step: f64) {
        let instance = &mut self.instance;
        (instance.history).advance(&instance.state, integrator, time_step);
        if matches!(self.driving, Driving::Followed | Driving::Tracked) {
            let mut before = std::mem::take(&mut self.frames);
            before.clone_from(&self.instance.state.frames);
            self.snap();
            self.keep_swing(&before);
            self.frames = before;
        }
        self.instance.targets.iter_mut().for_each(Tracking::advance);
    }

    /// Turns what spring bones carry, them included, against their parents as in `before`.
    fn keep_swing(&mut self, before: &[Frame]) {
        let (avatar, mode) = (&self.avatar, self.instance.springs);
        let parents = &avatar.skeleton.parents;
        let free = mode == SpringMode::Free && self.driving != Driving::Followed;
        if avatar.springs.is_empty() || !(free || mode == SpringMode::All) {
            return;
        }
        let above = |bone: usize| {
            let next = |b: &usize| parents[*b].map(|p| p as usize);
            std::iter::successors(Some(bone), next).take_while(|b| avatar.is_carried(*b))
        };
        let frames = &mut self.instance.state.frames;
        for (bone, parent) in parents.iter().enumerate().take(avatar.bones()) {
            let Some(parent) = parent.map(|p| p as usize) else {
                continue;
            };
            if above(bone).any(|b| avatar.springs.of_bone(b).is_some()) {
                let local = Frame {
                    rotation: before[parent].rotation.transpose() * before[bone].rotation,
                    position: before[parent].inverse_transform(before[bone].position),
                };
                frames[bone] = frames[parent]
                    .compose(&local)
                    .moved(DVec3::ZERO, DVec3::ZERO);
            }
        }
    }

    /// A step too long to be one: the bones are where they are driven to, at rest.
    pub(super) fn jump(&mut self) {
        if matches!(self.driving, Driving::Followed | Driving::Tracked) {
            self.snap();
        }
        let instance = &mut self.instance;
        instance.history.rest(&instance.state);
        instance.was_put = true;
        instance.targets.iter_mut().for_each(Tracking::rest);
    }

    /// Gives the frames that stand for bodies room.
    pub(super) fn set_avatar(&mut self, avatar: &Arc<Avatar>) {
        self.avatar = avatar.clone();
        let frames = avatar.skeleton.len();
        let instance = &mut self.instance;
        let past = instance.history.states_mut().iter_mut();
        for state in std::iter::once(&mut instance.state).chain(past) {
            state.frames.resize(frames, Frame::IDENTITY);
            state.handles.resize(avatar.handles.len(), DVec3::ZERO);
            let more = avatar.fine.slots.saturating_sub(state.awake.len());
            state.awake.reserve(more);
        }
        instance.awake.reserve(avatar);
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
            Driving::Tracked => targets,
        };
        if !complete {
            let problem = "does not say where each bone goes";
            return Err(Error::invalid("driver", problem));
        }
        (self.driving, self.placement, self.awake) = (driving, *placement, awake);
        self.fresh = false;
        Ok(())
    }

    /// Errors of frames that cannot be followed.
    pub(super) fn check(&self, frames: &[Frame]) -> Result<()> {
        let names = &self.avatar.skeleton.names;
        if frames.len() != self.bones() {
            let problem = format!("{} given for {} bones", frames.len(), self.bones());
            return Err(Error::invalid("frames", problem));
        }
        for (frame, name) in frames.iter().zip(names) {
            rigid(name, frame).map_err(|e| e.within("frames"))?;
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
    let finite = frame.position.is_finite() && frame.rotation.is_finite();
    let problem = match finite {
        false => "holds a value that is not finite",
        true => {
            "its rotation scales, shears or mirrors; hand in an orthonormal matrix with determinant 1"
        }
    };
    Err(Error::invalid(field, problem))
}
