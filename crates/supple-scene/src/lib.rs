//! Scenes: an avatar, what drives it, what it touches, what is measured and drawn. TOML lives here only.
//!
//! [`read_scene`] reads one, [`load_avatar`] finds or bakes who it is about, [`run_scene`] plays and measures it.

mod avatar_source;
mod committed;
mod fingerprint;
mod motion;
mod run;
mod scene;
mod showing;

pub use avatar_source::{
    AvatarSource, BodyOrigin, BodySource, CharacterSource, SourceBody, avatar_source_of,
    load_avatar, parse_avatar_source, read_avatar_source, read_recipe_for,
};
pub use committed::{committed_scenes, unpack_scenes};
pub use motion::{Playback, PoseFeed, RootTracking, TrackedMotion, read_motion};
pub use run::{
    Breakdown, COLLIDER_COLOUR, Driver, EnergyReport, FullSpaceRun, HALF_SPACE_EXTENT, Median,
    Report, SceneRun, Snapshot, Spread, run_full_space, run_scene, run_scene_as_series,
};
pub use scene::{
    BonePose, Cut, Focus, Inset, Measure, Motion, Output, PanelTime, Pinned, Placement, Scene,
    SceneBody, SceneCollider, SceneShape, Target, parse_scene, read_scene,
};
pub use showing::{Showing, own_clip};
