//! Files of characters, motions and meshes: a folder a format, reader beside writer.
//!
//! A character becomes a [`Body`](supple_bake::Body) ([`read_character`] knows every format), a recorded or live motion a
//! [`MotionClip`] or [`BonePoses`], which [`motion`] brings to any skeleton. Every parser is bounded in memory, never panics,
//! and names file, place and cure in its errors.

mod amass;
mod array;
mod arrays;
mod body_arrays;
mod bvh;
mod character;
mod colour;
mod file;
pub mod gltf;
mod hand_pose;
pub mod motion;
pub mod npy;
mod npz;
mod obj;
mod painted;
mod pickle;
mod pose_stream;
mod series;
mod smpl;
mod solid;
mod surface_parts;
mod tet_mesh;
mod tissue;
mod tissue_choice;
mod weld;

pub use amass::{AmassOptions, parse_amass, read_amass, read_amass_with, read_betas};
pub use body_arrays::BodyArrays;
pub use bvh::{BvhOptions, bvh_text, parse_bvh, read_bvh, write_bvh};
pub use character::{
    CharacterFile, CharacterFormat, CharacterOptions, FileKind, parse_character, read_character,
};
pub use colour::{BODY_COLOUR, Colour, from_srgb};
pub use file::{read_text, read_toml_text};
pub use gltf::write::{
    GlbOptions, GlbReport, MORPH_TOLERANCE, MOST_MORPHS, Prop, Recording, write_glb, write_glb_with,
};
pub use gltf::{is_gltf_motion, parse_gltf, parse_gltf_motions, read_gltf, read_gltf_motions};
pub use hand_pose::{parse_pose, read_pose};
pub use motion::{
    Align, BodyPart, BoneMap, BonePose, BonePoses, ClipOptions, ClipPlayer, Finger, MapOptions,
    MotionClip, MotionFrame, NextPose, Origin, Part, PoseHeader, PoseOptions, PosePlayer, Retarget,
    RetargetOptions, Side, SourceSkeleton, Unit, blend, body_parts, mirrored_clip, mirrored_header,
    mirrored_poses,
};
pub use obj::{parse_obj, read_closed_obj, read_obj, write_obj};
pub use painted::{read_painted, write_painted};
pub use pose_stream::{PoseParser, PoseReader, clip_as_poses, pose_header_line, pose_line};
pub use series::{
    ENERGY_NAMES, ENERGY_TERMS, Series, energy_terms, loads_by_bone, parse_series, read_series,
    write_series,
};
pub use smpl::{HandPose, SmplKind, SmplModel, parse_smpl, read_smpl, read_smpl_model, write_smpl};
pub use solid::solid_surface;
pub use tet_mesh::{
    BONE, SKIN, TetFile, TetLayer, TetMeshFile, parse_tet_mesh, parse_tetgen, parse_tets,
    read_tet_mesh, read_tets, write_tet_mesh,
};
pub use tissue::{PartNames, separate_tissue};
