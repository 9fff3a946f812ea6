//! A scene's bones and colliders in time.

use super::motion_driver::MotionDriver;
use crate::motion::Playback;
use crate::scene::{Motion, Scene, SceneBody, SceneCollider, Target};
use glam::{DMat3, DVec3};
use supple::collider::Collider;
use supple::internal::math::rotation_exp;
use supple::model::{Avatar, Frame};
use supple::sim::{Instance, Pin};
use supple::skeleton::{Preload, Tracking};
use supple::{Error, Result};
use supple_files::BoneMap;

/// A scene whose names are resolved against an avatar.
pub struct Driver {
    gravity: DVec3,
    file_axes: DMat3,
    start: Vec<Frame>,
    motion: Option<MotionDriver>,
    preload: Preload,
    pins: Vec<(usize, Motion)>,
    targets: Vec<(usize, Target)>,
    colliders: Vec<SceneCollider>,
    bodies: Vec<SceneBody>,
    time_step: f64,
}

impl Driver {
    /// Finds the scene's bones in `avatar`, and opens its motion; a stream's first pose is waited for.
    ///
    /// # Errors
    /// [`Error::Invalid`] naming the bone that is not there and those that are; what opening the motion
    /// says.
    pub fn new(scene: &Scene, avatar: &Avatar) -> Result<Self> {
        let there = avatar.bodies.iter().map(|b| &b.name);
        if !there.eq(scene.bodies.iter().map(|b| &b.name)) {
            let problem = "the avatar has others; give it the scene's by Scene::dress";
            return Err(Error::invalid("bodies", problem));
        }
        let all = &avatar.skeleton;
        let skeleton = &avatar.character();
        let find = |name: &str, field: String| {
            all.find(name).ok_or_else(|| {
                let bones = all.names.join(", ");
                Error::invalid(
                    field,
                    format!("no bone is called {name:?}; there are {bones}"),
                )
            })
        };
        let mut local = vec![DMat3::IDENTITY; skeleton.len()];
        for (i, pose) in scene.pose.iter().enumerate() {
            let field = format!("pose[{i}].bone");
            let bone = find(&pose.bone, field.clone())?;
            *(local.get_mut(bone)).ok_or_else(|| Error::invalid(field, "names a body"))? =
                rotation_exp(pose.rotation_degrees * std::f64::consts::PI / 180.0);
        }
        let motion = scene.motion.as_ref();
        let playback = motion
            .map(|m| Playback::open(m, skeleton, avatar.up, scene.up()))
            .transpose()?;
        let placement = (scene.placement.frame()).compose(&avatar.standing(scene.up()));
        let mut start = skeleton.forward_kinematics(&local, skeleton.joints[0]);
        start.iter_mut().for_each(|f| *f = placement.compose(f));
        let pins = scene.pins.iter().enumerate().map(|(i, pin)| {
            Ok((
                find(&pin.bone, format!("pins[{i}].bone"))?,
                pin.motion.clone(),
            ))
        });
        let targets = scene.targets.iter().enumerate().map(|(i, target)| {
            Ok((
                find(&target.bone, format!("targets[{i}].bone"))?,
                target.clone(),
            ))
        });
        let pins: Vec<_> = pins.collect::<Result<_>>()?;
        let targets: Vec<_> = targets.collect::<Result<_>>()?;
        let own = |bone: usize| {
            pins.iter().any(|(b, _)| *b == bone) || targets.iter().any(|(b, _)| *b == bone)
        };
        let motion = match motion.zip(playback) {
            Some((motion, playback)) => {
                let step = scene.settings.time_step;
                let driver = MotionDriver::new(motion, playback, skeleton, &mut start, step, own)?;
                Some(driver)
            }
            None => None,
        };
        start.extend(scene.bodies.iter().map(SceneBody::initial_frame));
        Ok(Self {
            gravity: scene.gravity(),
            file_axes: avatar.standing(scene.up()).rotation,
            start,
            motion,
            preload: scene.preload,
            pins,
            targets,
            colliders: scene.colliders.clone(),
            bodies: scene.bodies.clone(),
            time_step: scene.settings.time_step,
        })
    }

    /// Puts `instance` where the scene starts, at rest; [`Driver::launch`] says what moves there.
    pub fn start(&self, avatar: &Avatar, instance: &mut Instance) {
        instance.pose(&self.start, &avatar.skeleton.parents);
        instance.gravity = self.gravity;
        instance.file_axes = self.file_axes;
        instance.preload = self.preload;
        let pin = |(bone, motion): &(usize, Motion)| Pin {
            bone: *bone,
            frame: self.driven(*bone, motion, 0.0),
        };
        instance.pins = self.pins.iter().map(pin).collect();
        let target = |(bone, target): &(usize, Target)| Tracking {
            position: Some(target.position),
            rotation: Some(target.rotation),
            ..Tracking::new(*bone, self.driven(*bone, &target.motion, 0.0))
        };
        instance.targets = self.targets.iter().map(target).collect();
        if let Some(motion) = &self.motion {
            motion.start(&self.start, instance);
        }
        let collider = |c: &SceneCollider| Collider {
            stiffness: c.stiffness,
            margin: c.margin,
            friction: c.friction,
            ..Collider::new((*c.shape).clone(), c.motion.at(0.0))
        };
        instance.colliders = avatar.body_colliders().collect();
        (instance.colliders).extend(self.colliders.iter().map(collider));
    }

    /// Gives what moves at the start its velocity: bodies, and bones of a clip that is not eased in.
    pub fn launch(&self, avatar: &Avatar, instance: &mut Instance) {
        for (i, body) in self.bodies.iter().enumerate() {
            let frame = avatar.body_frame(i);
            let at = instance.state.frames[frame];
            instance.set_motion(frame, at, body.velocity, body.spin());
        }
        if let Some(motion) = &self.motion {
            motion.launch(&self.start, self.time_step, instance);
        }
    }

    /// Which of the motion's bones drives which of the avatar's, if there is a motion.
    pub fn bone_map(&self) -> Option<&BoneMap> {
        self.motion.as_ref().map(MotionDriver::bone_map)
    }

    /// What is to be known of its motion, a sentence each.
    pub fn motion_notes(&self) -> &[String] {
        self.motion.as_ref().map_or(&[], MotionDriver::notes)
    }

    /// Moves what is driven to `time`, the end of the next step. Times must not fall; a stream is waited
    /// for.
    ///
    /// # Errors
    /// What reading a stream of poses says.
    pub fn drive(&mut self, time: f64, instance: &mut Instance) -> Result<()> {
        for (pin, (bone, motion)) in instance.pins.iter_mut().zip(&self.pins) {
            pin.frame = self.driven(*bone, motion, time);
        }
        for (target, (bone, wanted)) in instance.targets.iter_mut().zip(&self.targets) {
            target.frame = self.driven(*bone, &wanted.motion, time);
        }
        for (collider, frame) in instance
            .colliders
            .iter_mut()
            .skip(self.bodies.len())
            .zip(self.collider_frames(time))
        {
            collider.frame = frame;
        }
        match &mut self.motion {
            Some(motion) => motion.drive(
                time,
                &self.start,
                self.pins.len(),
                self.targets.len(),
                instance,
            ),
            None => Ok(()),
        }
    }

    /// Where the colliders are at `time`.
    pub fn collider_frames(&self, time: f64) -> impl Iterator<Item = Frame> {
        self.colliders.iter().map(move |c| c.motion.at(time))
    }

    /// A bone's frame at the start, moved by `motion`.
    fn driven(&self, bone: usize, motion: &Motion, time: f64) -> Frame {
        let (start, moved) = (self.start[bone], motion.at(time));
        Frame {
            rotation: moved.rotation * start.rotation,
            position: start.position + moved.position,
        }
    }
}
