//! Files in: one file a format.

mod tet_mesh;

pub use tet_mesh::{TetMeshFile, parse_tet_mesh, read_tet_mesh};
