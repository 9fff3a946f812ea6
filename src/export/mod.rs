//! Pictures, GLB and reports out.
//!
//! [`render`] draws [`Mesh`]es on the CPU, so that pictures come out without an adapter; [`Strip`] puts
//! panels, captions and a [`Legend`] on one sheet.

mod bake_pictures;
mod bvh;
mod colour;
mod colour_scale;
mod glb;
mod image;
mod layer_cut;
mod motion_strip;
mod obj;
mod painted;
mod pose_lines;
mod raster;
mod report;
mod run;
mod skin;
mod smpl;
mod strip;
mod tet_mesh;
mod text;

pub use bake_pictures::{BakePicture, bake_pictures, write_bake_pictures};
pub use bvh::{bvh_text, write_bvh};
pub use colour::{Colour, category_colour, colour_map, diverging_map, from_srgb};
pub use colour_scale::ColourScale;
pub use glb::{GlbReport, MORPH_TOLERANCE, MOST_MORPHS, Prop, Recording, write_glb};
pub use image::Image;
pub use layer_cut::cut_layer;
pub use motion_strip::{Figure, motion_strip};
pub use obj::write_obj;
pub use painted::write_painted;
pub use pose_lines::{clip_as_poses, pose_header_line, pose_line};
pub use raster::{Camera, Mesh, Plane, Projection, View, render};
pub use report::{Breakdown, EnergyReport, Median, Report, Spread};
pub use run::{Driver, FullSpaceRun, SceneRun, Snapshot, picture_strip, run_full_space, run_scene};
pub use skin::{posed_skin, skin_displacement, unposed_skin};
pub use smpl::write_smpl;
pub use strip::{Legend, Panel, Strip};
pub use tet_mesh::write_tet_mesh;
