//! The formats: small sound files, and what reads them.

use super::seeds;
#[cfg(feature = "draco")]
use crate::draco_file::with_stream;
use crate::gltf::{materials, meshopt};
use std::collections::BTreeMap;
use std::path::Path;
use supple::glam::{DMat3, DVec3};
use supple::internal::random_avatar;
use supple_files as motion;
use supple_files::{
    BvhOptions, PoseReader, Recording, parse_gltf, parse_gltf_motions, parse_obj, parse_smpl,
    parse_tetgen, parse_tets, write_glb,
};
use supple_scene::{parse_avatar_source, parse_scene};

/// A format.
pub struct Format {
    pub name: &'static str,
    pub seeds: Vec<Vec<u8>>,
    /// What makes a damaged piece a whole file again: checksums, the archive around it.
    pub wrap: fn(Vec<u8>) -> Vec<u8>,
    /// Whether a file is accepted.
    pub parse: fn(&[u8]) -> bool,
}

/// No file of this name is there, nor any beside it.
fn path() -> &'static Path {
    Path::new("nowhere/damaged")
}

fn plain(name: &'static str, seeds: Vec<Vec<u8>>, parse: fn(&[u8]) -> bool) -> Format {
    Format {
        name,
        seeds,
        wrap: |bytes| bytes,
        parse,
    }
}

fn text(bytes: &[u8]) -> Option<&str> {
    std::str::from_utf8(bytes).ok()
}

fn smpl(bytes: &[u8]) -> bool {
    let Ok(read) = parse_smpl(bytes, path()) else {
        return false;
    };
    let model = read.model;
    model.evaluate(
        &[0.1],
        &vec![DMat3::IDENTITY; model.parents.len()],
        DVec3::ZERO,
    );
    read.hands
        .iter()
        .all(|hand| hand.rotations(&[0.1], false).is_ok() || hand.components.is_empty())
}

pub fn smpl_npz() -> Format {
    plain("smpl_npz", vec![seeds::smpl_archive()], smpl)
}

pub fn smpl_npy_inside() -> Format {
    Format {
        wrap: |bytes| seeds::with_member(&seeds::smpl_archive(), "J_regressor.npy", &bytes),
        ..plain("smpl_npy_inside", seeds::regressors(), smpl)
    }
}

pub fn pickle() -> Format {
    plain("pickle", seeds::pickles(), smpl)
}

pub fn obj() -> Format {
    plain("obj", vec![seeds::OBJ.into()], |bytes| {
        parse_obj(bytes, path()).is_ok()
    })
}

pub fn gltf() -> Format {
    plain("gltf", seeds::gltf(), character)
}

fn character(bytes: &[u8]) -> bool {
    parse_gltf(bytes, path()).is_ok_and(|character| {
        let shapes = character.shapes().len().min(1);
        character.body(&[0.5][..shapes]).is_ok()
    })
}

pub fn gltf_meshopt() -> Format {
    plain("gltf_meshopt", seeds::meshopt(), |bytes| {
        parse_gltf_motions(bytes, path()).is_ok() & character(bytes)
    })
}

pub fn meshopt_inside() -> Format {
    Format {
        wrap: |bytes| meshopt::with_positions(&bytes),
        ..plain("meshopt_inside", seeds::meshopt_streams(), character)
    }
}

/// Materials, textures and images, and every attribute that is kept; what is read is written again.
pub fn gltf_painted() -> Format {
    plain("gltf_painted", vec![materials::embedded().glb()], |bytes| {
        let Ok(read) = parse_gltf(bytes, path()) else {
            return false;
        };
        let Ok(body) = read.body(&[]) else {
            return false;
        };
        // As on an avatar of a few vertices.
        let mut avatar = random_avatar(1, 2, 2, 3, 12);
        let count = avatar.skin.len() as u32;
        avatar.render_meshes = body.render_meshes;
        (avatar.render_meshes.iter_mut())
            .for_each(|part| part.vertices.iter_mut().for_each(|v| *v %= count));
        avatar.appearance = body.appearance;
        avatar.validate().unwrap();
        let recording = Recording {
            times: vec![0.0],
            states: vec![avatar.rest_state()],
            ..Recording::default()
        };
        let nowhere = std::env::temp_dir().join("supple_painted.glb");
        let nowhere = if cfg!(unix) {
            Path::new("/dev/null")
        } else {
            &nowhere
        };
        write_glb(&avatar, &recording, nowhere).unwrap();
        true
    })
}

#[cfg(feature = "draco")]
pub fn gltf_draco() -> Format {
    let seeds = seeds::draco_streams();
    let files = seeds.iter().map(|stream| with_stream(stream).glb());
    plain("gltf_draco", files.collect(), character)
}

#[cfg(feature = "draco")]
pub fn draco_inside() -> Format {
    Format {
        wrap: |bytes| with_stream(&bytes).glb(),
        ..plain("draco_inside", seeds::draco_streams(), character)
    }
}

pub fn gltf_motions() -> Format {
    plain("gltf_motions", seeds::gltf_motions(), |bytes| {
        parse_gltf_motions(bytes, path()).is_ok()
    })
}

pub fn tets() -> Format {
    plain("tets", seeds::tets(), |bytes| {
        let Ok(file) = parse_tets(bytes, path()) else {
            return false;
        };
        // What is read must be fit for use, or refused.
        let _ = file.body("damaged", &BTreeMap::new());
        let _ = file.layer(&["wrist".into()], &BTreeMap::new());
        true
    })
}

pub fn tetgen() -> Format {
    plain("tetgen", vec![seeds::TETGEN.into()], |bytes| {
        let mut files = bytes.split(|b| *b == b'%');
        let [nodes, tets, faces] = [(); 3].map(|()| files.next().unwrap_or_default());
        parse_tetgen(nodes, tets, Some(faces), path()).is_ok()
    })
}

pub fn bvh() -> Format {
    let seeds = vec![seeds::BVH.into(), seeds::BVH_ALONG_X.into()];
    plain("bvh", seeds, |bytes| {
        let text = String::from_utf8_lossy(bytes);
        motion::parse_bvh(&text, path(), &BvhOptions::default()).is_ok()
    })
}

fn amass_file(bytes: &[u8]) -> bool {
    motion::parse_amass(bytes, path()).is_ok()
}

pub fn amass() -> Format {
    let [parts, aist] = seeds::amass_relatives();
    plain(
        "amass",
        vec![seeds::amass_archive(), parts, aist],
        amass_file,
    )
}

pub fn series() -> Format {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("series.npz");
    let series = motion::Series {
        time: vec![0.01],
        vertices: vec![DVec3::X; 3],
        displacement: vec![DVec3::Y; 3],
        contact_force: vec![DVec3::Z; 3],
        loads: vec![[1.0; 6]],
        energies: vec![[0.5; motion::ENERGY_TERMS]],
        faces: vec![[0, 1, 2]],
        bone_names: vec!["root".into()],
    };
    motion::write_series(&series, &file).unwrap();
    let seed = std::fs::read(&file).unwrap();
    plain("series", vec![seed], |bytes| {
        motion::parse_series(bytes, path()).is_ok()
    })
}

pub fn amass_npy_inside() -> Format {
    Format {
        wrap: |bytes| seeds::with_member(&seeds::amass_archive(), "poses.npy", &bytes),
        ..plain("amass_npy_inside", vec![seeds::amass_poses()], amass_file)
    }
}

pub fn pose() -> Format {
    plain("pose", vec![seeds::POSE.into()], |bytes| {
        text(bytes).is_some_and(|text| motion::parse_pose(text, path()).is_ok())
    })
}

pub fn pose_stream() -> Format {
    plain("pose_stream", vec![seeds::POSE_STREAM.into()], |bytes| {
        let mut reader = PoseReader::new(bytes, path());
        loop {
            match reader.next_pose() {
                Ok(Some(_)) => {}
                Ok(None) => return true,
                Err(_) => return false,
            }
        }
    })
}

pub fn baked() -> Format {
    Format {
        wrap: seeds::with_checksum,
        ..plain("baked", vec![seeds::baked()], |bytes| {
            supple_bake::from_bytes(bytes, path()).is_ok()
        })
    }
}

pub fn scene() -> Format {
    plain("scene", seeds::scenes(), |bytes| {
        text(bytes).is_some_and(|text| parse_scene(text, path()).is_ok())
    })
}

pub fn recipe() -> Format {
    plain("recipe", vec![seeds::RECIPE.into()], |bytes| {
        text(bytes).is_some_and(|text| parse_avatar_source(text, path()).is_ok())
    })
}
