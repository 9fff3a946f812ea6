//! A scene's `[motion]`: which file, and how the avatar follows it.

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use supple::model::UpAxis;
use supple::skeleton::Spring;
use supple::{Error, Result};
use supple_files::{
    Align, ClipOptions, MapOptions, Origin, PoseOptions, RetargetOptions, Side, Unit,
};

/// A motion that the avatar is drawn to.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct TrackedMotion {
    /// `.bvh`, `.npz` (AMASS), `.glb`, `.gltf`, `.vrm` or `.vrma`, `.jsonl`, `.js` or `.json` (one pose); `-` is
    /// a stream of JSON lines on standard input.
    pub file: PathBuf,
    /// Which of a glTF file's animations; the first if not given.
    pub clip: Option<String>,
    /// The unit of a BVH file's lengths; centimetres if not given.
    pub unit: Option<Unit>,
    /// Frames a second, in place of what the file says: of a BVH file, or of an AMASS one, which may not say.
    pub rate: Option<f64>,
    /// The axis that points up in the motion's world, where the file does not say.
    pub up: Option<UpAxis>,
    /// From the motion's bones to the avatar's, where names do not tell; an empty name leaves a bone out.
    pub map: BTreeMap<String, String>,
    /// Whose hand it is, where only the motion or only the avatar has both.
    pub hand: Option<Side>,
    /// Exchanges left and right.
    pub mirror: bool,
    /// How rest poses are aligned.
    pub align: Align,
    /// Frame of the clip that is the avatar's bind pose, in place of any alignment.
    pub rest_frame: Option<usize>,
    /// Metres of the avatar's way for one of the motion's; by the length of the legs if not given.
    pub scale: Option<f64>,
    /// Where it takes place; where the avatar stands, for all but streams that state no axes.
    pub origin: Option<Origin>,
    /// Time of the clip at which it starts, s.
    pub start: f64,
    /// Seconds of the clip a second.
    pub speed: f64,
    /// Whether the clip starts again when it ends, from where it ended.
    #[serde(rename = "loop")]
    pub repeat: bool,
    /// Time in which the avatar goes over from where it stands to the motion, s; with 0 it begins in the
    /// motion's first pose.
    pub ease_in: f64,
    /// How the hips follow the motion's places ([`supple_files::Retarget::root`]).
    pub root: RootTracking,
    /// How bones are drawn to the motion's rotations; N·m/rad, N·m·s.
    pub rotation: Spring,
    /// How the root is drawn to the motion's places; N/m, N·s/m.
    pub position: Spring,
}

/// How the hips, or what stands for them, follow the motion's places.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RootTracking {
    /// Drawn by springs.
    #[default]
    Track,
    /// Exactly, in place and rotation.
    Pin,
    /// Not at all: springs keep it where it stands, and only its rotation follows.
    Hold,
    /// Not at all, and nothing keeps it; only its rotation follows.
    Free,
}

impl Default for TrackedMotion {
    /// Stiff enough for a person's weight to lower the root by less than a millimetre.
    fn default() -> Self {
        Self {
            file: PathBuf::new(),
            clip: None,
            unit: None,
            rate: None,
            up: None,
            map: BTreeMap::new(),
            hand: None,
            mirror: false,
            align: Align::default(),
            rest_frame: None,
            scale: None,
            origin: None,
            start: 0.0,
            speed: 1.0,
            repeat: false,
            ease_in: 0.5,
            root: RootTracking::default(),
            rotation: Spring {
                stiffness: 1e4,
                damping: 100.0,
            },
            position: Spring {
                stiffness: 1e6,
                damping: 1e4,
            },
        }
    }
}

impl TrackedMotion {
    /// The motion of `file` with the defaults of everything else.
    pub fn of_file(file: impl Into<PathBuf>) -> Self {
        Self {
            file: file.into(),
            ..Self::default()
        }
    }

    /// Whether poses come in on standard input.
    pub fn is_standard_input(&self) -> bool {
        self.file == Path::new("-")
    }

    /// Puts a relative path into `folder`.
    pub fn resolve(&mut self, folder: &Path) {
        if !self.is_standard_input() {
            self.file = folder.join(&self.file);
        }
    }

    /// Checks what needs no file to be judged.
    ///
    /// # Errors
    /// [`Error::Invalid`] naming the key.
    pub fn validate(&self) -> Result<()> {
        let check = |ok: bool, key: &str, problem: &str| {
            ok.then_some(())
                .ok_or_else(|| Error::invalid(format!("motion.{key}"), problem))
        };
        check(
            !self.file.as_os_str().is_empty(),
            "file",
            "names a file, or - for standard input",
        )?;
        if let Some(unit) = &self.unit {
            check(
                unit.metres().is_ok(),
                "unit",
                "must be m, cm, mm, in, ft or a positive number of metres",
            )?;
        }
        check(
            self.rate.is_none_or(|r| r > 0.0 && r.is_finite()),
            "rate",
            "must be positive (frames a second)",
        )?;
        check(self.speed > 0.0, "speed", "must be positive")?;
        check(self.start >= 0.0, "start", "must be zero or positive (s)")?;
        check(
            self.ease_in >= 0.0,
            "ease_in",
            "must be zero or positive (s)",
        )?;
        check(
            self.scale.is_none_or(|s| s > 0.0),
            "scale",
            "must be positive",
        )?;
        for (key, spring) in [("rotation", self.rotation), ("position", self.position)] {
            check(
                spring.stiffness >= 0.0 && spring.damping >= 0.0,
                key,
                "stiffness and damping must be zero or positive",
            )?;
        }
        Ok(())
    }

    /// How any motion is brought to an avatar of `avatar_up` in a world where `up` points up.
    fn retarget_options(&self, avatar_up: UpAxis, up: UpAxis) -> RetargetOptions {
        RetargetOptions {
            map: MapOptions {
                table: self.map.clone(),
                hand: self.hand,
            },
            align: self.align,
            scale: self.scale,
            avatar_up: Some(avatar_up),
            up: up.direction(),
        }
    }

    pub(super) fn clip_options(&self, avatar_up: UpAxis, up: UpAxis) -> ClipOptions {
        ClipOptions {
            retarget: self.retarget_options(avatar_up, up),
            rest_frame: self.rest_frame,
            start: self.start,
            speed: self.speed,
            repeat: self.repeat,
            origin: self.origin.unwrap_or_default(),
        }
    }

    pub(super) fn pose_options(&self, avatar_up: UpAxis, up: UpAxis) -> PoseOptions {
        PoseOptions {
            retarget: self.retarget_options(avatar_up, up),
            origin: self.origin,
        }
    }
}
