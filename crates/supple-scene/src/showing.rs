//! A scene that nobody wrote: an avatar on a ground that plays a clip, or is shaken or just stands where there is none.

use crate::avatar_source::AvatarSource;
use crate::motion::{Playback, TrackedMotion};
use crate::scene::{
    Measure, Motion, Output, PanelTime, Pinned, Placement, Scene, SceneCollider, Target,
};
use glam::DVec3;
use serde::Serialize;
use std::fmt;
use supple::collider::{Collider, Shape};
use supple::internal::cpu::posed_skin;
use supple::internal::math::{rotation_exp, rotation_log};
use supple::model::{Avatar, State, UpAxis};
use supple::sim::Settings;
use supple::skeleton::Preload;
use supple::{Error, Result};
use supple_files::{CharacterFormat, FileKind, read_gltf_motions};

/// What a shown avatar does.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "does", rename_all = "snake_case")]
pub enum Showing {
    /// It follows a clip or poses.
    Follows {
        /// The motion's file.
        file: String,
        /// s.
        seconds: f64,
    },
    /// Its bones keep their bind pose, and all of them are carried to and fro, up and down.
    Shaken {
        /// s.
        seconds: f64,
    },
}

impl fmt::Display for Showing {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Follows { file, seconds } => {
                write!(f, "it follows {file} for {seconds:.2} s")
            }
            Self::Shaken { seconds } => write!(
                f,
                "nothing moves it, so its bones are shaken for {seconds:.2} s"
            ),
        }
    }
}

/// The motion that the character's own file holds, if it is a glTF file and does; and what is to be said of one that is
/// broken: the character is shown all the same.
///
/// # Errors
/// [`Error::Io`] where it cannot be read.
pub fn own_clip(source: &AvatarSource) -> Result<(Option<TrackedMotion>, Option<String>)> {
    let Some(model) = source.model() else {
        return Ok((None, None));
    };
    if FileKind::of(model)? != FileKind::Character(CharacterFormat::Gltf) {
        return Ok((None, None));
    }
    Ok(match read_gltf_motions(model) {
        Ok(clips) if clips.is_empty() => (None, None),
        Ok(_) => (Some(TrackedMotion::of_file(model)), None),
        Err(e) => (None, Some(format!("no clip of its own: {e}"))),
    })
}

/// Pictures a second.
const PICTURE_RATE: f64 = 20.0;
/// Longest time that is shown where nobody says how long, s.
const LONGEST: f64 = 8.0;

impl Scene {
    /// A scene of `avatar` alone, up z; [`Scene::show`] gives it something to do.
    pub fn of_avatar(name: &str, avatar: AvatarSource) -> Self {
        let plain = |c: char| match c.is_ascii_alphanumeric() || "_-".contains(c) {
            true => c,
            false => '_',
        };
        let name: String = name.chars().map(plain).collect();
        Self {
            name: if name.is_empty() {
                "avatar".into()
            } else {
                name
            },
            steps: 1,
            up: Some(UpAxis::Z),
            gravity: None,
            avatar,
            settings: Settings::default(),
            material: None,
            damping_time: None,
            placement: Placement::default(),
            pose: Vec::new(),
            preload: Preload::default(),
            settle: true,
            pins: Vec::new(),
            targets: Vec::new(),
            limits: Vec::new(),
            motion: None,
            colliders: Vec::new(),
            bodies: Vec::new(),
            measure: Measure::default(),
            output: Output::default(),
        }
    }

    /// Whether nothing drives the avatar and nothing is there to touch it: it would only fall.
    pub fn is_idle(&self) -> bool {
        self.pins.is_empty()
            && self.targets.is_empty()
            && self.motion.is_none()
            && self.colliders.is_empty()
            && self.bodies.is_empty()
    }

    /// Gives the scene of [`Scene::of_avatar`], or one that is idle, something to do: `avatar` follows `motion` for
    /// `seconds`, its whole length (at most 8 s) if not given, above a ground that its soles just reach; without a motion it
    /// stands on the ground and is shaken. Panels show it 20 times a second.
    ///
    /// # Errors
    /// What opening the motion says; [`Error::Invalid`] of `seconds`.
    pub fn show(
        &mut self,
        avatar: &Avatar,
        motion: Option<TrackedMotion>,
        seconds: Option<f64>,
    ) -> Result<Showing> {
        if let Some(s) = seconds.filter(|s| !(*s > 0.0 && *s <= 3600.0)) {
            let problem = format!("must be positive and an hour at most, is {s}");
            return Err(Error::invalid("seconds", problem));
        }
        let showing = match motion {
            Some(motion) => self.follow(avatar, motion, seconds)?,
            None => self.shake(avatar, seconds),
        };
        let (Showing::Follows { seconds, .. } | Showing::Shaken { seconds }) = showing;
        let step = self.settings.time_step;
        self.steps = ((seconds / step + 1e-9).floor() as usize).max(1);
        self.measure = Measure {
            settled: 0.0,
            full_press: self.duration(),
        };
        let every = (1.0 / (PICTURE_RATE * step)).round().max(1.0) * step;
        let pictures = (self.duration() / every).floor() as usize;
        let panel = |k: usize| {
            let time = every * k as f64;
            PanelTime::new(time.min(self.duration()), format!("{time:.2} s"))
        };
        self.output = Output {
            panels: (0..=pictures).map(panel).collect(),
            view: UpAxis::Z.rotation_to(self.up()) * DVec3::new(-0.8, 0.6, -0.15),
            follow: true,
            panel_size: [400, 520],
            draft: true,
            record_every: (1.0 / (30.0 * step)).round().max(1.0) as usize,
            ..self.output.clone()
        };
        Ok(showing)
    }

    fn follow(
        &mut self,
        avatar: &Avatar,
        mut motion: TrackedMotion,
        seconds: Option<f64>,
    ) -> Result<Showing> {
        let mut state = self.standing(avatar);
        // Poses that come in are read once: where feet will be is not known before.
        let mut soles = self.lowest(avatar, &state);
        let mut whole = LONGEST;
        let playback = match motion.is_standard_input() {
            true => None,
            false => Some(Playback::open(
                &motion,
                &avatar.character(),
                avatar.up,
                self.up(),
            )?),
        };
        if let Some(Playback::Clip(mut player)) = playback {
            motion.ease_in = 0.0;
            let left = (player.clip().duration() - motion.start).max(0.0) / motion.speed;
            whole = left.clamp(1.0, LONGEST);
            player.stand_at(&state.frames);
            let looks = (PICTURE_RATE * seconds.unwrap_or(whole)).ceil().min(400.0);
            soles = f64::INFINITY;
            for k in 0..=looks as usize {
                let time = seconds.unwrap_or(whole) * k as f64 / looks;
                let frames = player.frames(time);
                state.frames[..frames.len()].copy_from_slice(&frames);
                soles = soles.min(self.lowest(avatar, &state));
            }
        }
        self.add_ground(soles);
        let file = motion.file.display().to_string();
        self.motion = Some(motion);
        let seconds = seconds.unwrap_or(whole);
        Ok(Showing::Follows { file, seconds })
    }

    /// Carries all bones sideways and up by 3 % of the avatar's height, as fast as makes 8 m/s², and lets it swing out.
    fn shake(&mut self, avatar: &Avatar, seconds: Option<f64>) -> Showing {
        /// Peak of ω² times the way, m/s²: below g, so that soles stay where they are felt to be.
        const ACCELERATION: f64 = 8.0;
        /// Way for a height.
        const SHARE: f64 = 0.03;
        const SWINGS: usize = 4;
        const HOPS: usize = 2;
        const SWINGS_OUT: f64 = 0.6;
        let start = self.standing(avatar);
        let up = self.up().direction();
        let skin = posed_skin(avatar, &start).positions;
        let heights = skin.iter().map(|p| p.dot(up));
        let (soles, top) = heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), z| {
            (l.min(z), h.max(z))
        });
        let way = SHARE * (top - soles).max(1e-3);
        let quarter = 0.5
            * std::f64::consts::PI
            * (way / ACCELERATION)
                .sqrt()
                .max(2.0 * self.settings.time_step);
        let mut time = 10.0 * self.settings.time_step;
        let mut keys = |count: usize, places: &[f64]| {
            let mut track = vec![[time, 0.0]];
            for _ in 0..count {
                for place in places {
                    time += 2.0 * quarter;
                    track.push([time, place * way]);
                }
            }
            time += quarter;
            track.push([time, 0.0]);
            track
        };
        let aside = keys(SWINGS, &[1.0, -1.0]);
        let upward = keys(HOPS, &[2.0, 0.0]);
        let motion = motion_along(self.up(), upward, aside);
        let moved = (0..avatar.bones()).filter(|&bone| !avatar.is_carried(bone));
        let pin = |bone: usize| Pinned {
            bone: avatar.skeleton.names[bone].clone(),
            motion: motion.clone(),
        };
        self.pins = moved.map(pin).collect();
        self.add_ground(soles);
        Showing::Shaken {
            seconds: seconds.unwrap_or(time + SWINGS_OUT),
        }
    }

    /// Lets `avatar` stand on a ground in a scene of [`Scene::of_avatar`] and sway about its soles, as a person who stands
    /// still does. Gives the time of one sway, s: whoever shows it for longer begins again then.
    pub fn stand(&mut self, avatar: &Avatar) -> f64 {
        /// s.
        const SWAY: f64 = 4.0;
        const DEGREES: f64 = 1.2;
        let start = self.standing(avatar);
        let up = self.up().direction();
        let skin = posed_skin(avatar, &start).positions;
        let soles = self.lowest(avatar, &start);
        let middle = skin.iter().sum::<DVec3>() / skin.len().max(1) as f64;
        let pivot = middle + (soles - middle.dot(up)) * up;
        // Those who stand up along z face −y: forward and back again.
        let axis = UpAxis::Z.rotation_to(self.up()) * DVec3::X;
        let lean = rotation_exp(axis * DEGREES.to_radians());
        let there_and_back = |way: f64| vec![[0.0, 0.0], [0.5 * SWAY, way], [SWAY, 0.0]];
        let turn = (DEGREES * axis).to_array();
        let springs = TrackedMotion::default();
        let moved = (0..avatar.bones()).filter(|&bone| !avatar.is_carried(bone));
        let target = |bone: usize| {
            let arm = start.frames[bone].position - pivot;
            let [x, y, z] = (lean * arm - arm).to_array().map(there_and_back);
            let [a, b, c] = turn;
            Target {
                bone: avatar.skeleton.names[bone].clone(),
                motion: Motion {
                    x,
                    y,
                    z,
                    rotation_degrees: vec![[0.0; 4], [0.5 * SWAY, a, b, c], [SWAY, 0.0, 0.0, 0.0]],
                },
                position: springs.position,
                rotation: springs.rotation,
            }
        };
        self.targets = moved.map(target).collect();
        self.add_ground(soles);
        self.steps = (SWAY / self.settings.time_step).round() as usize;
        SWAY
    }

    /// Where the avatar stands before anything moves, in its bind pose.
    fn standing(&self, avatar: &Avatar) -> State {
        avatar.placed(&(self.placement.frame()).compose(&avatar.standing(self.up())))
    }

    /// Height of the skin's lowest point, m.
    fn lowest(&self, avatar: &Avatar, state: &State) -> f64 {
        let up = self.up().direction();
        let heights = posed_skin(avatar, state)
            .positions
            .into_iter()
            .map(|p| p.dot(up));
        heights.fold(f64::INFINITY, f64::min)
    }

    /// Puts a ground at `height`, drawn by the shadows on it.
    fn add_ground(&mut self, height: f64) {
        let turn = rotation_log(Collider::ground(self.up()).frame.rotation);
        let [x, y, z] = turn.to_array().map(f64::to_degrees);
        let motion = Motion {
            rotation_degrees: vec![[0.0, x, y, z]],
            ..motion_along(self.up(), vec![[0.0, height]], Vec::new())
        };
        self.colliders.push(SceneCollider {
            name: "ground".into(),
            shape: Shape::HalfSpace.into(),
            stiffness: None,
            margin: 0.0,
            friction: 0.0,
            motion,
        });
        self.output.floor = Some(height);
    }
}

/// Up and sideways as a motion's tracks.
fn motion_along(up: UpAxis, upward: Vec<[f64; 2]>, aside: Vec<[f64; 2]>) -> Motion {
    let rotation_degrees = Vec::new();
    let (x, y, z) = match up {
        UpAxis::X => (upward, aside, Vec::new()),
        UpAxis::Y => (aside, upward, Vec::new()),
        UpAxis::Z => (aside, Vec::new(), upward),
    };
    Motion {
        x,
        y,
        z,
        rotation_degrees,
    }
}
