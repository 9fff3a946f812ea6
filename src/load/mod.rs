//! Files in: one file a format.

mod avatar_source;
pub(crate) mod npy;
mod npz;
mod obj;
pub mod scene;
mod smpl;
mod tet_mesh;

pub use avatar_source::{AvatarSource, Sample, read_avatar_source, read_avatar_source_or_scene};
pub use obj::{read_closed_obj, read_obj};
pub use scene::{Scene, parse_scene, read_scene};
pub use smpl::read_smpl;
pub use tet_mesh::{TetMeshFile, parse_tet_mesh, read_tet_mesh};
