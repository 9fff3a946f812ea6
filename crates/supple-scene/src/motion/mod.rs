//! A scene's `[motion]`: its key, and playing it.

mod playback;
mod tracked;

pub use playback::{Playback, PoseFeed, read_motion};
pub use tracked::{RootTracking, TrackedMotion};
