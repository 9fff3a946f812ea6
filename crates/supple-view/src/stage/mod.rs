//! The stage: a world in which a character does what its scene says, and what is known of it after each step.

mod measures;
mod record;
mod shown;

pub use measures::{Measures, Sample};
pub use record::Record;
pub use shown::{Shown, ValueMap};

use crate::bake::Character;
use glam::DVec3;
use std::sync::Arc;
use supple::collider::Collider;
use supple::model::Frame;
use supple::potential::TissueFactors;
use supple::sim::{Settings, Timings};
use supple::skeleton::Spring;
use supple::world::{Backend, BodyId, ColliderId, InstanceId, Snapshot};
use supple::{Result, World};
use supple_scene::{Driver, Scene, SceneCollider};

/// A character in its world.
pub struct Stage {
    /// Who it is about.
    pub character: Box<Character>,
    /// The world.
    pub world: World,
    /// The character in it.
    pub me: InstanceId,
    /// Colliders of the scene, in its order.
    pub colliders: Vec<ColliderId>,
    /// Bodies of the scene, in its order.
    pub bodies: Vec<BodyId>,
    /// s.
    pub time: f64,
    /// How often it was put back to the start: what came later is gone then.
    pub rounds: usize,
    /// How firmly bones are held where the scene draws them: a factor on its springs.
    pub grip: f64,
    /// What it is like after the last step.
    pub shown: Shown,
    /// What was measured lately.
    pub measures: Measures,
    /// What happened lately, for files.
    pub record: Record,
    driver: Driver,
    /// Springs of the scene's targets, before the grip: rotation and position.
    springs: Vec<[Option<Spring>; 2]>,
    start: Snapshot,
    /// A moment that somebody kept, and when it was.
    kept: Option<(Snapshot, f64)>,
}

impl Stage {
    /// Puts a character into a world of its own.
    ///
    /// # Errors
    /// What the world, the scene's driver and the first equilibrium say.
    pub async fn new(mut character: Box<Character>, backend: Backend) -> Result<Self> {
        let (avatar, scene) = (character.avatar.clone(), character.scene.clone());
        let settings = Settings {
            report_at_end: true,
            ..scene.settings
        };
        let world = World::open(backend).await?;
        let mut world = world.with_up(scene.up()).with_settings(settings)?;
        world.set_gravity(scene.gravity());
        world.compile_kernels(&avatar.material).await?;
        let asset = world.add_avatar(avatar.clone())?;
        let me = world.add_instance(asset)?;
        // States, files and springs are of the avatar with room for what may wake.
        let slots = world.instance(me)?.avatar().fine.slots;
        if slots > avatar.fine.slots {
            character.avatar = Arc::new((*avatar).clone().with_fine_slots(slots)?);
        }
        let driver = driver(&character)?;
        let instance = world.instance_mut(me)?.instance_mut();
        for bending in &mut instance.bending {
            bending.stiffness = settings.bending_stiffness;
            bending.damping = settings.joint_damping_time * settings.bending_stiffness;
        }
        driver.start(&avatar, instance);
        let springs = instance.targets.iter().map(|t| [t.rotation, t.position]);
        let springs = springs.collect();
        let colliders = scene
            .colliders
            .iter()
            .map(|c| world.add_collider(collider(c)));
        let colliders = colliders.collect::<Result<_>>()?;
        let mut bodies = Vec::new();
        for body in &scene.bodies {
            let id = world.add_body(body.rigid_body()?)?;
            world.set_body_motion(id, &body.initial_frame(), body.velocity, body.spin())?;
            bodies.push(id);
        }
        if scene.settle {
            world.settle().await?;
        }
        driver.launch(&avatar, world.instance_mut(me)?.instance_mut());
        let start = world.snapshot()?;
        let mut stage = Self {
            shown: Shown::new(&character),
            record: Record::new(scene.up()),
            measures: Measures::default(),
            character,
            world,
            me,
            colliders,
            bodies,
            time: 0.0,
            rounds: 0,
            grip: 1.0,
            driver,
            springs,
            start,
            kept: None,
        };
        stage.read(true).await?;
        Ok(stage)
    }

    /// The time step, s.
    pub fn time_step(&self) -> f64 {
        self.character.scene.settings.time_step
    }

    /// Another time step, s, for the steps that follow.
    pub fn set_time_step(&mut self, time_step: f64) {
        self.character.scene.settings.time_step = time_step;
    }

    /// Factors on its tissue from the next step on.
    ///
    /// # Errors
    /// Factors that are unusable.
    pub fn set_factors(&mut self, factors: TissueFactors) -> Result<()> {
        self.world.instance_mut(self.me)?.set_factors(factors)
    }

    /// How many fine handles may be awake from the next step on.
    ///
    /// # Errors
    /// None: any number is usable.
    pub fn set_fine_handles(&mut self, fine_handles: usize) -> Result<()> {
        let settings = *self.world.settings();
        self.world.set_settings(Settings {
            fine_handles: fine_handles.min(self.character.avatar.fine.slots),
            ..settings
        })
    }

    /// Fine handles that are awake now.
    pub fn awake(&self) -> usize {
        let me = self.world.instance(self.me);
        me.map_or(0, |character| character.state().awake.len())
    }

    /// The character in the world.
    ///
    /// # Errors
    /// None: it stands there.
    pub fn character_mut(&mut self) -> Result<&mut supple::world::Character> {
        self.world.instance_mut(self.me)
    }

    /// One step: what drives it moves on, and everything with it.
    ///
    /// # Errors
    /// What the step says; everything is as it was then.
    pub async fn step(&mut self) -> Result<()> {
        let time_step = self.time_step();
        let (mut time, grip) = (self.time + time_step, self.grip);
        match self.character.round {
            Some(round) if time > round && self.character.sways => time -= round,
            // A scene begins again with all that is in it.
            Some(round) if time > round + 1e-9 => {
                self.rewind()?;
                time = time_step;
            }
            _ => {}
        }
        let instance = self.world.instance_mut(self.me)?.instance_mut();
        self.driver.drive(time, instance)?;
        for (target, springs) in instance.targets.iter_mut().zip(&self.springs) {
            let gripped = |spring: Spring| Spring {
                stiffness: grip * spring.stiffness,
                // A little more than as much of it: what hangs loosely would swing for long.
                damping: grip.powf(0.85) * spring.damping,
            };
            [target.rotation, target.position] = springs.map(|s| s.map(gripped));
        }
        for (key, frame) in self.colliders.iter().zip(self.driver.collider_frames(time)) {
            self.world.collider_mut(*key)?.frame = frame;
        }
        self.world.step(time_step).await?;
        self.time = time;
        Ok(())
    }

    /// Reads what the last step left: skin, contacts, displacements. The skin of a world on the device is drawn from where it
    /// is, and read only where somebody wants to `touch` it.
    ///
    /// # Errors
    /// A lost device.
    pub async fn read(&mut self, touch: bool) -> Result<()> {
        let (world, me) = (&mut self.world, self.me);
        let shown = &mut self.shown;
        if touch || world.skin_buffer(me)?.is_none() {
            (world.read_skin(me, &mut shown.positions, &mut shown.normals)).await?;
        }
        if shown.map() == ValueMap::Pressure {
            (world.read_contacts(me, &mut shown.forces, &mut shown.pressures)).await?;
        }
        let character = world.instance(me)?;
        shown.displacement = character.displacement();
        self.shown.colour(&self.character);
        Ok(())
    }

    /// Notes what the last step said of itself, where so many `seconds` have passed since the last note and a spring holds the
    /// skin with `pull`, N.
    ///
    /// # Errors
    /// None: the character stands there.
    pub fn note(&mut self, seconds: f64, pull: f64) -> Result<()> {
        let character = self.world.instance(self.me)?;
        let report = character.report();
        let largest = |values: &[DVec3]| values.iter().map(|d| d.length()).fold(0.0, f64::max);
        self.measures.add(Sample {
            time: self.measures.now() + seconds,
            force: report.contact_force.length(),
            pull,
            displacement: largest(&self.shown.displacement),
            contacts: report.contacts,
            iterations: report.iterations,
        });
        let bones = self.character.avatar.bones();
        self.record
            .add(self.measures.now(), character.state(), bones);
        Ok(())
    }

    /// Times of the last step, ms.
    pub fn timings(&self) -> Timings {
        self.world.timings()
    }

    /// Lowest and highest corner of the skin, m.
    pub fn bounds(&self) -> [DVec3; 2] {
        let skin = &self.shown.positions;
        [
            skin.iter().copied().reduce(DVec3::min).unwrap_or_default(),
            skin.iter().copied().reduce(DVec3::max).unwrap_or_default(),
        ]
    }

    /// Back to the start; bodies that came later are gone.
    ///
    /// # Errors
    /// None that a sound world has.
    pub async fn reset(&mut self) -> Result<()> {
        self.rewind()?;
        self.record.clear();
        self.read(true).await
    }

    fn rewind(&mut self) -> Result<()> {
        self.world.restore(&self.start)?;
        // Poses that are read as time goes on are read again.
        self.driver = driver(&self.character)?;
        self.time = 0.0;
        self.rounds += 1;
        Ok(())
    }

    /// Keeps this moment.
    ///
    /// # Errors
    /// None that a sound world has.
    pub fn keep(&mut self) -> Result<()> {
        self.kept = Some((self.world.snapshot()?, self.time));
        Ok(())
    }

    /// Whether a moment is kept.
    pub fn has_kept(&self) -> bool {
        self.kept.is_some()
    }

    /// Back to the moment that was kept, if one was.
    ///
    /// # Errors
    /// None that a sound world has.
    pub async fn restore(&mut self) -> Result<()> {
        if let Some((snapshot, time)) = &self.kept {
            self.world.restore(snapshot)?;
            self.time = *time;
            self.record.clear();
        }
        self.read(true).await
    }
}

/// What drives a character; bodies are the world's.
fn driver(character: &Character) -> Result<Driver> {
    let alone = Scene {
        bodies: Vec::new(),
        ..character.scene.clone()
    };
    Driver::new(&alone, &character.avatar)
}

/// A scene's collider in a world.
fn collider(of: &SceneCollider) -> Collider {
    let frame: Frame = of.motion.at(0.0);
    Collider {
        stiffness: of.stiffness,
        margin: of.margin,
        friction: of.friction,
        ..Collider::new((*of.shape).clone(), frame)
    }
}
