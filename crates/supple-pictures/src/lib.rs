//! Pictures: avatars, bakes and runs, drawn on the CPU, so that they come out without an adapter; and charts.
//!
//! [`render`] draws [`Mesh`]es, [`Strip`] puts panels, captions and a [`Legend`] on one sheet, and [`Curves`] are SVG.

mod animation;
mod axis;
mod bake_pictures;
mod colour;
mod colour_scale;
mod curves;
mod image;
mod layer_cut;
mod motion_strip;
mod number;
mod raster;
mod scene_strip;
mod strip;
mod text;

pub use animation::Animation;
pub use bake_pictures::{BakePicture, bake_pictures, tissue_depths, write_bake_pictures};
pub use colour::{Colour, category_colour, colour_map, diverging_map, from_srgb};
pub use colour_scale::ColourScale;
pub use curves::{Curves, Mark, Scale, Series};
pub use image::Image;
pub use layer_cut::cut_layer;
pub use motion_strip::{Figure, motion_strip};
pub use number::number;
pub use raster::{Camera, Mesh, Plane, Projection, View, render};
pub use scene_strip::{picture_animation, picture_strip};
pub use strip::{Legend, Panel, Strip};
pub use text::FONT_FILE;
