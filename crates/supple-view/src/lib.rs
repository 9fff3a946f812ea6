//! A window in which a character's flesh is touched: `supple view`.
//!
//! [`App`] is the program whatever shows it: [`Event`]s go in ([`App::handle`]), time goes on ([`App::advance`]), pictures come
//! out ([`App::draw`]). [`open_window`] shows it in a window of winit's; tests show it on a texture. Nothing physical is here: a
//! character is a [`Scene`](supple_scene::Scene) in a [`World`](supple::World).
//!
//! | room | what is in it |
//! |---|---|
//! | `app` | the program: events, pace, commands |
//! | `bake` | from a file to a character on its stage, beside the interface |
//! | `stage` | the world, and what is known of the character in it |
//! | `touch` | grabbing, pressing, throwing |
//! | `draw` | the renderer |
//! | `panel` | the interface, and what paints it |
//! | `platform` | what a page has otherwise than a desktop |
//! | `window` | winit |
//! | `offscreen` | without any window |

mod app;
mod bake;
mod draw;
#[cfg(not(target_arch = "wasm32"))]
mod offscreen;
mod panel;
mod platform;
mod stage;
mod touch;
#[cfg(not(target_arch = "wasm32"))]
mod window;

pub use app::{App, Button, Event, Options, Pace};
pub use bake::{Character, Loading, Request};
pub use draw::{Camera, Gpu, Ray};
#[cfg(not(target_arch = "wasm32"))]
pub use draw::{PICTURE_FORMAT, Picture, picture};
pub use egui::Key;
#[cfg(not(target_arch = "wasm32"))]
pub use offscreen::Offscreen;
pub use panel::{Command, Controls, Notice, Screen, WIDTH as PANEL_WIDTH};
pub use stage::{Measures, Record, Sample, Shown, Stage, ValueMap};
pub use touch::Tool;
#[cfg(not(target_arch = "wasm32"))]
pub use window::open_window;
