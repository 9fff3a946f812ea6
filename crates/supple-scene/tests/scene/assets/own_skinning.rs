//! Whether a baked avatar, at rest in a pose, is its file's own skinning.

use super::evaluation::{Evaluation, local_rest};
use std::path::Path;
use std::sync::Arc;
use supple::glam::{DMat3, DMat4, DQuat, DVec3};
use supple::internal::math::Random;
use supple::model::{Avatar, Frame};
use supple::potential::CpuPotential;
use supple::sim::{Pin, Settings, Simulation};
use supple_files::{CharacterOptions, read_character, read_gltf, read_smpl};

/// The largest distance of a vertex of the avatar, after steps in a pose of the file at `path`, from where the
/// file's own skinning has it, m.
pub fn largest_distance(path: &Path, avatar: &Avatar) -> f64 {
    match path.extension().unwrap().to_str().unwrap() {
        "glb" => of_gltf(path, avatar),
        _ => of_smpl(path, avatar),
    }
}

/// Every bone a little turned.
fn turn(random: &mut Random) -> DQuat {
    DQuat::from_scaled_axis(0.25 * random.vector(1.0))
}

fn of_gltf(path: &Path, avatar: &Avatar) -> f64 {
    let file = Evaluation::new(&std::fs::read(path).unwrap());
    let mut random = Random::new(7);
    let mut turns = vec![DQuat::IDENTITY; file.document.nodes().count()];
    for bone in &avatar.skeleton.names {
        turns[node(&file, bone)] = turn(&mut random);
    }
    let posed = file.world(&|n| local_rest(n) * DMat4::from_quat(turns[n.index()]));
    let rest = file.rest();
    let character = read_gltf(path).unwrap();
    let of_file = character.body(&[]).unwrap().skeleton;
    let frames: Vec<Frame> = (avatar.skeleton.names.iter())
        .map(|bone| {
            let n = node(&file, bone);
            // The avatar has those of the file's bones that carry something.
            let in_rest = character.rest[of_file.find(bone).unwrap()];
            Frame {
                rotation: rotation(posed[n]) * rotation(rest[n]).transpose() * in_rest.rotation,
                position: posed[n].w_axis.truncate(),
            }
        })
        .collect();
    let found = held(avatar, &frames);
    let expected = file.skinned(&posed);
    assert_eq!(avatar.render_meshes.len(), expected.len());
    let parts = avatar.render_meshes.iter().zip(&expected);
    parts
        .flat_map(|(part, expected)| {
            assert_eq!(part.vertices.len(), expected.len());
            let pairs = part.vertices.iter().zip(expected);
            pairs.map(|(v, x)| found[*v as usize].distance(*x))
        })
        .fold(0.0, f64::max)
}

/// The node of a bone.
fn node(file: &Evaluation, bone: &str) -> usize {
    let named = file.document.nodes().find(|n| n.name() == Some(bone));
    named
        .unwrap_or_else(|| panic!("no node is called {bone}"))
        .index()
}

/// The rotation of a matrix without shear; a file's f32 numbers make it one but for rounding.
fn rotation(m: DMat4) -> DMat3 {
    let m = DMat3::from_mat4(m);
    let unit = DMat3::from_cols(
        m.x_axis.normalize(),
        m.y_axis.normalize(),
        m.z_axis.normalize(),
    );
    DMat3::from_quat(DQuat::from_mat3(&unit).normalize())
}

fn of_smpl(path: &Path, avatar: &Avatar) -> f64 {
    let model = read_smpl(path).unwrap();
    let mut random = Random::new(7);
    let local: Vec<DMat3> = (0..model.parents.len())
        .map(|_| DMat3::from_quat(turn(&mut random)))
        .collect();
    let skeleton = &avatar.skeleton;
    let found = held(
        avatar,
        &skeleton.forward_kinematics(&local, skeleton.joints[0]),
    );
    let expected = model.evaluate(&[], &local, DVec3::ZERO);
    let file_vertices = read_character(path, &CharacterOptions::default())
        .unwrap()
        .file_vertices;
    assert_eq!(file_vertices.len(), avatar.tissue_vertices());
    let pairs = found.iter().zip(&file_vertices);
    pairs
        .map(|(x, v)| x.distance(expected[*v as usize]))
        .fold(0.0, f64::max)
}

/// The drawn skin after some steps under gravity with the bones held at `frames`.
fn held(avatar: &Avatar, frames: &[Frame]) -> Vec<DVec3> {
    let avatar = Arc::new(avatar.clone());
    let potential = CpuPotential::new(avatar.clone(), 1).unwrap();
    let mut simulation = Simulation::new(&avatar, potential, Settings::default()).unwrap();
    let instance = &mut simulation.instances_mut()[0];
    instance.pose(frames, &avatar.skeleton.parents);
    let pins = frames.iter().enumerate();
    instance.pins = pins.map(|(bone, &frame)| Pin { bone, frame }).collect();
    for _ in 0..5 {
        simulation.step_blocking().unwrap();
    }
    let (mut skin, mut normals) = (Vec::new(), Vec::new());
    simulation
        .read_skin_blocking(0, &mut skin, &mut normals)
        .unwrap();
    skin
}
