//! glTF's skinning, Σ w · world_j · inverseBind_j · v, by the `gltf` crate: shares no code with the loader.

use glam::{DMat4, DVec3};
use supple::model::{Body, Frame};

/// A file's document and buffers.
pub struct Evaluation {
    pub document: gltf::Document,
    buffers: Vec<Vec<u8>>,
}

impl Evaluation {
    /// Of a GLB.
    pub fn new(bytes: &[u8]) -> Self {
        let gltf::Gltf { document, blob } = gltf::Gltf::from_slice(bytes).unwrap();
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
                let bind = skin.reader(|b| self.buffers.get(b.index()).map(|b| &b[..]));
                let bind: Vec<DMat4> = match bind.read_inverse_bind_matrices() {
                    Some(all) => all
                        .map(|m| glam::Mat4::from_cols_array_2d(&m).as_dmat4())
                        .collect(),
                    None => vec![DMat4::IDENTITY; skin.joints().count()],
                };
                let joints: Vec<usize> = skin.joints().map(|j| j.index()).collect();
                let sets: Vec<(Vec<[u16; 4]>, Vec<[f32; 4]>)> = (0..)
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

/// The largest distance between what the file's vertices are by `expected` and by `found`.
pub fn largest_distance(body: &Body, found: &[DVec3], expected: &[Vec<DVec3>]) -> f64 {
    assert_eq!(body.drawn.len(), expected.len());
    let mut largest: f64 = 0.0;
    for (part, expected) in body.drawn.iter().zip(expected) {
        assert_eq!(part.vertices.len(), expected.len());
        for (v, x) in part.vertices.iter().zip(expected) {
            largest = largest.max(found[*v as usize].distance(*x));
        }
    }
    largest
}
