//! The instances of one asset in a world.

use super::backend::{Evaluator, Opened, Room};
use super::character::{Character, rigid};
use super::near::SkinBounds;
use super::pose_springs::{PoseSpring, pose_springs};
use crate::model::{Avatar, Frame, RigidBody};
use crate::sim::{Physics, Settings, Solvers, Waking};
use crate::skeleton::SkeletonModel;
use crate::{Error, Result};
use glam::DVec3;
use std::ops::Range;
use std::sync::Arc;

/// One asset: an avatar and its instances, or a rigid body, which is an avatar of one bone.
pub(super) struct Batch {
    /// As it was handed in.
    base: Arc<Avatar>,
    /// That with body slots.
    pub avatar: Arc<Avatar>,
    pub physics: Physics,
    pub bounds: SkinBounds,
    /// As many as there is room for.
    pub characters: Vec<Character>,
    /// Which of them stand in the world.
    pub used: Vec<bool>,
    room: Room,
    /// Its first member.
    pub first: usize,
    pub is_body: bool,
    pose_springs: Arc<[PoseSpring]>,
}

impl Batch {
    /// With no instance, and what evaluates it.
    pub fn new(
        opened: &mut Opened,
        base: Arc<Avatar>,
        settings: Settings,
        is_body: bool,
    ) -> Result<(Self, Evaluator)> {
        base.validate()?;
        let room = Room {
            fine_slots: opened.fine_slots(&base, settings.fine_handles),
            ..Room::default()
        };
        let avatar = with_room(&base, room)?;
        let evaluator = opened.evaluator(&avatar, room, is_body)?;
        let batch = Self {
            physics: Physics {
                waking: Waking::new(&avatar),
                skeleton: SkeletonModel::new(&base),
                captured_under_gravity: base.captured_under_gravity,
                settings,
            },
            bounds: SkinBounds::new(&avatar),
            avatar,
            characters: Vec::new(),
            used: Vec::new(),
            room,
            first: 0,
            is_body,
            pose_springs: pose_springs(&base),
            base,
        };
        Ok((batch, evaluator))
    }

    /// A body's, with its one instance.
    pub fn of_body(
        opened: &mut Opened,
        body: &RigidBody,
        settings: Settings,
        gravity: DVec3,
    ) -> Result<(Self, Evaluator)> {
        let of_body = |e: Error| e.within(&format!("bodies.{}", body.name));
        body.collider(0).validate().map_err(of_body)?;
        rigid("initial_frame", &body.initial_frame).map_err(of_body)?;
        let avatar = Arc::new(body.alone());
        let (mut batch, evaluator) = Self::new(opened, avatar, settings, true).map_err(of_body)?;
        let wanted = Room {
            instances: 1,
            ..Room::default()
        };
        let evaluator = batch.make_room(opened, wanted)?.unwrap_or(evaluator);
        let mut character = batch.character(gravity, &body.initial_frame);
        character.ragdoll(0.0)?;
        batch.characters[0] = character;
        batch.used[0] = true;
        Ok((batch, evaluator))
    }

    /// As it was handed in.
    pub fn base(&self) -> &Avatar {
        &self.base
    }

    /// How much room there is.
    pub fn room(&self) -> Room {
        self.room
    }

    /// Its members.
    pub fn members(&self) -> Range<usize> {
        self.first..self.first + self.characters.len()
    }

    /// Makes room: where more is wanted than there is, another evaluator and frames for bodies. Nothing has changed where
    /// that fails.
    pub fn make_room(&mut self, opened: &mut Opened, wanted: Room) -> Result<Option<Evaluator>> {
        let room = self.room.union(wanted);
        if room == self.room {
            return Ok(None);
        }
        let room = room.rounded_up();
        let avatar = with_room(&self.base, room)?;
        let evaluator = opened.evaluator(&avatar, room, self.is_body)?;
        if room.body_slots != self.room.body_slots {
            self.physics.skeleton = SkeletonModel::new(&avatar);
        }
        if room.fine_slots != self.room.fine_slots {
            self.physics.waking = Waking::new(&avatar);
            self.bounds = SkinBounds::new(&avatar);
        }
        (self.characters.iter_mut()).for_each(|character| character.set_avatar(&avatar));
        // Another evaluator knows no skin of theirs.
        (self.characters.iter_mut()).for_each(|character| character.instance.was_put = true);
        self.avatar = avatar;
        self.room = room;
        let missing = room.instances.saturating_sub(self.characters.len());
        for _ in 0..missing {
            self.characters
                .push(self.character(DVec3::ZERO, &Frame::IDENTITY));
            self.used.push(false);
        }
        Ok(Some(evaluator))
    }

    /// An instance at rest.
    pub fn character(&self, gravity: DVec3, placement: &Frame) -> Character {
        let settings = &self.physics.settings;
        Character::new(
            &self.avatar,
            settings,
            gravity,
            &self.pose_springs,
            placement,
        )
    }

    /// The first place that no instance has.
    pub fn free_place(&self) -> Option<usize> {
        self.used.iter().position(|used| !used)
    }

    /// Solvers of its systems.
    pub fn solvers(&self, evaluator: &Evaluator) -> Solvers {
        Solvers::dense(evaluator.pattern(), self.characters.len())
    }
}

/// `base` with frames that stand for bodies, and slots for fine handles.
fn with_room(base: &Arc<Avatar>, room: Room) -> Result<Arc<Avatar>> {
    if room.body_slots == 0 && room.fine_slots == 0 {
        return Ok(base.clone());
    }
    let mut avatar = (**base).clone();
    if room.body_slots > 0 {
        avatar = avatar.with_body_slots(room.body_slots)?;
    }
    if room.fine_slots > 0 {
        avatar = avatar.with_fine_slots(room.fine_slots)?;
    }
    Ok(Arc::new(avatar))
}
