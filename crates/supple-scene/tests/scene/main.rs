//! Scenes read, refused and played, and any character baked with no recipe.

mod assets;
mod documented_keys;
mod motion;
mod scenes;
mod showing;
mod standing;
#[path = "../../../../tests/engine/support.rs"]
mod support;
