//! A GLB file played back by a reader of its own gives the skin that was simulated.

use supple::collider::Shape;
use supple::glam;
use supple::glam::{DMat4, DQuat, DVec3, Vec3};
use supple::internal::features::pose_feature;
use supple::internal::math::Rows;
use supple::internal::{random_avatar, random_state};
use supple::model::{Avatar, Frame, SkinWeight, State, UpAxis};
use supple_files::{
    GlbOptions, GlbReport, MORPH_TOLERANCE, MOST_MORPHS, Prop, Recording, solid_surface, write_glb,
    write_glb_with,
};

/// States that blend smoothly between a few random ones, as a motion does.
fn recording(avatar: &Avatar, states: usize) -> Recording {
    let ends = [1, 2, 3].map(|seed| random_state(seed, avatar, 0.4, 0.004));
    let state = |s: usize| {
        let u = 2.0 * s as f64 / (states - 1) as f64;
        let (from, to) = (&ends[u as usize], &ends[(u as usize + 1).min(2)]);
        from.moved(&from.step_to(to), u.fract())
    };
    Recording {
        up: UpAxis::Z,
        times: (0..states).map(|s| 0.01 * s as f64).collect(),
        states: (0..states).map(state).collect(),
        props: vec![Prop {
            name: "ball".into(),
            surface: solid_surface(&Shape::Sphere { radius: 0.01 }, 1.0),
            colour: [0.3, 0.4, 0.5],
            frames: (0..states)
                .map(|s| Frame {
                    position: DVec3::Z * s as f64,
                    ..Frame::IDENTITY
                })
                .collect(),
        }],
    }
}

/// x = Σ w (R (X + B_P(θ) + Σ U φ − J) + c), in f64.
fn skin(avatar: &Avatar, state: &State) -> Vec<DVec3> {
    let set = &avatar.skin;
    let feature = pose_feature(&avatar.skeleton.parents, &state.frames);
    (0..set.len())
        .map(|v| {
            let mut t = set.position[v];
            for k in 0..set.pose_blend.features {
                let column = set.pose_blend.columns[k * set.len() + v].map(f64::from);
                t += feature[k] * DVec3::from_array(column);
            }
            for u in set.basis.row(v) {
                t += u.value * state.handles[u.handle as usize];
            }
            let row = set.skinning.row(v).iter();
            row.map(|w| {
                let j = w.bone as usize;
                w.weight * state.frames[j].transform(t - avatar.skeleton.joints[j])
            })
            .sum()
        })
        .collect()
}

/// What a viewer shows at key `key`: positions and normals in scene space (z up), and the ball's place.
struct Player {
    gltf: gltf::Gltf,
    blob: Vec<u8>,
}

impl Player {
    fn open(path: &std::path::Path) -> Self {
        let mut gltf = gltf::Gltf::from_slice(&std::fs::read(path).unwrap()).unwrap();
        let blob = gltf.blob.take().unwrap();
        Self { gltf, blob }
    }

    fn data<'a>(&'a self) -> impl Clone + Fn(gltf::Buffer<'_>) -> Option<&'a [u8]> {
        let blob = self.blob.as_slice();
        move |_| Some(blob)
    }

    /// World matrices of all nodes and the morph weights at a key.
    fn pose(&self, key: usize) -> (Vec<DMat4>, Vec<f32>) {
        use gltf::animation::util::ReadOutputs;
        let nodes = self.gltf.nodes().len();
        let mut local: Vec<_> = self
            .gltf
            .nodes()
            .map(|n| n.transform().decomposed())
            .collect();
        let mut weights = Vec::new();
        for channel in self.gltf.animations().next().unwrap().channels() {
            let node = channel.target().node().index();
            let reader = channel.reader(self.data());
            let keys = reader.read_inputs().unwrap().count();
            match reader.read_outputs().unwrap() {
                ReadOutputs::Translations(mut t) => local[node].0 = t.nth(key).unwrap(),
                ReadOutputs::Rotations(r) => local[node].1 = r.into_f32().nth(key).unwrap(),
                ReadOutputs::MorphTargetWeights(w) => {
                    let all: Vec<f32> = w.into_f32().collect();
                    let count = all.len() / keys;
                    weights = all[key * count..(key + 1) * count].to_vec();
                }
                ReadOutputs::Scales(_) => panic!("nothing is scaled"),
            }
        }
        let matrix = |node: usize| {
            let (t, r, _) = local[node];
            let rotation = DQuat::from_array(r.map(f64::from)).normalize();
            DMat4::from_rotation_translation(rotation, DVec3::from_array(t.map(f64::from)))
        };
        let mut world = vec![DMat4::IDENTITY; nodes];
        let scene = self.gltf.scenes().next().unwrap();
        let mut stack: Vec<_> = scene.nodes().map(|n| (n, DMat4::IDENTITY)).collect();
        while let Some((node, parent)) = stack.pop() {
            world[node.index()] = parent * matrix(node.index());
            stack.extend(node.children().map(|c| (c, world[node.index()])));
        }
        (world, weights)
    }

    fn play(&self, key: usize) -> (Vec<DVec3>, Vec<DVec3>, DVec3) {
        let (world, morph_weights) = self.pose(key);
        let up = DQuat::from_rotation_x(std::f64::consts::FRAC_PI_2);
        let body = self.gltf.nodes().find(|n| n.skin().is_some()).unwrap();
        let ball = self
            .gltf
            .nodes()
            .find(|n| n.name() == Some("ball"))
            .unwrap();
        let skin = body.skin().unwrap();
        let bind: Vec<_> = skin
            .reader(self.data())
            .read_inverse_bind_matrices()
            .unwrap()
            .collect();
        let joints: Vec<DMat4> = skin
            .joints()
            .zip(bind)
            .map(|(j, b)| world[j.index()] * glam::Mat4::from_cols_array_2d(&b).as_dmat4())
            .collect();
        let primitive = body.mesh().unwrap().primitives().next().unwrap();
        let reader = primitive.reader(self.data());
        let vectors = |v: [f32; 3]| Vec3::from_array(v).as_dvec3();
        let mut positions: Vec<_> = reader.read_positions().unwrap().map(vectors).collect();
        let mut normals: Vec<_> = reader.read_normals().unwrap().map(vectors).collect();
        let targets = reader.read_morph_targets().zip(&morph_weights);
        for ((position, normal, _), weight) in targets {
            let weight = f64::from(*weight);
            let add = |to: &mut Vec<DVec3>, from: Vec<[f32; 3]>| {
                to.iter_mut()
                    .zip(from)
                    .for_each(|(a, d)| *a += weight * vectors(d));
            };
            add(&mut positions, position.unwrap().collect());
            add(&mut normals, normal.unwrap().collect());
        }
        let mut skinned = vec![(DVec3::ZERO, DVec3::ZERO); positions.len()];
        let mut set = 0;
        while let (Some(j), Some(w)) = (reader.read_joints(set), reader.read_weights(set)) {
            for (v, (bones, weights)) in j.into_u16().zip(w.into_f32()).enumerate() {
                for (bone, weight) in bones.into_iter().zip(weights) {
                    let (m, w) = (joints[bone as usize], f64::from(weight));
                    skinned[v].0 += w * m.transform_point3(positions[v]);
                    skinned[v].1 += w * m.transform_vector3(normals[v]);
                }
            }
            set += 1;
        }
        let place = up * world[ball.index()].transform_point3(DVec3::ZERO);
        let turned = skinned
            .into_iter()
            .map(|(p, n)| (up * p, (up * n).normalize()));
        let (positions, normals) = turned.unzip();
        (positions, normals, place)
    }
}

/// Writes, plays back, and demands the simulated skin to `tolerance` at every key.
fn check(avatar: &Avatar, states: usize, tolerance: f64) -> GlbReport {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("avatar.glb");
    let recording = recording(avatar, states);
    let report = write_glb(avatar, &recording, &path).unwrap();
    let bytes = std::fs::read(&path).unwrap();
    assert_eq!(bytes.len(), report.bytes);
    write_glb(avatar, &recording, &path).unwrap();
    assert_eq!(
        std::fs::read(&path).unwrap(),
        bytes,
        "same input, same bytes"
    );
    let player = Player::open(&path);
    for key in 0..states {
        let (positions, normals, ball) = player.play(key);
        let expected = skin(avatar, &recording.states[key]);
        for (v, (p, e)) in positions.iter().zip(&expected).enumerate() {
            assert!(
                (*p - *e).length() < tolerance,
                "key {key} vertex {v}: {p} {e}"
            );
        }
        assert!(normals.iter().all(|n| n.is_normalized()));
        assert!((ball - recording.props[0].frames[key].position).length() < 1e-6);
    }
    report
}

/// f32 of a 0.1 m body and 16 bones in a chain: a few times 1e-8 m.
const ROUNDING: f64 = 1e-6;

#[test]
fn handles_become_morphs_where_they_fit() {
    let mut avatar = random_avatar(7, 5, 20, 20, 300);
    avatar.skin.pose_blend = Default::default();
    let report = check(&avatar, 9, ROUNDING);
    assert!(report.per_handle);
    assert_eq!(report.morphs, 60);
    assert_eq!(report.largest_morph_error, 0.0);
}

/// Ninety displacements that have nothing in common need as many morphs; of fewer it is said what they miss.
#[test]
fn morphs_are_as_many_as_is_asked() {
    let mut avatar = random_avatar(7, 2, 40, 20, 300);
    avatar.skin.pose_blend = Default::default();
    let states: Vec<State> = (0..90)
        .map(|k| random_state(k, &avatar, 0.1, 0.004))
        .collect();
    let recording = Recording {
        times: (0..states.len()).map(|k| k as f64).collect(),
        states,
        ..Recording::default()
    };
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("avatar.glb");
    let few = write_glb(&avatar, &recording, &path).unwrap();
    assert_eq!((few.morphs, MOST_MORPHS), (64, 64));
    assert!(few.largest_morph_error > MORPH_TOLERANCE && !few.per_handle);
    let all = GlbOptions { most_morphs: 120 };
    let all = write_glb_with(&avatar, &recording, all, &path).unwrap();
    assert!(all.per_handle && all.morphs == 120 && all.largest_morph_error == 0.0);
    let none = GlbOptions { most_morphs: 0 };
    let none = write_glb_with(&avatar, &recording, none, &path).unwrap();
    assert!(none.morphs == 0 && none.largest_morph_error > few.largest_morph_error);
}

#[test]
fn more_handles_and_blend_shapes_become_a_low_rank_basis() {
    let avatar = random_avatar(8, 6, 100, 20, 400);
    let report = check(&avatar, 41, MORPH_TOLERANCE + ROUNDING);
    assert!(!report.per_handle);
    assert!(report.morphs <= 41 && report.morphs >= 2, "{report:?}");
    assert!(report.largest_morph_error > 0.0, "{report:?}");
    assert!(report.largest_morph_error <= MORPH_TOLERANCE, "{report:?}");
}

#[test]
fn any_number_of_influences_is_kept() {
    let mut avatar = random_avatar(9, 7, 3, 10, 100);
    let weight = |bone: u32| SkinWeight {
        bone,
        weight: f64::from(bone + 1) / 28.0,
    };
    avatar.skin.skinning = Rows::from_iter((0..avatar.skin.len()).map(|_| (0..7).map(weight)));
    let report = check(&avatar, 3, MORPH_TOLERANCE + ROUNDING);
    assert_eq!(report.influences, 7);
}

#[test]
fn normals_follow_the_morphs() {
    let mut avatar = random_avatar(10, 1, 12, 10, 2000);
    avatar.skin.pose_blend = Default::default();
    // A handle's shape varies smoothly, as a basis does.
    let centres = avatar.handles.clone();
    avatar.skin.basis = Rows::from_iter(avatar.skin.position.iter().map(|p| {
        let shape = |h: usize| (-(*p - centres[h]).length_squared() / 0.05f64.powi(2)).exp();
        let entry = move |h: usize| supple::model::BasisEntry {
            handle: h as u32,
            value: shape(h),
            gradient: DVec3::ZERO,
        };
        (0..centres.len()).map(entry).collect::<Vec<_>>()
    }));
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("avatar.glb");
    let recording = recording(&avatar, 5);
    write_glb(&avatar, &recording, &path).unwrap();
    let player = Player::open(&path);
    let (mut worst, mut turned): (f64, f64) = (0.0, 0.0);
    for key in 0..5 {
        let (_, normals, _) = player.play(key);
        let surface = supple::model::Surface {
            positions: skin(&avatar, &recording.states[key]),
            triangles: avatar.triangles.clone(),
        };
        let rest = supple::model::Surface {
            positions: avatar.skin.position.clone(),
            triangles: avatar.triangles.clone(),
        };
        let rotation = recording.states[key].frames[0].rotation;
        let unmorphed = rest.vertex_normals().into_iter().map(|n| rotation * n);
        for ((n, e), u) in normals.iter().zip(surface.vertex_normals()).zip(unmorphed) {
            worst = worst.max(n.angle_between(e));
            turned = turned.max(u.angle_between(e));
        }
    }
    // The morphs of normals are their linearisation: a quarter of the turn may be missed at most.
    assert!(
        worst < 0.25 * turned,
        "{} of {} degrees",
        worst.to_degrees(),
        turned.to_degrees()
    );
}

#[test]
fn a_recording_of_something_else_is_refused() {
    let avatar = random_avatar(11, 3, 4, 5, 50);
    let mut wrong = recording(&avatar, 3);
    wrong.states[1].handles.pop();
    let error = write_glb(&avatar, &wrong, "never.glb").unwrap_err();
    assert!(error.to_string().contains("recording.states"), "{error}");
}
