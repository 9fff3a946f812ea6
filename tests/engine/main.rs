//! The engine's tests, in the rooms of `src`.

mod imports;
mod model;
mod potential;
mod sim;
mod skeleton;
mod support;
mod world;
