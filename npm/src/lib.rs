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

/// Before anything else: products of matrices take SIMD where the build has it, and the console is told what a panic said before
/// it becomes a `RuntimeError: unreachable`.
#[wasm_bindgen(start)]
fn start() {
    #[cfg(target_arch = "wasm32")]
    gemm_common::set_wasm_simd128(cfg!(target_feature = "simd128"));
    std::panic::set_hook(Box::new(|panic| error::panicked(&panic.to_string())));
}
