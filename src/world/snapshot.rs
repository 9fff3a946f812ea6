//! All that moves in a world, as bytes and back.

use super::backend::Room;
use super::batch::Batch;
use super::character::{Character, Driving};
use super::contents::{Body, World};
use super::keys::{BodyId, ColliderId, InstanceId};
use crate::collider::Collider;
use crate::file::Section;
use crate::model::{Avatar, Frame, History, Integrator, State, UpAxis};
use crate::potential::TissueFactors;
use crate::sim::{Pin, Settings, SolverMode, SpringMode};
use crate::skeleton::{Bending, JointLimit, Preload, Tracking};
use crate::{Error, Result};
use glam::{DMat3, DVec3};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use slotmap::SlotMap;

/// What a world was at a time: states, drivers, colliders and bodies, in tagged sections. The avatars themselves are not
/// in it; they are known by a checksum. Serialise it with any serde format.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Snapshot {
    sections: Vec<Section>,
}

const WORLD: [u8; 4] = *b"WRLD";
const ASSETS: [u8; 4] = *b"ASST";
const INSTANCES: [u8; 4] = *b"INST";
const DRIVERS: [u8; 4] = *b"DRIV";
const SPRINGS: [u8; 4] = *b"SPRG";
/// Without it the states say a velocity and no more, and steps are as they were: of backward Euler.
const HISTORY: [u8; 4] = *b"HIST";
const INTEGRATION: [u8; 4] = *b"INTG";
const OFFSETS: [u8; 4] = *b"OFFS";
const BODIES: [u8; 4] = *b"BODY";
const COLLIDERS: [u8; 4] = *b"COLL";
/// Of a section's content, as this build writes it.
fn version(tag: [u8; 4]) -> u32 {
    match tag {
        DRIVERS => 2,
        _ => 1,
    }
}

#[derive(Serialize, Deserialize)]
struct StoredWorld {
    settings: StoredSettings,
    up: UpAxis,
    gravity: DVec3,
}

/// [`Settings`] without tags in text, which the sections' format has none of.
#[derive(Serialize, Deserialize)]
struct StoredSettings {
    time_step: f64,
    /// Tolerance and most iterations; none of the one-iteration mode.
    converged: Option<(f64, usize)>,
    joint_stiffness: f64,
    bending_stiffness: f64,
    limit_stiffness: f64,
    slip_speed: f64,
    geometric_contact: bool,
    report_at_end: bool,
}

impl From<Settings> for StoredSettings {
    fn from(settings: Settings) -> Self {
        Self {
            time_step: settings.time_step,
            converged: match settings.solver {
                SolverMode::OneIteration | SolverMode::Budgeted { .. } => None,
                SolverMode::Converged {
                    tolerance,
                    max_iterations,
                } => Some((tolerance, max_iterations)),
            },
            joint_stiffness: settings.joint_stiffness,
            bending_stiffness: settings.bending_stiffness,
            limit_stiffness: settings.limit_stiffness,
            slip_speed: settings.slip_speed,
            geometric_contact: settings.geometric_contact,
            report_at_end: settings.report_at_end,
        }
    }
}

impl From<StoredSettings> for Settings {
    fn from(stored: StoredSettings) -> Self {
        let converged = |(tolerance, max_iterations)| SolverMode::Converged {
            tolerance,
            max_iterations,
        };
        Self {
            time_step: stored.time_step,
            integrator: Integrator::BackwardEuler,
            longest_step: Settings::default().longest_step,
            largest_acceleration: f64::MAX,
            solver: stored.converged.map_or(SolverMode::OneIteration, converged),
            joint_stiffness: stored.joint_stiffness,
            bending_stiffness: stored.bending_stiffness,
            limit_stiffness: stored.limit_stiffness,
            joint_damping_time: 0.0,
            slip_speed: stored.slip_speed,
            geometric_contact: stored.geometric_contact,
            report_at_end: stored.report_at_end,
        }
    }
}

#[derive(Serialize, Deserialize)]
struct StoredAsset {
    name: String,
    checksum: u32,
    room: Room,
}

#[derive(Serialize, Deserialize)]
struct StoredState {
    state: State,
    previous: State,
}

/// What [`StoredSettings`] do not say.
#[derive(Serialize, Deserialize)]
struct StoredIntegration {
    bdf2: bool,
    longest_step: f64,
    largest_acceleration: f64,
    joint_damping_time: f64,
    /// Of the budgeted solver.
    budget: Option<usize>,
}

/// What came before a state, where each target was, and what joints damp.
#[derive(Serialize, Deserialize)]
struct StoredHistory {
    history: History,
    inertia_share: f64,
    earlier_targets: Vec<Frame>,
    bending_damping: Vec<f64>,
    limit_damping: Vec<f64>,
    preload: Preload,
}

/// What the states do not say of spring bones.
#[derive(Serialize, Deserialize)]
struct StoredSprings {
    mode: SpringMode,
    file_axes: DMat3,
}

#[derive(Serialize, Deserialize)]
struct StoredDriver<F> {
    driving: Driving,
    placement: Frame,
    awake: bool,
    targets: Vec<Tracking>,
    pins: Vec<Pin>,
    bending: Vec<Bending>,
    limits: Vec<JointLimit>,
    gravity: DVec3,
    factors: F,
}

/// [`TissueFactors`] in drivers of version 1: no tension.
#[derive(Serialize, Deserialize)]
struct FactorsWithoutTension {
    stiffness: f64,
    damping: f64,
    gravity: f64,
    friction: f64,
}

impl From<FactorsWithoutTension> for TissueFactors {
    fn from(stored: FactorsWithoutTension) -> Self {
        Self {
            stiffness: stored.stiffness,
            damping: stored.damping,
            gravity: stored.gravity,
            friction: stored.friction,
            ..Self::default()
        }
    }
}

impl From<StoredDriver<FactorsWithoutTension>> for StoredDriver<TissueFactors> {
    fn from(stored: StoredDriver<FactorsWithoutTension>) -> Self {
        Self {
            driving: stored.driving,
            placement: stored.placement,
            awake: stored.awake,
            targets: stored.targets,
            pins: stored.pins,
            bending: stored.bending,
            limits: stored.limits,
            gravity: stored.gravity,
            factors: stored.factors.into(),
        }
    }
}

impl Character {
    fn stored_state(&self) -> StoredState {
        let instance = self.instance();
        StoredState {
            state: instance.state.clone(),
            previous: instance.history.previous().clone(),
        }
    }

    fn stored_driver(&self) -> StoredDriver<TissueFactors> {
        let instance = self.instance();
        StoredDriver {
            driving: self.driving(),
            placement: self.placement(),
            awake: self.is_awake(),
            targets: instance.targets.clone(),
            pins: instance.pins.clone(),
            bending: instance.bending.clone(),
            limits: instance.limits.clone(),
            gravity: instance.gravity,
            factors: instance.factors,
        }
    }

    fn stored_history(&self) -> StoredHistory {
        let instance = self.instance();
        StoredHistory {
            history: instance.history.clone(),
            inertia_share: instance.inertia_share,
            earlier_targets: instance.targets.iter().map(|t| t.earlier).collect(),
            bending_damping: instance.bending.iter().map(|b| b.damping).collect(),
            limit_damping: instance.limits.iter().map(|l| l.damping_time).collect(),
            preload: instance.preload,
        }
    }

    fn stored_springs(&self) -> StoredSprings {
        let instance = self.instance();
        StoredSprings {
            mode: instance.springs,
            file_axes: instance.file_axes,
        }
    }

    /// `time_step` is that which led to the state, s.
    fn restore_state(
        &mut self,
        stored: StoredState,
        history: Option<StoredHistory>,
        time_step: f64,
    ) -> Result<()> {
        let instance = &mut self.instance;
        let like = instance.state.clone();
        instance.state = stored.state;
        match history {
            Some(stored) => {
                let counted = stored.earlier_targets.len() == instance.targets.len()
                    && stored.bending_damping.len() == instance.bending.len()
                    && stored.limit_damping.len() == instance.limits.len();
                if !counted {
                    return Err(damaged());
                }
                let bending = instance.bending.iter_mut().zip(stored.bending_damping);
                bending.for_each(|(bending, damping)| bending.damping = damping);
                let limits = instance.limits.iter_mut().zip(stored.limit_damping);
                limits.for_each(|(limit, damping)| limit.damping_time = damping);
                let targets = instance.targets.iter_mut().zip(stored.earlier_targets);
                targets.for_each(|(target, earlier)| target.earlier = earlier);
                instance.preload = stored.preload;
                instance.history = stored.history;
                instance.inertia_share = stored.inertia_share;
            }
            None => {
                instance.preload = Preload::Off;
                let spaces = (stored.previous.space(), instance.state.space());
                if spaces.0 != spaces.1 {
                    return Err(damaged());
                }
                let history = &mut instance.history;
                history.set_previous(&stored.previous, &instance.state, time_step);
                let targets = instance.targets.iter_mut();
                targets.for_each(|target| target.earlier = target.previous);
            }
        }
        // Since then room may have been made for more bodies.
        let frames = instance.state.frames.len();
        if (self.bones()..like.frames.len()).contains(&frames)
            && self.instance.bending.len() == frames
        {
            let avatar = self.avatar.clone();
            self.set_avatar(&avatar);
        }
        self.instance.validate(&like)
    }

    fn restore(
        &mut self,
        state: StoredState,
        history: Option<StoredHistory>,
        driver: StoredDriver<TissueFactors>,
        springs: &StoredSprings,
        time_step: f64,
    ) -> Result<()> {
        let instance = &mut self.instance;
        instance.targets = driver.targets;
        instance.pins = driver.pins;
        instance.bending = driver.bending;
        instance.limits = driver.limits;
        instance.gravity = driver.gravity;
        instance.factors = driver.factors;
        instance.springs = springs.mode;
        instance.file_axes = springs.file_axes;
        self.restore_state(state, history, time_step)?;
        self.restore_driving(driver.driving, &driver.placement, driver.awake)
    }
}

impl World {
    /// All that moves here, as it stands between two steps.
    ///
    /// # Errors
    /// None that a sound world has.
    pub fn snapshot(&self) -> Result<Snapshot> {
        let asset = |batch: &Batch| -> Result<StoredAsset> {
            Ok(StoredAsset {
                name: batch.avatar.name.clone(),
                checksum: checksum(batch.base())?,
                room: batch.room(),
            })
        };
        let avatars = self.batches.iter().filter(|b| !b.is_body).map(asset);
        let assets = avatars.collect::<Result<Vec<_>>>()?;
        let character = |&(asset, place): &(usize, usize)| &self.batches[asset].characters[place];
        let characters = || self.instances.values().map(character);
        let of_bodies = || self.bodies.values().map(|body| character(&(body.asset, 0)));
        let states: Vec<_> = characters().map(Character::stored_state).collect();
        let drivers: Vec<_> = characters().map(Character::stored_driver).collect();
        let springs: Vec<_> = characters().map(Character::stored_springs).collect();
        let offsets: Vec<_> = (characters().map(|c| c.instance.pose_offsets.as_slice())).collect();
        let body_states: Vec<_> = of_bodies().map(Character::stored_state).collect();
        let histories: Vec<_> = (characters().chain(of_bodies()))
            .map(Character::stored_history)
            .collect();
        let integration = StoredIntegration {
            bdf2: self.settings.integrator == Integrator::Bdf2,
            longest_step: self.settings.longest_step,
            largest_acceleration: self.settings.largest_acceleration,
            joint_damping_time: self.settings.joint_damping_time,
            budget: match self.settings.solver {
                SolverMode::Budgeted { max_iterations } => Some(max_iterations),
                _ => None,
            },
        };
        let world = StoredWorld {
            settings: self.settings.into(),
            up: self.up,
            gravity: self.gravity,
        };
        Ok(Snapshot {
            sections: vec![
                section(WORLD, &world)?,
                section(ASSETS, &assets)?,
                section(INSTANCES, &(&self.instances, states))?,
                section(DRIVERS, &drivers)?,
                section(SPRINGS, &springs)?,
                section(OFFSETS, &offsets)?,
                section(BODIES, &(&self.bodies, body_states))?,
                section(COLLIDERS, &self.colliders)?,
                section(HISTORY, &histories)?,
                section(INTEGRATION, &integration)?,
            ],
        })
    }

    /// Makes the world what it was: the avatars must have been handed in, the same ones in the same order. Keys name what
    /// they named then. From there the same build, backend and device give the same bits.
    ///
    /// # Errors
    /// [`Error::Invalid`] of a snapshot of other avatars, of another version, or that is damaged. The world then is as it
    /// was.
    pub fn restore(&mut self, snapshot: &Snapshot) -> Result<()> {
        let world: StoredWorld = read(snapshot, WORLD)?;
        let mut settings = Settings::from(world.settings);
        if let Some(stored) = read_optional::<StoredIntegration>(snapshot, INTEGRATION)? {
            settings.longest_step = stored.longest_step;
            settings.largest_acceleration = stored.largest_acceleration;
            settings.joint_damping_time = stored.joint_damping_time;
            if stored.bdf2 {
                settings.integrator = Integrator::Bdf2;
            }
            if let Some(max_iterations) = stored.budget {
                settings.solver = SolverMode::Budgeted { max_iterations };
            }
        }
        settings.validate().map_err(|e| e.within("snapshot"))?;
        let assets: Vec<StoredAsset> = read(snapshot, ASSETS)?;
        let avatars = self.check_assets(&assets)?;
        let (instances, states): (SlotMap<InstanceId, (usize, usize)>, Vec<StoredState>) =
            read(snapshot, INSTANCES)?;
        let drivers = read_drivers(snapshot)?;
        let springs: Vec<StoredSprings> = read(snapshot, SPRINGS)?;
        let offsets: Vec<Vec<[f32; 3]>> = read(snapshot, OFFSETS)?;
        let (mut bodies, body_states): (SlotMap<BodyId, Body>, Vec<StoredState>) =
            read(snapshot, BODIES)?;
        let colliders: SlotMap<ColliderId, Collider> = read(snapshot, COLLIDERS)?;
        let histories: Option<Vec<StoredHistory>> = read_optional(snapshot, HISTORY)?;
        for collider in colliders.values() {
            (collider.validate()).map_err(|e| e.within("snapshot.colliders"))?;
        }
        let counted = instances.len() == states.len()
            && states.len() == drivers.len()
            && states.len() == springs.len()
            && states.len() == offsets.len()
            && bodies.len() == body_states.len()
            && (histories.iter()).all(|h| h.len() == states.len() + body_states.len());
        if !counted || !world.gravity.is_finite() {
            return Err(damaged());
        }
        for (asset, stored) in assets.iter().enumerate() {
            self.make_room(asset, stored.room)?;
        }
        let mut histories = histories.into_iter().flatten();
        let time_step = settings.time_step;
        let mut characters = Vec::new();
        let stored = states.into_iter().zip(drivers).zip(springs).zip(offsets);
        for (&place, (((state, driver), springs), offsets)) in instances.values().zip(stored) {
            let batch = self.batches.get(place.0).filter(|_| place.0 < avatars);
            let batch = batch.filter(|b| place.1 < b.characters.len());
            let batch = batch.ok_or_else(damaged)?;
            let mut character = batch.character(world.gravity, &Frame::IDENTITY);
            let restored =
                (character.restore(state, histories.next(), driver, &springs, time_step))
                    .and_then(|()| character.set_pose_offsets(&offsets));
            restored.map_err(|e| e.within("snapshot"))?;
            characters.push((place, character));
        }
        // Bodies' assets come after the avatars', in the order that they had.
        let mut made = Vec::new();
        for (body, state) in bodies.values_mut().zip(body_states) {
            let (mut batch, evaluator) =
                Batch::of_body(&mut self.opened, &body.rigid, settings, world.gravity)?;
            batch.characters[0].restore_state(state, histories.next(), time_step)?;
            made.push((body.asset, batch, evaluator));
        }
        made.sort_by_key(|(asset, ..)| *asset);
        for body in bodies.values_mut() {
            let rank = made.partition_point(|(asset, ..)| *asset < body.asset);
            body.asset = avatars + rank;
            body.collider = body.rigid.collider(0);
        }
        while self.batches.len() > avatars {
            self.remove_asset(self.batches.len() - 1);
        }
        self.bodies = bodies;
        for (rank, (_, batch, evaluator)) in made.into_iter().enumerate() {
            self.batches.push(batch);
            self.evaluators.insert(avatars + rank, evaluator);
        }
        for batch in &mut self.batches[..avatars] {
            batch.used.fill(false);
            batch.physics.settings = settings;
        }
        for ((asset, place), character) in characters {
            self.batches[asset].characters[place] = character;
            self.batches[asset].used[place] = true;
        }
        self.instances = instances;
        self.colliders = colliders;
        (self.settings, self.up, self.gravity) = (settings, world.up, world.gravity);
        self.stepper = None;
        self.posed = false;
        Ok(())
    }

    /// That the avatars here are those of a snapshot; their number.
    fn check_assets(&self, stored: &[StoredAsset]) -> Result<usize> {
        let here = || self.batches.iter().filter(|b| !b.is_body);
        let count = here().count();
        if count != stored.len() {
            let problem = format!("is of {} avatars; {count} were handed in", stored.len());
            return Err(Error::invalid("snapshot", problem));
        }
        for (i, (batch, stored)) in here().zip(stored).enumerate() {
            if checksum(batch.base())? != stored.checksum {
                let (name, other) = (&stored.name, &batch.avatar.name);
                let problem = format!(
                    "is of another avatar, {name:?}, than {other:?}, which was handed in; hand in the same ones in the same order"
                );
                return Err(Error::invalid(format!("snapshot.avatars[{i}]"), problem));
            }
        }
        Ok(count)
    }
}

/// CRC-32 of an avatar as it was handed in.
fn checksum(avatar: &Avatar) -> Result<u32> {
    let bytes = postcard::to_stdvec(avatar).map_err(|e| Error::invalid("avatar", e.to_string()))?;
    Ok(crc32fast::hash(&bytes))
}

fn section(tag: [u8; 4], content: &impl Serialize) -> Result<Section> {
    let written = postcard::to_stdvec(content);
    Ok(Section {
        tag,
        version: version(tag),
        content: written.map_err(|e| Error::invalid("snapshot", e.to_string()))?,
    })
}

/// [`read`], if it is there.
fn read_optional<T: DeserializeOwned>(snapshot: &Snapshot, tag: [u8; 4]) -> Result<Option<T>> {
    let there = snapshot.sections.iter().any(|s| s.tag == tag);
    there.then(|| read(snapshot, tag)).transpose()
}

/// The drivers, of either version.
fn read_drivers(snapshot: &Snapshot) -> Result<Vec<StoredDriver<TissueFactors>>> {
    let before = (snapshot.sections.iter()).any(|s| s.tag == DRIVERS && s.version == 1);
    if !before {
        return read(snapshot, DRIVERS);
    }
    let drivers: Vec<StoredDriver<FactorsWithoutTension>> = read_version(snapshot, DRIVERS, 1)?;
    Ok(drivers.into_iter().map(Into::into).collect())
}

fn read<T: DeserializeOwned>(snapshot: &Snapshot, tag: [u8; 4]) -> Result<T> {
    read_version(snapshot, tag, version(tag))
}

fn read_version<T: DeserializeOwned>(snapshot: &Snapshot, tag: [u8; 4], known: u32) -> Result<T> {
    let field = format!("snapshot.{}", tag.escape_ascii());
    let found = snapshot.sections.iter().find(|s| s.tag == tag);
    let section = found.ok_or_else(|| Error::invalid(field.clone(), "is missing"))?;
    if section.version != known {
        let version = section.version;
        let problem = format!("version {version}; this build reads {known}");
        return Err(Error::invalid(field, problem));
    }
    let read = postcard::take_from_bytes(&section.content);
    match read {
        Ok((content, [])) => Ok(content),
        Ok(_) => Err(Error::invalid(field, "has bytes left over: it is damaged")),
        Err(e) => Err(Error::invalid(field, format!("is damaged: {e}"))),
    }
}

fn damaged() -> Error {
    Error::invalid("snapshot", "is damaged: its sections do not fit each other")
}
