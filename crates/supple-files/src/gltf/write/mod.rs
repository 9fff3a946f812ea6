//! Motion as a skinned GLB with morph targets.
//!
//! glTF moves a vertex by its morphs before it is skinned, which is exactly x = W(T + U φ): bones play
//! the frames, morphs the unposed displacement U φ and the pose blend shapes with it. A viewer needs
//! nothing of this crate.

mod buffer;
mod document;
mod materials;
mod morph;
mod normals;
mod part;
mod skin;

pub use document::{GlbOptions, GlbReport, write_glb, write_glb_with};
pub use morph::{MORPH_TOLERANCE, MOST_MORPHS};

use crate::Colour;
use serde::{Deserialize, Serialize};
use supple::model::{Avatar, Frame, State, Surface, UpAxis};
use supple::{Error, Result};

/// What an avatar and the things around it did.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Recording {
    /// The axis that points up in their world.
    pub up: UpAxis,
    /// Rising, s.
    pub times: Vec<f64>,
    /// A state for each time.
    pub states: Vec<State>,
    /// Rigid things beside the avatar.
    pub props: Vec<Prop>,
}

impl Default for Recording {
    /// Nothing, in a world of z up.
    fn default() -> Self {
        Self {
            up: UpAxis::Z,
            times: Vec::new(),
            states: Vec::new(),
            props: Vec::new(),
        }
    }
}

/// A rigid thing in a recording.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Prop {
    /// Its name in the file.
    pub name: String,
    /// Its surface, in its own frame.
    pub surface: Surface,
    /// Its colour.
    pub colour: Colour,
    /// A frame for each time.
    pub frames: Vec<Frame>,
}

impl Recording {
    /// Checks lengths, order and finiteness against `avatar`.
    pub fn validate(&self, avatar: &Avatar) -> Result<()> {
        let check = |ok: bool, field: &str, problem: &str| match ok {
            true => Ok(()),
            false => Err(Error::invalid(field, problem)),
        };
        let count = self.times.len();
        let rising = self.times.windows(2).all(|t| t[0] < t[1]);
        check(
            count > 0 && rising && self.times.iter().all(|t| t.is_finite()),
            "recording.times",
            "must be finite, rising and at least one",
        )?;
        let fits = |s: &State| s.space() == avatar.space() && s.is_finite();
        check(
            self.states.len() == count && self.states.iter().all(fits),
            "recording.states",
            "one finite state of this avatar is needed for each time",
        )?;
        check(
            self.props.iter().all(|p| p.frames.len() == count),
            "recording.props",
            "one frame is needed for each time",
        )
    }
}
