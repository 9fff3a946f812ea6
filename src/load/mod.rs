//! Files in: one file a format.

pub(crate) mod npy;
mod obj;
mod smpl;
mod tet_mesh;

pub use obj::{read_closed_obj, read_obj};
pub use smpl::read_smpl;
pub use tet_mesh::{TetMeshFile, parse_tet_mesh, read_tet_mesh};
