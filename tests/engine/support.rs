//! Avatars for tests of the whole step: the limb with any number of bones in a row along it, in its
//! full space: a handle at every free node, a point in every tet.
#![allow(dead_code, reason = "every test file uses its own part")]

use supple::glam::{DMat3, DVec3};
use supple::internal::math::Rows;
use supple::material::{Material, StableNeoHookean};
use supple::model::{
    Avatar, BasisEntry, BoneMass, JointList, PointSet, PoseBlend, Skeleton, SkinWeight, SoftLayer,
    SpringBones, SpringChain, SpringJoint, State, UpAxis,
};
use supple_samples::Limb;

/// A few hundred DoFs.
pub const SMALL: Limb = Limb {
    length: 0.25,
    inner_radius: 0.015,
    outer_radius: 0.04,
    stations: 6,
    layers: 2,
    sectors: 6,
};

/// `limb` around `bones` bones of density 1900 kg/m³ in a row, each weight going over to the next
/// within a quarter of a bone. Gravity acts on φ as well unless `captured_under_gravity`.
pub fn full_space_limb(limb: &Limb, bones: usize, captured_under_gravity: bool) -> Avatar {
    let (mesh, pinned, surface) = limb.mesh().unwrap();
    let bone_length = limb.length / bones as f64;
    let bone_at = |x: f64| ((x / bone_length) as usize).min(bones - 1);
    let weights = |x: DVec3| weights_along(x.x / bone_length, bones);

    let mut bone_of_node = vec![None; mesh.nodes.len()];
    for &n in &pinned {
        bone_of_node[n as usize] = Some(bone_at(mesh.nodes[n as usize].x) as u32);
    }
    let mut handle_of_node = vec![None; mesh.nodes.len()];
    let mut handles = Vec::new();
    for (n, bone) in bone_of_node.iter().enumerate() {
        if bone.is_none() {
            handle_of_node[n] = Some(handles.len() as u32);
            handles.push(mesh.nodes[n]);
        }
    }
    let tets = 0..mesh.tets.len();
    let centroids: Vec<DVec3> = tets
        .clone()
        .map(|t| mesh.corners(t).iter().sum::<DVec3>() / 4.0)
        .collect();
    let cubature = PointSet {
        measure: tets.clone().map(|t| mesh.volume(t)).collect(),
        skinning: centroids.iter().map(|&x| weights(x)).collect(),
        basis: tets
            .map(|t| {
                let gradients = barycentric_gradients(mesh.corners(t));
                let entry = |k: usize| {
                    Some(BasisEntry {
                        handle: handle_of_node[mesh.tets[t][k] as usize]?,
                        value: 0.25,
                        gradient: gradients[k],
                    })
                };
                let mut entries: Vec<_> = (0..4).filter_map(entry).collect();
                entries.sort_by_key(|e| e.handle);
                entries
            })
            .collect(),
        position: centroids,
        pose_blend: PoseBlend::default(),
    };
    let mut vertex_of_node = vec![0; mesh.nodes.len()];
    for (v, &n) in surface.iter().enumerate() {
        vertex_of_node[n as usize] = v as u32;
    }
    let body = limb.body().unwrap();
    let triangles = body.skin.triangles;
    let positions: Vec<DVec3> = surface.iter().map(|&n| mesh.nodes[n as usize]).collect();
    let mut area = vec![0.0; surface.len()];
    for t in &triangles {
        let [a, b, c] = t.map(|v| positions[v as usize]);
        let third = (b - a).cross(c - a).length() / 6.0;
        t.iter().for_each(|&v| area[v as usize] += third);
    }
    let skin = PointSet {
        measure: area,
        skinning: positions.iter().map(|&x| weights(x)).collect(),
        basis: surface
            .iter()
            .map(|&n| {
                [BasisEntry {
                    handle: handle_of_node[n as usize].unwrap(),
                    value: 1.0,
                    gradient: DVec3::ZERO,
                }]
            })
            .collect(),
        position: positions,
        pose_blend: PoseBlend::default(),
    };
    let joint = |j: usize| DVec3::X * (bone_length * j as f64);
    let skeleton = Skeleton {
        aliases: Vec::new(),
        limits: Vec::new(),
        names: (0..bones).map(|j| format!("bone {j}")).collect(),
        parents: (0..bones)
            .map(|j| j.checked_sub(1).map(|p| p as u32))
            .collect(),
        joints: (0..bones).map(joint).collect(),
    };
    let avatar = Avatar {
        name: "limb".into(),
        joints: JointList::of_bones(&skeleton),
        up: UpAxis::Z,
        skeleton,
        bone_masses: vec![rod(bone_length, limb.inner_radius, 1900.0); bones],
        springs: SpringBones::default(),
        handles,
        cubature,
        skin,
        triangles,
        contact_stiffness: Vec::new(),
        attached: Rows::default(),
        pose_extension: Rows::default(),
        render_meshes: Vec::new(),
        appearance: Default::default(),
        material: Material::StableNeoHookean(StableNeoHookean {
            youngs_modulus: 30e3,
            poissons_ratio: 0.4,
        }),
        density: 1000.0,
        captured_under_gravity,
        fine: Default::default(),
        bodies: Vec::new(),
        body_slots: 0,
        layer: SoftLayer {
            tissue_fraction: vec![1.0; mesh.tets.len()],
            skinning: mesh.nodes.iter().map(|&x| weights(x)).collect(),
            basis: handle_of_node
                .iter()
                .map(|h| h.map(|h| (h, 1.0)))
                .collect::<Rows<_>>(),
            skin_embedding: surface.iter().map(|&n| [(n, 1.0)]).collect(),
            bone_of_node,
            mesh,
            tissue: Vec::new(),
        },
        tissue: Vec::new(),
    };
    avatar.validate().unwrap();
    avatar
}

/// Distance between the joints of a [`with_tail`], m.
pub const TAIL_STEP: f64 = 0.05;

/// `avatar` with a tail on its first bone, away from its other end: `count` spring bones like `like` in a chain along x, each
/// with an attached triangle. Bone and tail of `like` are not read.
pub fn with_tail(avatar: &Avatar, count: usize, like: SpringJoint) -> Avatar {
    let mut out = avatar.clone();
    let first = avatar.skeleton.len();
    let root = avatar.skeleton.joints[0] - DVec3::X * 0.3;
    let chain = out.springs.chains.len() as u32;
    out.springs.chains.push(SpringChain {
        name: format!("tail {chain}"),
        ..SpringChain::default()
    });
    for k in 0..count {
        let (bone, joint) = ((first + k) as u32, root - DVec3::X * (TAIL_STEP * k as f64));
        out.skeleton.names.push(format!("tail {chain} {k}"));
        out.skeleton
            .parents
            .push(Some(if k > 0 { bone - 1 } else { 0 }));
        out.skeleton.joints.push(joint);
        out.bone_masses.push(BoneMass::NONE);
        out.springs.joints.push(SpringJoint {
            chain,
            bone,
            tail: -DVec3::X * TAIL_STEP,
            ..like
        });
        let v = out.skin.position.len() as u32;
        out.triangles.push([v, v + 1, v + 2]);
        for corner in [DVec3::ZERO, DVec3::Y * 0.01, -DVec3::X * TAIL_STEP] {
            out.skin.position.push(joint + corner);
            out.skin.measure.push(0.0);
            out.skin.skinning.push([SkinWeight { bone, weight: 1.0 }]);
            out.skin.basis.push(None);
            out.attached.push(None);
        }
    }
    out.joints = JointList::of_bones(&out.skeleton);
    out.validate().unwrap();
    out
}

/// A spring joint that nothing draws or brakes.
pub const LIMP: SpringJoint = SpringJoint {
    chain: 0,
    bone: 0,
    tail: DVec3::ZERO,
    rest_rotation: DMat3::IDENTITY,
    stiffness: 0.0,
    drag_force: 0.0,
    gravity: DVec3::ZERO,
    hit_radius: 0.0,
};

/// Weights at `s` bone lengths along the row.
fn weights_along(s: f64, bones: usize) -> Vec<SkinWeight> {
    let bone = (s as usize).min(bones - 1);
    let along = s - bone as f64;
    let share = |distance: f64| (0.5 - 2.0 * distance).max(0.0);
    let back = if bone > 0 { share(along) } else { 0.0 };
    let forth = if bone + 1 < bones {
        share(1.0 - along)
    } else {
        0.0
    };
    let mut out = Vec::new();
    for (bone, weight) in [
        (bone.wrapping_sub(1), back),
        (bone, 1.0 - back - forth),
        (bone + 1, forth),
    ] {
        if weight > 0.0 {
            out.push(SkinWeight {
                bone: bone as u32,
                weight,
            });
        }
    }
    out
}

/// A solid rod along x from its joint.
fn rod(length: f64, radius: f64, density: f64) -> BoneMass {
    let mass = density * std::f64::consts::PI * radius * radius * length;
    let mut s = [[0.0; 4]; 4];
    s[0][0] = mass * length * length / 3.0;
    (s[1][1], s[2][2]) = (mass * radius * radius / 4.0, mass * radius * radius / 4.0);
    (s[0][3], s[3][0]) = (mass * length / 2.0, mass * length / 2.0);
    s[3][3] = mass;
    BoneMass { second_moment: s }
}

fn barycentric_gradients([a, b, c, d]: [DVec3; 4]) -> [DVec3; 4] {
    let rows = DMat3::from_cols(b - a, c - a, d - a).inverse().transpose();
    let (x, y, z) = (rows.x_axis, rows.y_axis, rows.z_axis);
    [-(x + y + z), x, y, z]
}

/// World positions of `points` in `state`.
pub fn posed(avatar: &Avatar, points: &PointSet, state: &State) -> Vec<DVec3> {
    (0..points.len())
        .map(|i| {
            let displaced = points.position[i]
                + points
                    .basis
                    .row(i)
                    .iter()
                    .map(|u| u.value * state.handles[u.handle as usize])
                    .sum::<DVec3>();
            let skin = |w: &SkinWeight| {
                let j = w.bone as usize;
                w.weight * state.frames[j].transform(displaced - avatar.skeleton.joints[j])
            };
            points.skinning.row(i).iter().map(skin).sum()
        })
        .collect()
}

/// Largest distance between two lists of places.
pub fn largest_distance(a: &[DVec3], b: &[DVec3]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter()
        .zip(b)
        .map(|(a, b)| (*a - *b).length())
        .fold(0.0, f64::max)
}
