//! Scenes: an avatar, what drives it, what it touches, what is measured and drawn. TOML.
//!
//! Every key that a scene does not know is an error, and so is every number that is not finite.

mod body;
mod motion;
mod read;
mod shape;

pub use body::SceneBody;
pub use motion::Motion;
pub(crate) use read::parse_toml;
pub use read::{parse_scene, read_scene};
pub use shape::SceneShape;

use crate::avatar_source::AvatarSource;
use crate::motion::TrackedMotion;
use glam::DVec3;
use serde::{Deserialize, Serialize};
use supple::Result;
use supple::internal::math::rotation_exp;
use supple::material::Material;
use supple::model::{Avatar, Frame, UpAxis};
use supple::sim::Settings;
use supple::skeleton::{Preload, Spring};
use supple_bake::{JointLimitKey, set_limits};

/// A scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scene {
    /// What it is called; results go into a folder of this name.
    pub name: String,
    /// Number of steps.
    pub steps: usize,
    /// The axis that points up in its world ([`Scene::up`]).
    pub up: Option<UpAxis>,
    /// m/s² ([`Scene::gravity`]).
    pub gravity: Option<DVec3>,
    /// Who it is about.
    pub avatar: AvatarSource,
    /// Time step, solver, stiffness of joints and of the skeleton's bending.
    #[serde(default)]
    pub settings: Settings,
    /// In place of the baked material.
    pub material: Option<Material>,
    /// In place of the baked stiffness-proportional damping β, s.
    pub damping_time: Option<f64>,
    /// Where the avatar stands, before anything moves.
    #[serde(default)]
    pub placement: Placement,
    /// The bones' pose at the start and the rest pose of their bending springs; others are straight.
    #[serde(default)]
    pub pose: Vec<BonePose>,
    /// Whose springs carry their weight beforehand.
    #[serde(default)]
    pub preload: Preload,
    /// Whether it starts in equilibrium with what drives and touches it, and not as it was posed.
    #[serde(default = "settles")]
    pub settle: bool,
    /// Bones that follow a motion exactly.
    #[serde(default)]
    pub pins: Vec<Pinned>,
    /// Bones that are drawn to a motion by springs.
    #[serde(default)]
    pub targets: Vec<Target>,
    /// Ranges of joints, in place of those that the avatar has.
    #[serde(default)]
    pub limits: Vec<JointLimitKey>,
    /// A recorded or live motion that the bones are drawn to; `pins` and `targets` go before it.
    pub motion: Option<TrackedMotion>,
    /// What the skin touches.
    #[serde(default)]
    pub colliders: Vec<SceneCollider>,
    /// Rigid bodies that move freely: they fall, rest on colliders, and push the skin as it pushes them.
    #[serde(default)]
    pub bodies: Vec<SceneBody>,
    /// When is measured.
    #[serde(default)]
    pub measure: Measure,
    /// What is drawn.
    #[serde(default)]
    pub output: Output,
}

/// Where the avatar stands. It is stood up first, about the origin of its file ([`Avatar::standing`]): soles at height
/// zero of the file stand at height zero of the world.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Placement {
    /// Where the origin of its file is, m.
    pub position: DVec3,
    /// Rotation vector about that origin, degrees.
    pub rotation_degrees: DVec3,
}

impl Placement {
    /// The rigid transform of a standing avatar.
    pub fn frame(&self) -> Frame {
        Frame {
            rotation: rotation_exp(self.rotation_degrees * std::f64::consts::PI / 180.0),
            position: self.position,
        }
    }
}

/// A bone's rotation relative to its parent.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BonePose {
    /// Name of the bone.
    pub bone: String,
    /// Rotation vector, degrees.
    pub rotation_degrees: DVec3,
}

/// A bone that follows a motion exactly.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Pinned {
    /// Name of the bone.
    pub bone: String,
    /// Relative to where it starts.
    #[serde(default)]
    pub motion: Motion,
}

/// A bone that is drawn to a motion.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Target {
    /// Name of the bone.
    pub bone: String,
    /// Relative to where it starts.
    #[serde(default)]
    pub motion: Motion,
    /// N/m, N·s/m.
    pub position: Spring,
    /// N·m/rad, N·m·s.
    pub rotation: Spring,
}

/// A solid.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SceneCollider {
    /// Name in files that are written.
    pub name: String,
    /// m.
    pub shape: SceneShape,
    /// Penalty stiffness k, Pa/m; as a rule that of the tissue that it touches. It moves the answer: a stiffer one presses
    /// harder.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stiffness: Option<f64>,
    /// d̂: distance at which contact begins, m.
    #[serde(default)]
    pub margin: f64,
    /// Coefficient of friction μ, 0 to 10.
    #[serde(default)]
    pub friction: f64,
    /// Where it is, in the world.
    #[serde(default)]
    pub motion: Motion,
}

/// Times at which the report measures, s.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Measure {
    /// Settled, before contact: what is left of the displacement in the end is measured against it. The start, if not
    /// given.
    pub settled: f64,
    /// Under full press: the contact force's time. The end, if not given.
    pub full_press: f64,
}

impl Default for Measure {
    fn default() -> Self {
        Self {
            settled: 0.0,
            full_press: f64::INFINITY,
        }
    }
}

/// What is drawn and recorded.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Output {
    /// Pictures of the strip, from the left.
    pub panels: Vec<PanelTime>,
    /// Direction in which the camera looks.
    pub view: DVec3,
    /// Whether the camera goes with the avatar from picture to picture.
    pub follow: bool,
    /// Pixels of a panel.
    pub panel_size: [usize; 2],
    /// Opens the skin: what lies in direction `normal` of `point` is not drawn.
    pub cut: Option<Cut>,
    /// Value of the darkest colour, mm; the largest displacement drawn if not given.
    pub legend_mm: Option<f64>,
    /// Whether pictures are drawn quickly rather than smoothly.
    pub draft: bool,
    /// Steps from one recorded state to the next, in the GLB file.
    pub record_every: usize,
    /// Height of a ground that is drawn by the shadows on it alone, m.
    pub floor: Option<f64>,
}

/// A picture's time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PanelTime {
    /// s.
    pub time: f64,
    /// Below the picture.
    pub caption: String,
    /// Shows only what is near a point; everything if not given.
    pub focus: Option<Focus>,
    /// Direction in which the camera looks; [`Output::view`] if not given.
    pub view: Option<DVec3>,
    /// In a corner, the same displacement on the reference shape.
    pub inset: Option<Inset>,
    /// Whether colliders are drawn: without them the skin that they hide is seen.
    #[serde(default = "drawn")]
    pub colliders: bool,
}

impl PanelTime {
    /// Everything, from where the scene looks, at `time` in s.
    pub fn new(time: f64, caption: String) -> Self {
        Self {
            time,
            caption,
            focus: None,
            view: None,
            inset: None,
            colliders: true,
        }
    }
}

/// How the reference shape is looked at.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Inset {
    /// Direction in which the camera looks.
    pub view: DVec3,
    /// What is up in the reference shape; the avatar's own up if not given.
    pub up: Option<DVec3>,
}

/// A ball that fills a picture.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Focus {
    /// Its centre, m.
    pub point: DVec3,
    /// Its radius, m.
    pub radius: f64,
}

/// A plane that opens the skin.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Cut {
    /// A point of it, m.
    pub point: DVec3,
    /// Towards what is not drawn.
    pub normal: DVec3,
}

impl Default for Output {
    fn default() -> Self {
        Self {
            panels: Vec::new(),
            view: DVec3::new(-0.5, 1.0, -0.5),
            follow: false,
            panel_size: [640, 560],
            cut: None,
            legend_mm: None,
            draft: false,
            record_every: 2,
            floor: None,
        }
    }
}

fn settles() -> bool {
    true
}

fn drawn() -> bool {
    true
}

/// Gravity of the earth, m/s².
const EARTH: f64 = 9.81;

impl Scene {
    /// The axis that points up: as stated, else the one that a stated gravity points against most, else z.
    pub fn up(&self) -> UpAxis {
        self.up.unwrap_or_else(|| {
            let against = |axis: UpAxis| -self.gravity.unwrap_or_default().dot(axis.direction());
            let axes = [UpAxis::Z, UpAxis::Y, UpAxis::X];
            let better = |best: UpAxis, axis| match against(axis) > against(best).max(0.0) {
                true => axis,
                false => best,
            };
            axes.into_iter().fold(UpAxis::Z, better)
        })
    }

    /// m/s²: as stated, else that of the earth, downward.
    pub fn gravity(&self) -> DVec3 {
        (self.gravity).unwrap_or_else(|| -EARTH * self.up().direction())
    }

    /// Time at the end of the last step, s.
    pub fn duration(&self) -> f64 {
        self.steps as f64 * self.settings.time_step
    }

    /// Gives `avatar` what the scene has in place of the baked: its tissue, its joints' ranges, and its
    /// bodies in addition.
    ///
    /// # Errors
    /// [`supple::Error::Invalid`] of a range ([`set_limits`]) or a body ([`Avatar::add_body`]).
    pub fn dress(&self, avatar: &mut Avatar) -> Result<()> {
        avatar.material = self.material.unwrap_or(avatar.material);
        if let Some(damping_time) = self.damping_time {
            avatar.set_damping_time(damping_time);
        }
        set_limits(&mut avatar.skeleton, &self.limits)?;
        (self.bodies.iter()).try_for_each(|body| avatar.add_body(body.rigid_body()?))
    }

    /// Number of colliders that the skin may meet, those of bodies among them.
    pub fn collider_count(&self) -> usize {
        self.colliders.len() + self.bodies.len()
    }

    /// The step whose end is nearest to `time`, from 1 to the number of steps.
    pub fn step_at(&self, time: f64) -> usize {
        ((time / self.settings.time_step).round() as usize).min(self.steps)
    }
}
