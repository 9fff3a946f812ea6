//! A small rasteriser: z-buffer, smooth normals, and light from a dome of shadow-mapped lamps.

mod camera;
mod depth;
mod light;
mod mesh;
mod render;

pub use camera::{Camera, Projection};
pub(super) use mesh::point_cloud;
pub use mesh::{Mesh, Plane};
pub use render::{View, render};
