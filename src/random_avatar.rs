//! Seeded avatars with valid but arbitrary data: every number is random, so that tests and benches
//! see no accidental zero or symmetry.

use crate::material::{LocalTissue, Material, StableNeoHookean};
use crate::math::{Random, Rows};
use crate::model::{
    Avatar, BasisEntry, BoneMass, Frame, JointList, PointSet, PoseBlend, Skeleton, SkinWeight,
    SoftLayer, State, TetMesh, UpAxis,
};
use glam::{DQuat, DVec3};
use std::f64::consts::TAU;

/// Bones of a random point, handles of a cubature point and of a skin vertex: a hand's numbers.
const BONES_PER_POINT: usize = 4;
const HANDLES_PER_POINT: usize = 10;
const HANDLES_PER_VERTEX: usize = 5;
/// Skin vertices that are attached, without area.
const ATTACHED: usize = 3;

/// An avatar about 0.1 m in size. The skin is a closed torus of `vertices` (at least 12) vertices, and
/// everything carries pose blend shapes and damping. Its last three vertices are attached.
pub fn random_avatar(
    seed: u64,
    bones: usize,
    handles: usize,
    points: usize,
    vertices: usize,
) -> Avatar {
    let random = &mut Random::new(seed);
    let bones = bones.max(1);
    let skeleton = Skeleton {
        aliases: Vec::new(),
        limits: Vec::new(),
        names: (0..bones).map(|j| format!("bone {j}")).collect(),
        parents: (0..bones)
            .map(|j| (j > 0).then(|| random.index(j.max(1)) as u32))
            .collect(),
        joints: (0..bones).map(|_| random.vector(0.04)).collect(),
    };
    let bone_masses = (0..bones).map(|_| bone_mass(random)).collect();
    let handle_positions: Vec<DVec3> = (0..handles).map(|_| random.vector(0.05)).collect();
    let positions = (0..points).map(|_| random.vector(0.05)).collect();
    let cubature = point_set(random, positions, bones, handles, HANDLES_PER_POINT, 1e-4);
    let (positions, triangles) = torus(vertices.max(12));
    let mut skin = point_set(random, positions, bones, handles, HANDLES_PER_VERTEX, 0.03);
    let tissue = skin.len() - ATTACHED;
    skin.measure[tissue..].fill(0.0);
    let followed = |k: usize| (0..k as u32).map(|v| (v, 0.4));
    Avatar {
        name: format!("random {seed}"),
        joints: JointList::of_bones(&skeleton),
        up: UpAxis::Z,
        skeleton,
        bone_masses,
        springs: Default::default(),
        handles: handle_positions,
        cubature,
        layer: layer(random, bones, handles, tissue),
        triangles,
        // Some above the stiffest that is taken.
        contact_stiffness: (0..skin.len())
            .map(|v| 1e7 * (1.0 + (v % 16) as f64))
            .collect(),
        attached: (0..ATTACHED).map(followed).collect(),
        skin,
        pose_extension: pose_extension(seed, points, tissue),
        render_meshes: Vec::new(),
        appearance: Default::default(),
        material: Material::StableNeoHookean(StableNeoHookean {
            youngs_modulus: 3e4,
            poissons_ratio: 0.45,
        }),
        tissue: local_tissue(seed, points),
        density: 1000.0,
        captured_under_gravity: true,
        fine: Default::default(),
        bodies: Vec::new(),
        body_slots: 0,
    }
}

/// A state some way from rest: bones turned by up to `angle` rad and shifted by up to `distance` m,
/// handles displaced by up to `distance`.
pub fn random_state(seed: u64, avatar: &Avatar, angle: f64, distance: f64) -> State {
    let random = &mut Random::new(seed);
    let frames = avatar.skeleton.joints.iter().map(|&joint| Frame {
        rotation: random.rotation(angle),
        position: joint + random.vector(distance),
    });
    State {
        frames: frames.collect(),
        handles: (0..avatar.handles.len())
            .map(|_| random.vector(distance))
            .collect(),
        awake: Vec::new(),
    }
}

/// Offsets of the skin of up to `distance` m in each axis.
pub fn pose_offsets(seed: u64, avatar: &Avatar, distance: f64) -> Vec<[f32; 3]> {
    let random = &mut Random::new(seed);
    let offset = |_| random.vector(distance).as_vec3().to_array();
    (0..avatar.offset_vertices()).map(offset).collect()
}

/// Second moments of a few random grains, so that S is positive definite.
fn bone_mass(random: &mut Random) -> BoneMass {
    let mut second_moment = [[0.0; 4]; 4];
    for _ in 0..8 {
        let y = random.vector(0.02).extend(1.0).to_array();
        for (row, a) in second_moment.iter_mut().zip(y) {
            for (entry, b) in row.iter_mut().zip(y) {
                *entry += 0.005 * a * b;
            }
        }
    }
    BoneMass { second_moment }
}

/// Positions with random weights, basis and blend shapes; measures sum to about `total`.
fn point_set(
    random: &mut Random,
    position: Vec<DVec3>,
    bones: usize,
    handles: usize,
    handles_per_point: usize,
    total: f64,
) -> PointSet {
    let count = position.len();
    let share = total / count.max(1) as f64;
    let features = 9 * (bones - 1);
    PointSet {
        measure: (0..count)
            .map(|_| share * random.uniform(0.5, 1.5))
            .collect(),
        skinning: (0..count).map(|_| skin_weights(random, bones)).collect(),
        basis: (0..count)
            .map(|_| basis_entries(random, handles, handles_per_point))
            .collect(),
        pose_blend: PoseBlend {
            features,
            columns: (0..features * count)
                .map(|_| random.vector(1e-3).as_vec3().to_array())
                .collect(),
        },
        position,
    }
}

fn skin_weights(random: &mut Random, bones: usize) -> Vec<SkinWeight> {
    let mut row: Vec<_> = random
        .subset(bones, BONES_PER_POINT)
        .into_iter()
        .map(|bone| SkinWeight {
            bone: bone as u32,
            weight: random.uniform(0.1, 1.0),
        })
        .collect();
    let sum: f64 = row.iter().map(|w| w.weight).sum();
    row.iter_mut().for_each(|w| w.weight /= sum);
    row
}

fn basis_entries(random: &mut Random, handles: usize, wanted: usize) -> Vec<BasisEntry> {
    random
        .subset(handles, wanted)
        .into_iter()
        .map(|handle| BasisEntry {
            handle: handle as u32,
            value: random.uniform(-0.1, 1.0) / wanted as f64,
            gradient: random.vector(60.0) / wanted as f64,
        })
        .collect()
}

/// A helical grid on a torus: each vertex is joined to the next one and to the one a turn later.
fn torus(vertices: usize) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let turn = (vertices as f64).sqrt() as usize;
    let position = |i: usize| {
        let (minor, major) = (
            TAU * i as f64 / turn as f64,
            TAU * i as f64 / vertices as f64,
        );
        let ring = 0.04 + 0.02 * minor.cos();
        DVec3::new(ring * major.cos(), ring * major.sin(), 0.02 * minor.sin())
    };
    let at = |i: usize| (i % vertices) as u32;
    let quad = |i| {
        let (a, b, c, d) = (at(i), at(i + turn), at(i + turn + 1), at(i + 1));
        [[a, b, c], [a, c, d]]
    };
    (
        (0..vertices).map(position).collect(),
        (0..vertices).flat_map(quad).collect(),
    )
}

/// A cube of six tets, its lower face fixed to bone 0.
fn layer(random: &mut Random, bones: usize, handles: usize, vertices: usize) -> SoftLayer {
    let corner = |n: usize| {
        DVec3::new((n & 1) as f64, (n >> 1 & 1) as f64, (n >> 2 & 1) as f64) * 0.1 - 0.05
    };
    let tets = vec![
        [0, 1, 3, 7],
        [0, 3, 2, 7],
        [0, 2, 6, 7],
        [0, 6, 4, 7],
        [0, 4, 5, 7],
        [0, 5, 1, 7],
    ];
    let fixed = |n: usize| n < 4;
    let basis: Rows<(u32, f64)> = (0..8)
        .map(|n| {
            let entries = basis_entries(random, if fixed(n) { 0 } else { handles }, 4);
            entries.into_iter().map(|e| (e.handle, e.value))
        })
        .collect();
    SoftLayer {
        tissue_fraction: (0..tets.len()).map(|_| random.uniform(0.3, 1.0)).collect(),
        mesh: TetMesh {
            nodes: (0..8).map(corner).collect(),
            tets,
        },
        bone_of_node: (0..8).map(|n| fixed(n).then_some(0)).collect(),
        skinning: (0..8).map(|_| skin_weights(random, bones)).collect(),
        basis,
        skin_embedding: (0..vertices)
            .map(|_| [(random.index(8) as u32, 1.0)])
            .collect(),
        tissue: local_tissue(random.index(1 << 20) as u64, 6),
    }
}

/// Three of so many vertices for each point, in no order.
fn pose_extension(seed: u64, points: usize, vertices: usize) -> Rows<(u32, f32)> {
    // Numbers of its own: those of all else stay what they are without it.
    let random = &mut Random::new(seed ^ 0x0ff5e7);
    let share = |random: &mut Random| {
        (
            random.index(vertices) as u32,
            random.uniform(-0.1, 0.4) as f32,
        )
    };
    (0..points).map(|_| [0; 3].map(|_| share(random))).collect()
}

/// What the material has of its own at so many places.
fn local_tissue(seed: u64, count: usize) -> Vec<LocalTissue> {
    let random = &mut Random::new(seed);
    // Numbers of their own: those of all else stay what they are without them.
    let (beta, muscle) = (
        &mut Random::new(seed ^ 0xbe7a),
        &mut Random::new(seed ^ 0x3c1e),
    );
    (0..count)
        .map(|_| LocalTissue {
            stiffness: random.uniform(0.5, 2.0),
            axes: DQuat::from_mat3(&random.rotation(2.0)).normalize(),
            damping_time: beta.uniform(0.005, 0.015),
            muscle: muscle.uniform(0.0, 1.0),
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::Surface;

    #[test]
    fn random_avatars_are_valid_and_repeatable() {
        for (bones, handles) in [(1, 1), (3, 4), (16, 87)] {
            let avatar = random_avatar(5, bones, handles, 20, 100);
            avatar.validate().unwrap();
            assert_eq!(avatar, random_avatar(5, bones, handles, 20, 100));
            assert_ne!(
                avatar.handles,
                random_avatar(6, bones, handles, 20, 100).handles
            );
            let skin = Surface {
                positions: avatar.skin.position.clone(),
                triangles: avatar.triangles.clone(),
            };
            assert!(skin.is_closed() && skin.volume() > 0.0);
            let mesh = &avatar.layer.mesh;
            assert!((0..mesh.tets.len()).all(|t| mesh.volume(t) > 0.0));
        }
    }
}
