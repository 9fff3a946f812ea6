//! Files in: one file a format.

mod array;
mod arrays;
mod avatar_source;
mod character;
mod file;
mod fingerprint;
pub mod gltf;
pub mod motion;
pub(crate) mod npy;
mod npz;
mod obj;
mod painted;
mod pickle;
pub mod scene;
mod smpl;
mod surface_parts;
mod tet_mesh;
mod tissue;
mod weld;

pub use avatar_source::{
    AvatarSource, Sample, SourceBody, avatar_source_of, load_avatar, parse_avatar_source,
    read_avatar_source, read_recipe_for,
};
#[cfg(feature = "cli")]
pub(crate) use avatar_source::{PALM, SOFT, map_of};
pub use character::{CharacterFile, CharacterFormat, CharacterOptions, FileKind, read_character};
pub(crate) use fingerprint::Fingerprint;
pub use gltf::{parse_gltf, parse_gltf_motions, read_gltf, read_gltf_motions};
pub use obj::{parse_obj, read_closed_obj, read_obj};
pub use scene::{Scene, parse_scene, read_scene};
pub use smpl::{HandPose, SmplKind, SmplModel, parse_smpl, read_smpl, read_smpl_model};
pub use tet_mesh::{
    BONE, SKIN, TetFile, TetLayer, TetMeshFile, parse_tet_mesh, parse_tetgen, parse_tets,
    read_tet_mesh, read_tets,
};
pub use tissue::separate_tissue;
