//! All that moves in a world, as bytes and back.
//!
//! | file | what is in it |
//! |---|---|
//! | `sections` | bytes |
//! | `settings` | what holds for all |
//! | `characters` | what each is and what drives it |

mod characters;
mod sections;
mod settings;

use super::backend::Room;
use super::batch::Batch;
use super::character::Character;
use super::contents::{Body, World};
use super::keys::{BodyId, ColliderId, InstanceId};
use crate::collider::Collider;
use crate::file::Section;
use crate::model::{Frame, Integrator};
use crate::sim::{Settings, SolverMode};
use crate::{Error, Result};
use characters::{StoredFine, StoredHistory, StoredSprings, StoredState};
use sections::{checksum, damaged, read, read_drivers, read_optional, section};
use serde::{Deserialize, Serialize};
use settings::{StoredIntegration, StoredWorld};
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
/// Without it no fine handle is awake.
const FINE: [u8; 4] = *b"FINE";

#[derive(Serialize, Deserialize)]
struct StoredAsset {
    name: String,
    checksum: u32,
    room: Room,
}

/// Budget of fine handles, slots of each avatar, and what is awake of each instance.
type StoredWaking = (usize, Vec<usize>, Vec<StoredFine>);

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
        let fine: Vec<_> = characters().map(Character::stored_fine).collect();
        let avatars = self.batches.iter().filter(|b| !b.is_body);
        let slots: Vec<usize> = avatars.map(|batch| batch.room().fine_slots).collect();
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
                section(FINE, &(self.settings.fine_handles, slots, fine))?,
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
        let waking: Option<StoredWaking> = read_optional(snapshot, FINE)?;
        let (budget, slots, fine) = waking.unwrap_or_default();
        settings.fine_handles = budget;
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
            && (fine.is_empty() || fine.len() == states.len())
            && (slots.is_empty() || slots.len() == assets.len())
            && (histories.iter()).all(|h| h.len() == states.len() + body_states.len());
        if !counted || !world.gravity.is_finite() {
            return Err(damaged());
        }
        for (asset, stored) in assets.iter().enumerate() {
            let fine_slots = slots.get(asset).copied().unwrap_or_default();
            let fine_slots = (self.opened).fine_slots(self.batches[asset].base(), fine_slots);
            self.make_room(
                asset,
                Room {
                    fine_slots,
                    ..stored.room
                },
            )?;
        }
        let mut histories = histories.into_iter().flatten();
        let mut fine = fine.into_iter();
        let time_step = settings.time_step;
        let mut characters = Vec::new();
        let stored = states.into_iter().zip(drivers).zip(springs).zip(offsets);
        for (&place, (((state, driver), springs), offsets)) in instances.values().zip(stored) {
            let batch = self.batches.get(place.0).filter(|_| place.0 < avatars);
            let batch = batch.filter(|b| place.1 < b.characters.len());
            let batch = batch.ok_or_else(damaged)?;
            let stored_slots = slots.get(place.0).copied().unwrap_or_default();
            if state.state.handles.len() != batch.avatar.coarse_handles() + stored_slots {
                return Err(damaged());
            }
            let mut character = batch.character(world.gravity, &Frame::IDENTITY);
            let restored = (character.restore(
                state,
                histories.next(),
                driver,
                &springs,
                fine.next().unwrap_or_default(),
                time_step,
            ))
            .and_then(|()| character.set_pose_offsets(&offsets));
            restored.map_err(|e| e.within("snapshot"))?;
            characters.push((place, character));
        }
        // Bodies' assets come after the avatars', in the order that they had.
        let mut made = Vec::new();
        for (body, state) in bodies.values_mut().zip(body_states) {
            let (mut batch, evaluator) =
                Batch::of_body(&mut self.opened, &body.rigid, settings, world.gravity)?;
            batch.characters[0].restore_state(
                state,
                histories.next(),
                StoredFine::default(),
                time_step,
            )?;
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
