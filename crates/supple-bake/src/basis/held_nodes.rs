//! What holds the nodes of a layer: its bones and its skin.

use std::collections::BTreeMap;
use supple::internal::math::Rows;
use supple::model::TetMesh;

/// Where a skin vertex is held in a mesh that does not meet the skin: the energy
/// ½ ∫ |∇u|² + ½ ∫_skin (u − u_skin)²/ℓ with ℓ this share of the mean edge.
const SOFT_LENGTH: f64 = 0.01;

/// What holds a node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Role {
    /// Nothing; its column.
    Free(u32),
    /// The skin vertices that it is.
    Skin,
    /// A bone.
    Bone(u32),
}

/// What holds each node. Nodes that are skin vertices and nodes on bones are held exactly; skin vertices embedded
/// in a tet hold it softly, each with its area. Where a node is both, the bone holds it.
#[derive(Debug)]
pub struct HeldNodes {
    /// What each node is.
    pub role: Vec<Role>,
    /// Number of free nodes.
    pub free: usize,
    /// Skin vertices that hold softly: (vertex, area/ℓ), m.
    pub soft: Vec<(u32, f64)>,
    /// Skin vertices at each node that is one.
    pub vertices_of_node: BTreeMap<u32, Vec<u32>>,
}

impl HeldNodes {
    /// Of the nodes of `mesh`; `skin_areas` is the area of each skin vertex, m².
    pub fn new(
        mesh: &TetMesh,
        bone_of_node: &[Option<u32>],
        embedding: &Rows<(u32, f64)>,
        skin_areas: &[f64],
    ) -> Self {
        let mut vertices_of_node = BTreeMap::<u32, Vec<u32>>::new();
        let mut soft = Vec::new();
        let length = SOFT_LENGTH * mean_edge(mesh);
        for (v, row) in embedding.iter().enumerate() {
            match *row {
                [] => {}
                [(node, _)] => vertices_of_node.entry(node).or_default().push(v as u32),
                _ => soft.push((v as u32, skin_areas[v] / length)),
            }
        }
        let mut free = 0;
        let role = (bone_of_node.iter().enumerate())
            .map(|(n, bone)| match bone {
                Some(bone) => Role::Bone(*bone),
                None if vertices_of_node.contains_key(&(n as u32)) => Role::Skin,
                None => {
                    free += 1;
                    Role::Free(free - 1)
                }
            })
            .collect();
        Self {
            role,
            free: free as usize,
            soft,
            vertices_of_node,
        }
    }

    /// The mean of `on_skin` over the vertices of each node that the skin holds: (node, value).
    pub fn skin_values(&self, on_skin: impl Fn(u32) -> f64) -> impl Iterator<Item = (u32, f64)> {
        let held = self.vertices_of_node.iter();
        let held = held.filter(|(node, _)| self.role[**node as usize] == Role::Skin);
        held.map(move |(&node, vertices)| {
            let sum: f64 = vertices.iter().map(|&v| on_skin(v)).sum();
            (node, sum / vertices.len() as f64)
        })
    }
}

fn mean_edge(mesh: &TetMesh) -> f64 {
    let edges = (0..mesh.tets.len()).map(|t| {
        let [a, b, c, d] = mesh.corners(t);
        [(a, b), (a, c), (a, d), (b, c), (b, d), (c, d)].map(|(p, q)| p.distance(q))
    });
    edges.flatten().sum::<f64>() / (6 * mesh.tets.len()).max(1) as f64
}
