//! What a world holds: it comes and goes between steps.

use super::backend::{Backend, Evaluator, Opened, Room, gone};
use super::batch::Batch;
use super::character::{Character, rigid};
use super::evaluators::Evaluators;
use super::frame::WorldFrame;
use super::keys::{AvatarId, BodyId, ColliderId, InstanceId};
use super::meetings::Meetings;
use crate::Result;
use crate::collider::Collider;
use crate::material::Material;
use crate::model::{Avatar, Frame, RigidBody, UpAxis};
use crate::sim::{Instance, Physics, Settings, Stepper, Timings};
use glam::DVec3;
use serde::{Deserialize, Serialize};
use slotmap::SlotMap;
use std::sync::Arc;

/// Gravity on Earth, m/s².
pub(super) const GRAVITY: f64 = 9.81;

/// A rigid body, and which asset it is.
#[derive(Serialize, Deserialize)]
pub(super) struct Body {
    pub rigid: RigidBody,
    /// What avatars meet of it, in its own frame.
    pub collider: Collider,
    pub asset: usize,
}

/// Avatars of any assets that move together, with colliders and rigid bodies that all of them share.
pub struct World {
    pub(super) opened: Opened,
    pub(super) settings: Settings,
    pub(super) up: UpAxis,
    pub(super) gravity: DVec3,
    avatars: SlotMap<AvatarId, usize>,
    /// Asset and place in it.
    pub(super) instances: SlotMap<InstanceId, (usize, usize)>,
    pub(super) bodies: SlotMap<BodyId, Body>,
    pub(super) colliders: SlotMap<ColliderId, Collider>,
    pub(super) batches: Vec<Batch>,
    pub(super) evaluators: Evaluators,
    /// None where members have come or gone since the last step.
    pub(super) stepper: Option<Stepper>,
    pub(super) meetings: Meetings,
    pub(super) timings: Timings,
    /// Whether the posed skins are those of the states.
    pub(super) posed: bool,
    /// What drives everything over a frame that takes several steps.
    pub(super) frame: WorldFrame,
    /// Memory of what is near an instance.
    pub(super) near: Vec<Collider>,
    /// Memory of the list of all members.
    pub(super) each: Vec<(&'static Physics, &'static Instance)>,
}

impl World {
    /// An empty world in which y points up, with gravity of 9.81 m/s². Blocks while an adapter is looked for.
    ///
    /// # Errors
    /// A device that cannot be used.
    #[cfg(not(target_arch = "wasm32"))]
    pub fn new(backend: Backend) -> Result<Self> {
        pollster::block_on(Self::open(backend))
    }

    /// [`World::new`] without blocking.
    ///
    /// # Errors
    /// A device that cannot be used.
    pub async fn open(backend: Backend) -> Result<Self> {
        let up = UpAxis::Y;
        let opened = backend.open().await?;
        Ok(Self {
            settings: Settings {
                report_at_end: true,
                ..Settings::default()
            },
            opened,
            up,
            gravity: -GRAVITY * up.direction(),
            avatars: SlotMap::with_key(),
            instances: SlotMap::with_key(),
            bodies: SlotMap::with_key(),
            colliders: SlotMap::with_key(),
            batches: Vec::new(),
            evaluators: Evaluators::default(),
            stepper: None,
            meetings: Meetings::default(),
            timings: Timings::default(),
            posed: false,
            frame: WorldFrame::default(),
            near: Vec::new(),
            each: Vec::new(),
        })
    }

    /// The same world with another axis up, and gravity against it. What is in it stays as it stands.
    pub fn with_up(mut self, up: UpAxis) -> Self {
        self.up = up;
        self.set_gravity(-GRAVITY * up.direction());
        self
    }

    /// The same world with other constants; the time step in them is not read.
    ///
    /// # Errors
    /// Constants that are unusable.
    pub fn with_settings(mut self, settings: Settings) -> Result<Self> {
        self.set_settings(settings)?;
        Ok(self)
    }

    /// Other constants for the steps that follow; the time step in them is not read, and what an instance has of its own
    /// (bending, limits) stays.
    ///
    /// # Errors
    /// Constants that are unusable; the old ones stay.
    pub fn set_settings(&mut self, settings: Settings) -> Result<()> {
        settings.validate()?;
        let time_step = self.settings.time_step;
        self.put_settings(Settings {
            time_step,
            ..settings
        });
        Ok(())
    }

    /// Other constants, of all assets too.
    pub(super) fn put_settings(&mut self, settings: Settings) {
        self.settings = settings;
        for batch in &mut self.batches {
            batch.physics.settings = settings;
        }
    }

    /// The constants; the time step in them is the last step's, s.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// Which axis points up.
    pub fn up(&self) -> UpAxis {
        self.up
    }

    /// Gravity, m/s².
    pub fn gravity(&self) -> DVec3 {
        self.gravity
    }

    /// Other gravity (m/s²) for all that is here and comes.
    pub fn set_gravity(&mut self, gravity: DVec3) {
        self.gravity = gravity;
        for character in self.batches.iter_mut().flat_map(|b| &mut b.characters) {
            character.instance.gravity = gravity;
        }
    }

    /// What evaluates the tissue: `"cpu"`, or the adapter's name.
    pub fn backend(&self) -> String {
        self.opened.name()
    }

    /// Wall-clock times of the last step.
    pub fn timings(&self) -> Timings {
        self.timings
    }

    /// Compiles the kernels for tissue of the law of `material` ahead of its first avatar, which else waits for them; in a
    /// browser, where nothing can wait, it must have been awaited before. Nothing on the CPU.
    ///
    /// # Errors
    /// What the device lacks.
    pub async fn compile_kernels(&mut self, material: &Material) -> Result<()> {
        self.opened.compile(material).await
    }

    /// Hands an avatar in, once for all its instances.
    ///
    /// # Errors
    /// An avatar that is not sound, or has rigid bodies of its own; limits of the device.
    pub fn add_avatar(&mut self, avatar: impl Into<Arc<Avatar>>) -> Result<AvatarId> {
        let (batch, evaluator) = Batch::new(&mut self.opened, avatar.into(), self.settings, false)?;
        let asset = self.push(batch, evaluator);
        Ok(self.avatars.insert(asset))
    }

    /// Takes an avatar out, with all its instances.
    ///
    /// # Errors
    /// A key of none.
    pub fn remove_avatar(&mut self, avatar: AvatarId) -> Result<()> {
        let asset = self.avatars.remove(avatar).ok_or_else(|| gone("avatar"))?;
        self.instances.retain(|_, (of, _)| *of != asset);
        self.remove_asset(asset);
        Ok(())
    }

    /// Another instance of an avatar, in its bind pose: stood up about its file's origin, which is the world's, and held
    /// there.
    ///
    /// # Errors
    /// A key of none; limits of the device.
    pub fn add_instance(&mut self, avatar: AvatarId) -> Result<InstanceId> {
        self.add_instance_at(avatar, &Frame::IDENTITY)
    }

    /// [`World::add_instance`], then moved rigidly by `placement`.
    ///
    /// # Errors
    /// As [`World::add_instance`], and of a placement that is not rigid.
    pub fn add_instance_at(&mut self, avatar: AvatarId, placement: &Frame) -> Result<InstanceId> {
        rigid("placement", placement)?;
        let asset = *self.avatars.get(avatar).ok_or_else(|| gone("avatar"))?;
        let place = self.place(asset)?;
        let batch = &mut self.batches[asset];
        let placement = placement.compose(&batch.avatar.standing(self.up));
        batch.characters[place] = batch.character(self.gravity, &placement);
        let axes = batch.avatar.standing(self.up).rotation;
        batch.characters[place].instance.file_axes = axes;
        batch.used[place] = true;
        self.posed = false;
        Ok(self.instances.insert((asset, place)))
    }

    /// Takes an instance out.
    ///
    /// # Errors
    /// A key of none.
    pub fn remove_instance(&mut self, instance: InstanceId) -> Result<()> {
        let removed = self.instances.remove(instance);
        let (asset, place) = removed.ok_or_else(|| gone("instance"))?;
        self.batches[asset].used[place] = false;
        Ok(())
    }

    /// Keys of the instances.
    pub fn instances(&self) -> impl Iterator<Item = InstanceId> {
        self.instances.keys()
    }

    /// An instance.
    ///
    /// # Errors
    /// A key of none.
    pub fn instance(&self, instance: InstanceId) -> Result<&Character> {
        let (asset, place) = self.find(instance)?;
        Ok(&self.batches[asset].characters[place])
    }

    /// An instance, to be driven between steps.
    ///
    /// # Errors
    /// A key of none.
    pub fn instance_mut(&mut self, instance: InstanceId) -> Result<&mut Character> {
        let (asset, place) = self.find(instance)?;
        self.posed = false;
        Ok(&mut self.batches[asset].characters[place])
    }

    pub(super) fn find(&self, instance: InstanceId) -> Result<(usize, usize)> {
        let found = self.instances.get(instance).copied();
        found.ok_or_else(|| gone("instance"))
    }

    /// Of the last step, s.
    pub(super) fn time_step(&self) -> f64 {
        self.settings.time_step
    }

    /// Appends an asset: avatars stand before bodies.
    pub(super) fn push(&mut self, batch: Batch, evaluator: Evaluator) -> usize {
        let asset = match batch.is_body {
            true => self.batches.len(),
            false => self.batches.iter().filter(|b| !b.is_body).count(),
        };
        self.batches.insert(asset, batch);
        self.evaluators.insert(asset, evaluator);
        let bodies = self.bodies.values_mut().map(|body| &mut body.asset);
        bodies.for_each(|of| *of += usize::from(*of >= asset));
        self.stepper = None;
        self.posed = false;
        asset
    }

    pub(super) fn remove_asset(&mut self, asset: usize) {
        self.batches.remove(asset);
        self.evaluators.remove(asset);
        let moved = |of: &mut usize| *of -= usize::from(*of > asset);
        self.avatars.values_mut().for_each(moved);
        self.instances.values_mut().for_each(|(of, _)| moved(of));
        self.bodies
            .values_mut()
            .for_each(|body| moved(&mut body.asset));
        self.stepper = None;
        self.posed = false;
    }

    /// A free place among an asset's instances.
    fn place(&mut self, asset: usize) -> Result<usize> {
        if let Some(place) = self.batches[asset].free_place() {
            return Ok(place);
        }
        let instances = self.batches[asset].characters.len() + 1;
        let wanted = Room {
            instances,
            ..Room::default()
        };
        self.make_room(asset, wanted)?;
        Ok(instances - 1)
    }

    /// Makes room for an asset.
    pub(super) fn make_room(&mut self, asset: usize, wanted: Room) -> Result<()> {
        if let Some(evaluator) = self.batches[asset].make_room(&mut self.opened, wanted)? {
            self.evaluators.replace(asset, evaluator);
            self.stepper = None;
            self.posed = false;
        }
        Ok(())
    }
}
