//! One simulated avatar: its state and what drives it.

use super::settings::{Settings, not_negative};
use super::skin_spring::SkinSpring;
use super::waking_memory::WakingMemory;
use crate::collider::Collider;
use crate::model::{Avatar, Awake, Frame, History, PoseOffsets, State, UpAxis, is_rotation};
use crate::potential::{PreviousSkin, TissueFactors};
use crate::skeleton::{Bending, JointLimit, Preload, Tracking};
use crate::{Error, Result};
use glam::{DMat3, DVec3};
use serde::{Deserialize, Serialize};

/// A bone that is held at a prescribed frame; its DoFs do not move otherwise.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Pin {
    /// Which bone.
    pub bone: usize,
    /// Where it is at the end of the next step.
    pub frame: Frame,
}

/// Which spring bones ([`SpringBones`](crate::model::SpringBones)) swing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[non_exhaustive]
pub enum SpringMode {
    /// None: they are carried as other bones without mass are.
    Off,
    /// Those that no pin holds: what a host prescribes is where it says.
    #[default]
    Free,
    /// All of them: a pin of one says no more than where it is at rest, seen from its parent, as a target does.
    All,
}

/// What changes in time. Everything here may be written between steps.
#[derive(Clone, Debug)]
pub struct Instance {
    /// qⁿ.
    pub state: State,
    /// The states before qⁿ, which say the velocities; of a spring bone qⁿ⁻¹ says that of its tail, and its frame there no
    /// more.
    pub history: History,
    /// Springs and dampers that draw bones to moving targets. After a step each target's
    /// `previous` becomes its `frame`.
    pub targets: Vec<Tracking>,
    /// Whose springs carry the weight of the pose that they draw to beforehand, so that it does not sag.
    pub preload: Preload,
    /// Springs that draw points of the skin, and with them flesh and bones, to places of the host's.
    pub skin_springs: Vec<SkinSpring>,
    /// Bones that follow a prescribed motion exactly.
    pub pins: Vec<Pin>,
    /// The rest rotation of each bone relative to its parent, and how stiffly it is kept.
    pub bending: Vec<Bending>,
    /// Ranges of joints, and how stiffly they are kept: at first those of the avatar's skeleton.
    pub limits: Vec<JointLimit>,
    /// What the skin cannot enter; with bodies, theirs are the first. After a step each `previous` becomes its `frame`.
    pub colliders: Vec<Collider>,
    /// Gravity, m/s².
    pub gravity: DVec3,
    /// On the tissue as it was baked: stiffness, damping, gravity, friction. The gravity factor is on the tissue's weight
    /// also where that loads the bones (a shape that was captured under gravity): such a shape keeps the sag that it has,
    /// whatever the factor.
    pub factors: TissueFactors,
    /// ι, 0 to 1: the share of the root's acceleration that tissue and free bones ignore. With 1 a character that is moved about
    /// as a whole does not swing at all. Only where the root is prescribed.
    pub inertia_share: f64,
    /// What a host's own model of the pose adds to the skin's rest shape: in the steps that follow, and where it is drawn.
    pub pose_offsets: PoseOffsets,
    /// Which fine handles are awake: a step says so, by what is near. Slots after these are at 0.
    pub awake: Awake,
    /// Which spring bones swing.
    pub springs: SpringMode,
    /// Turns the axes of the avatar's file into the world's: the gravity of spring bones is said in the former. At first
    /// [`Avatar::standing`] where z points up.
    pub file_axes: DMat3,
    /// Whether [`Simulation::step`](super::Simulation::step) moves it.
    pub active: bool,
    /// Whether it was put where it is since the last step: no motion led there.
    pub(crate) was_put: bool,
    /// What waking remembers.
    pub(crate) waking: WakingMemory,
}

impl Instance {
    /// The avatar at rest in its bind pose, with gravity along −z and nothing around it but its bodies,
    /// whose colliders come first.
    pub fn new(avatar: &Avatar, settings: &Settings) -> Self {
        let state = avatar.rest_state();
        Self {
            history: History::at_rest(&state),
            targets: Vec::new(),
            preload: Preload::default(),
            skin_springs: Vec::new(),
            pins: Vec::new(),
            bending: vec![
                Bending {
                    rest_rotation: DMat3::IDENTITY,
                    stiffness: settings.bending_stiffness,
                    damping: settings.joint_damping_time * settings.bending_stiffness,
                };
                state.frames.len()
            ],
            limits: (avatar.skeleton.limits.iter())
                .map(|&(bone, range)| JointLimit {
                    bone: bone as usize,
                    range,
                    stiffness: settings.limit_stiffness,
                    damping_time: settings.joint_damping_time,
                })
                .collect(),
            state,
            colliders: avatar.body_colliders().collect(),
            gravity: DVec3::new(0.0, 0.0, -9.81),
            factors: TissueFactors::default(),
            inertia_share: 0.0,
            pose_offsets: PoseOffsets::default(),
            awake: Awake::none(avatar),
            waking: WakingMemory::default(),
            springs: SpringMode::default(),
            file_axes: avatar.standing(UpAxis::Z).rotation,
            active: true,
            was_put: true,
        }
    }

    /// What holds `bone`.
    pub(super) fn pin_of(&self, bone: usize) -> Option<&Pin> {
        // A host that prescribes all bones has them in order.
        let there = self.pins.get(bone).filter(|pin| pin.bone == bone);
        there.or_else(|| self.pins.iter().find(|pin| pin.bone == bone))
    }

    /// What draws `bone`.
    pub(super) fn target_of(&self, bone: usize) -> Option<&Tracking> {
        let there = self.targets.get(bone).filter(|t| t.bone == bone);
        there.or_else(|| self.targets.iter().find(|t| t.bone == bone))
    }

    /// What its previous posed skin is after a step.
    pub(crate) fn previous_skin(&self) -> PreviousSkin {
        match self.was_put {
            true => PreviousSkin::New,
            false => PreviousSkin::Last,
        }
    }

    /// Sets where a frame is, as a rule a body's, and how it moves: with `velocity` (m/s, of its origin) and
    /// `angular_velocity` (rad/s).
    pub fn set_motion(
        &mut self,
        frame: usize,
        at: Frame,
        velocity: DVec3,
        angular_velocity: DVec3,
    ) {
        self.state.frames[frame] = at;
        (self.history).set_velocity(frame, &at, velocity, angular_velocity);
    }

    /// Sets the state, at rest.
    pub fn set_state(&mut self, state: State) {
        self.history.rest(&state);
        self.awake.set_handles(&state.awake);
        self.waking = WakingMemory::default();
        self.state.clone_from(&state);
        self.was_put = true;
    }

    /// Puts the bones at `frames` at rest with no displacement, and makes that pose the rest pose of
    /// its bending springs.
    pub fn pose(&mut self, frames: &[Frame], parents: &[Option<u32>]) {
        for (j, parent) in parents.iter().enumerate() {
            if let Some(p) = parent {
                self.bending[j].rest_rotation =
                    frames[*p as usize].rotation.transpose() * frames[j].rotation;
            }
        }
        self.set_state(State {
            frames: frames.to_vec(),
            handles: vec![DVec3::ZERO; self.state.handles.len()],
            awake: Vec::new(),
        });
    }

    /// Checks what the user wrote, so that a step meets only usable numbers.
    pub(crate) fn validate(&self, like: &State) -> Result<()> {
        let bones = like.frames.len();
        let check = |ok: bool, field: &str, problem: &str| {
            if ok {
                Ok(())
            } else {
                Err(Error::invalid(format!("instance.{field}"), problem))
            }
        };
        let past = self.history.states().iter().map(|state| ("history", state));
        for (field, state) in std::iter::once(("state", &self.state)).chain(past) {
            check(
                state.space() == like.space(),
                field,
                "has not the avatar's numbers of bones and handles",
            )?;
            check(state.is_finite(), field, "holds a value that is not finite")?;
            check(
                state.awake == self.awake.handles(),
                field,
                "names other fine handles than are awake",
            )?;
            check(
                state.frames.iter().all(Frame::is_rigid),
                field,
                "holds a frame whose rotation is none",
            )?;
        }
        check(
            self.bending.len() == bones,
            "bending",
            "one is needed for each bone",
        )?;
        for bending in &self.bending {
            not_negative("instance.bending.stiffness", bending.stiffness, "N·m/rad")?;
            not_negative("instance.bending.damping", bending.damping, "N·m·s")?;
            check(
                is_rotation(&bending.rest_rotation),
                "bending",
                "a rest rotation is none",
            )?;
        }
        for limit in &self.limits {
            check(
                limit.bone < bones,
                "limits",
                "names a bone that is not there",
            )?;
            limit.range.validate("instance.limits.range")?;
            not_negative("instance.limits.stiffness", limit.stiffness, "N·m/rad")?;
            not_negative(
                "instance.limits.damping_time",
                limit.damping_time,
                "seconds",
            )?;
        }
        for target in &self.targets {
            check(
                target.bone < bones,
                "targets",
                "names a bone that is not there",
            )?;
            check(
                target.frame.is_rigid() && target.previous.is_rigid() && target.earlier.is_rigid(),
                "targets",
                "a frame is not finite or its rotation is none",
            )?;
            for spring in [&target.rotation, &target.position].into_iter().flatten() {
                not_negative(
                    "instance.targets.stiffness",
                    spring.stiffness,
                    "N/m or N·m/rad",
                )?;
                not_negative("instance.targets.damping", spring.damping, "N·s/m or N·m·s")?;
            }
        }
        for pin in &self.pins {
            check(pin.bone < bones, "pins", "names a bone that is not there")?;
            check(
                pin.frame.is_rigid(),
                "pins",
                "a frame is not finite or its rotation is none",
            )?;
        }
        for collider in &self.colliders {
            check(
                collider.frame.is_rigid() && collider.previous.is_rigid(),
                "colliders",
                "a frame is not finite or its rotation is none",
            )?;
            let stiffness = collider.stiffness.unwrap_or_default();
            not_negative("instance.colliders.stiffness", stiffness, "Pa/m")?;
            not_negative("instance.colliders.margin", collider.margin, "metres")?;
        }
        check(
            self.history.is_valid(),
            "history",
            "holds a time that is none",
        )?;
        check(
            (0.0..=1.0).contains(&self.inertia_share),
            "inertia_share",
            "is not within 0 and 1",
        )?;
        check(self.gravity.is_finite(), "gravity", "is not finite")?;
        check(is_rotation(&self.file_axes), "file_axes", "is no rotation")?;
        self.factors.validate().map_err(|e| e.within("instance"))
    }
}
