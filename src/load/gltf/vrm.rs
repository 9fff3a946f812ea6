//! VRM 0.x and 1.0: humanoid bones and colliders of spring bones.

use serde::Deserialize;
use serde_json::Value;

/// The `VRM` extension of the root object.
#[derive(Debug, Deserialize)]
pub(super) struct Vrm0 {
    #[serde(default)]
    pub humanoid: Value,
}

/// The `VRMC_vrm` extension of the root object.
#[derive(Debug, Deserialize)]
pub(super) struct Vrm1 {
    #[serde(default)]
    pub humanoid: Value,
}
