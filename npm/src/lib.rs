//! The wasm of the npm package: the engine as one class, whose arrays the JavaScript side sees as views of the wasm's memory.
//!
//! `index.js` is the package's API and the only caller: numbers and typed arrays go in, JSON where there are names, and what is
//! wrong is thrown as the classes of `errors.js`. Nothing physical is here.

mod avatar;
mod buffers;
mod colliders;
mod driving;
mod error;
mod parts;
mod reading;
mod settings;

use wasm_bindgen::prelude::*;

/// Tells the console what a panic said, before it becomes a `RuntimeError: unreachable`.
#[wasm_bindgen(start)]
fn start() {
    std::panic::set_hook(Box::new(|panic| error::panicked(&panic.to_string())));
}
