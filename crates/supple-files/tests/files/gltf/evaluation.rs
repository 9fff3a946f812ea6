//! glTF's skinning, Σ w · world_j · inverseBind_j · v, by the `gltf` crate: shares no code with the loader.

use glam::{DAffine3, DMat4, DQuat, DVec3};
use gltf::animation::util::ReadOutputs;
use supple::model::Frame;
use supple_bake::Body;
use supple_files::{MotionClip, MotionFrame};

/// A file's document and buffers.
pub struct Evaluation {
    pub document: gltf::Document,
    buffers: Vec<Vec<u8>>,
}

impl Evaluation {
    /// Of a GLB.
    pub fn new(bytes: &[u8]) -> Self {
        let gltf::Gltf { document, blob } =
            gltf::Gltf::from_slice_without_validation(bytes).unwrap();
        let buffers = vec![blob.unwrap()];
        Self { document, buffers }
    }

    /// World matrix of every node, `local` giving that relative to its parent.
    pub fn world(&self, local: &dyn Fn(&gltf::Node<'_>) -> DMat4) -> Vec<DMat4> {
        let mut world = vec![DMat4::IDENTITY; self.document.nodes().count()];
        let scene = self.document.default_scene();
        let scene = scene.or_else(|| self.document.scenes().next()).unwrap();
        let mut stack: Vec<_> = scene.nodes().map(|n| (n, DMat4::IDENTITY)).collect();
        while let Some((node, above)) = stack.pop() {
            world[node.index()] = above * local(&node);
            stack.extend(node.children().map(|c| (c, world[node.index()])));
        }
        world
    }

    /// The matrices of the file's own rest pose.
    pub fn rest(&self) -> Vec<DMat4> {
        self.world(&local_rest)
    }

    /// Skinned places of the vertices of each primitive that a node shows, in node order.
    pub fn skinned(&self, world: &[DMat4]) -> Vec<Vec<DVec3>> {
        let mut out = Vec::new();
        for node in self.document.nodes() {
            let Some(mesh) = node.mesh() else { continue };
            for primitive in mesh.primitives() {
                let reader = primitive.reader(|b| self.buffers.get(b.index()).map(|b| &b[..]));
                let positions = reader.read_positions().unwrap().map(double);
                let Some(skin) = node.skin() else {
                    let place = |p| world[node.index()].transform_point3(p);
                    out.push(positions.map(place).collect());
                    continue;
                };
                let bind = self.bind_matrices(&skin);
                let joints: Vec<usize> = skin.joints().map(|j| j.index()).collect();
                type Set = (Vec<[u16; 4]>, Vec<[f32; 4]>);
                let sets: Vec<Set> = (0..)
                    .map_while(|set| {
                        let joints = reader.read_joints(set)?.into_u16().collect();
                        Some((joints, reader.read_weights(set)?.into_f32().collect()))
                    })
                    .collect();
                let skin = |(v, p): (usize, DVec3)| {
                    let (mut sum, mut total) = (DVec3::ZERO, 0.0);
                    for (bones, weights) in &sets {
                        for (b, w) in bones[v].iter().zip(weights[v]) {
                            let b = *b as usize;
                            if w > 0.0 {
                                let place = (world[joints[b]] * bind[b]).transform_point3(p);
                                sum += f64::from(w) * place;
                                total += f64::from(w);
                            }
                        }
                    }
                    sum / total
                };
                out.push(positions.enumerate().map(skin).collect());
            }
        }
        out
    }

    /// The vertices of each primitive that a node shows, as they stand in the file.
    pub fn unskinned(&self) -> Vec<Vec<DVec3>> {
        let meshes = self.document.nodes().filter_map(|n| n.mesh());
        let primitives = meshes.flat_map(|m| m.primitives());
        let positions = |p: gltf::Primitive<'_>| {
            let reader = p.reader(|b| self.buffers.get(b.index()).map(|b| &b[..]));
            reader.read_positions().unwrap().map(double).collect()
        };
        primitives.map(positions).collect()
    }

    /// The inverse bind matrices of a skin.
    pub fn bind_matrices(&self, skin: &gltf::Skin<'_>) -> Vec<DMat4> {
        let reader = skin.reader(|b| self.buffers.get(b.index()).map(|b| &b[..]));
        match reader.read_inverse_bind_matrices() {
            Some(all) => {
                let double = |m| glam::Mat4::from_cols_array_2d(&m).as_dmat4();
                all.map(double).collect()
            }
            None => vec![DMat4::IDENTITY; skin.joints().count()],
        }
    }

    /// The first key of animation `k`, s.
    pub fn first_key(&self, k: usize) -> f64 {
        let animation = self.document.animations().nth(k).unwrap();
        let times = animation.channels().flat_map(|c| {
            let reader = c.reader(|b| self.buffers.get(b.index()).map(|b| &b[..]));
            reader.read_inputs().unwrap().collect::<Vec<_>>()
        });
        f64::from(times.fold(f32::INFINITY, f32::min))
    }

    /// World matrices of animation `k` at `time`: steps, lines and arcs only.
    pub fn animated(&self, k: usize, time: f64) -> Vec<DMat4> {
        let animation = self.document.animations().nth(k).unwrap();
        self.world(&|node| {
            let (t, r, s) = node.transform().decomposed();
            let mut translation = double(t);
            let mut rotation = DQuat::from_array(r.map(f64::from));
            let mut scale = double(s);
            for channel in animation
                .channels()
                .filter(|c| c.target().node().index() == node.index())
            {
                let reader = channel.reader(|b| self.buffers.get(b.index()).map(|b| &b[..]));
                let keys: Vec<f64> = reader.read_inputs().unwrap().map(f64::from).collect();
                let after = keys.iter().filter(|key| **key <= time).count();
                let a = after.saturating_sub(1);
                let b = after.min(keys.len() - 1);
                let length = keys[b] - keys[a];
                let mut u = if length > 0.0 {
                    (time - keys[a]) / length
                } else {
                    0.0
                };
                if channel.sampler().interpolation() == gltf::animation::Interpolation::Step {
                    u = 0.0;
                }
                match reader.read_outputs().unwrap() {
                    ReadOutputs::Translations(all) => {
                        let all: Vec<_> = all.map(double).collect();
                        translation = all[a].lerp(all[b], u);
                    }
                    ReadOutputs::Scales(all) => {
                        let all: Vec<_> = all.map(double).collect();
                        scale = all[a].lerp(all[b], u);
                    }
                    ReadOutputs::Rotations(all) => {
                        let all: Vec<_> = all
                            .into_f32()
                            .map(|q| DQuat::from_array(q.map(f64::from)).normalize())
                            .collect();
                        // The shorter arc from a to b as a turn about an axis.
                        let end = if all[a].dot(all[b]) < 0.0 {
                            -all[b]
                        } else {
                            all[b]
                        };
                        let turn = (end * all[a].inverse()).to_scaled_axis();
                        rotation = DQuat::from_scaled_axis(u * turn) * all[a];
                    }
                    ReadOutputs::MorphTargetWeights(_) => {}
                }
            }
            DMat4::from_scale_rotation_translation(scale, rotation.normalize(), translation)
        })
    }
}

/// A node's own matrix at rest.
pub fn local_rest(node: &gltf::Node<'_>) -> DMat4 {
    glam::Mat4::from_cols_array_2d(&node.transform().matrix()).as_dmat4()
}

fn double(v: [f32; 3]) -> DVec3 {
    DVec3::from_array(v.map(f64::from))
}

/// This crate's skinning of a body's vertices: skin first, then attachments.
pub fn posed(body: &Body, frames: &[Frame]) -> Vec<DVec3> {
    let surfaces = std::iter::once((&body.skin, &body.skinning))
        .chain(body.attachments.iter().map(|a| (&a.surface, &a.skinning)));
    let mut out = Vec::new();
    for (surface, skinning) in surfaces {
        for (x, row) in surface.positions.iter().zip(skinning.iter()) {
            let place = |w: &supple::model::SkinWeight| {
                let j = w.bone as usize;
                w.weight * frames[j].transform(*x - body.skeleton.joints[j])
            };
            out.push(row.iter().map(place).sum());
        }
    }
    out
}

/// Frames of a body's bones in a frame of a clip that moves others too.
pub fn frames_of(body: &Body, clip: &MotionClip, frame: &MotionFrame) -> Vec<Frame> {
    let frames = clip.world_frames(frame);
    let bone = |name: &String| frames[clip.find(name).unwrap()];
    body.skeleton.names.iter().map(bone).collect()
}

/// Demands that each bone of each clip stands where its node does in the file, turned as that is away from its rest, to the
/// rounding of f32. Of files whose rest pose is their bind pose, and whose nodes have names of their own.
pub fn check_clips(bytes: &[u8]) -> Vec<MotionClip> {
    let file = Evaluation::new(bytes);
    let rest = file.rest();
    let clips = supple_files::parse_gltf_motions(bytes, "fixture.glb").unwrap();
    for (k, clip) in clips.iter().enumerate() {
        let start = file.first_key(k);
        for (f, frame) in clip.frames.iter().enumerate() {
            let world = file.animated(k, start + clip.frame_time * f as f64);
            for (name, found) in clip.bones.iter().zip(clip.world_frames(frame)) {
                let mut nodes = file.document.nodes();
                let node = nodes.find(|n| n.name() == Some(name)).unwrap().index();
                let now = DAffine3::from_mat4(world[node]);
                let turn = now.matrix3 * DAffine3::from_mat4(rest[node]).matrix3.inverse();
                let distance = found.position.distance(now.translation);
                assert!(distance < 1e-6, "{name}, frame {f}: {distance:e} m");
                assert!(found.rotation.abs_diff_eq(turn, 1e-6), "{name}, frame {f}");
            }
        }
    }
    clips
}

/// The largest distance between what the file's vertices are by `expected` and by `found`.
pub fn largest_distance(body: &Body, found: &[DVec3], expected: &[Vec<DVec3>]) -> f64 {
    assert_eq!(body.render_meshes.len(), expected.len());
    let mut largest: f64 = 0.0;
    for (part, expected) in body.render_meshes.iter().zip(expected) {
        assert_eq!(part.vertices.len(), expected.len());
        for (v, x) in part.vertices.iter().zip(expected) {
            largest = largest.max(found[*v as usize].distance(*x));
        }
    }
    largest
}

/// The body of a GLB, after its rest pose was found to be the file's own, to the rounding of the file's
/// numbers: 1e-6 of its size and 1e-7 of its distance from the origin.
pub fn check_rest(bytes: &[u8]) -> Body {
    let character = supple_files::parse_gltf(bytes, "fixture.glb").unwrap();
    let body = character.body(&[]).unwrap();
    let file = Evaluation::new(bytes);
    let expected = file.skinned(&file.rest());
    let found = posed(&body, &character.rest);
    let largest = |lengths: &mut dyn Iterator<Item = f64>| lengths.fold(0.0, f64::max);
    let size = largest(&mut found.iter().map(|p| p.distance(found[0])));
    let reach = largest(&mut found.iter().map(|p| p.length()));
    let distance = largest_distance(&body, &found, &expected);
    let tolerance = 1e-6 * size + 1e-7 * reach;
    assert!(
        size > 0.0 && distance < tolerance,
        "{distance:e} m, {tolerance:e} allowed"
    );
    body
}
