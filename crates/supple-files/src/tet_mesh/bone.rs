//! A tet mesh that comes without a skeleton: a body around one bone.

use super::{BONE, TetFile};
use std::collections::{BTreeMap, BTreeSet};
use supple::model::TetMesh;
use supple::{Error, Result};
use supple_bake::math::NearestPoint;
use supple_bake::{Body, one_bone_body};

/// Without any sign of a bone, nodes deeper than this part of the greatest depth are held.
const CORE: f64 = 0.6;

impl TetFile {
    /// A body around one bone called `bone`, which stands in the middle of what it holds. It holds
    /// - what is labelled `bone`, or mapped to it by `regions`; else
    /// - regions of tets that are nowhere on the outside; else
    /// - the walls of hollows; else
    /// - the core: nodes deeper than six tenths of the greatest depth.
    ///
    /// # Errors
    /// [`Error::Invalid`] as [`TetFile::layer`], and where a mesh has no inside.
    pub fn body(&self, name: &str, regions: &BTreeMap<String, String>) -> Result<Body> {
        let bones = [BONE.to_string()];
        let named = self.labels.iter().any(|l| l == BONE) || !regions.is_empty();
        let made = if named {
            self.layer(&bones, regions)?
        } else {
            let none = vec![None; self.mesh.tets.len()];
            if let Some(inner) = self.inner_regions() {
                self.layer_held(1, &inner, std::iter::empty())?
            } else {
                let nodes = self.hollow_nodes().or_else(|| self.core_nodes());
                let nodes = nodes.ok_or_else(|| {
                    Error::invalid(
                        "layer",
                        "the mesh has no inside: refine it, or label its bone",
                    )
                })?;
                self.layer_held(1, &none, nodes.into_iter().map(|n| (n, 0)))?
            }
        };
        let held = (0u32..).zip(&made.layer.bone_of_node);
        let pinned: Vec<u32> = held.filter(|h| h.1.is_some()).map(|h| h.0).collect();
        let surface: Vec<u32> = made
            .layer
            .skin_embedding
            .entries()
            .iter()
            .map(|e| e.0)
            .collect();
        let mut body = one_bone_body(name, made.layer.mesh, &pinned, &surface)?;
        body.bone_surfaces = made.bone_surfaces;
        Ok(body)
    }

    /// Bone 0 for the tets of regions none of whose faces lies on the outside, where there are some.
    fn inner_regions(&self) -> Option<Vec<Option<u32>>> {
        let outside: BTreeSet<u32> = self
            .mesh
            .boundary_triangles()
            .into_iter()
            .flatten()
            .collect();
        let on_outside = |tet: &[u32; 4]| tet.iter().filter(|n| outside.contains(n)).count() > 2;
        let tets = self.mesh.tets.iter().zip(&self.tet_labels);
        let outer = tets.filter(|(tet, _)| on_outside(tet));
        let outer: BTreeSet<Option<u32>> = outer.map(|(_, label)| *label).collect();
        let inner: Vec<Option<u32>> = (self.tet_labels.iter())
            .map(|label| (!outer.contains(label)).then_some(0))
            .collect();
        inner.iter().any(Option::is_some).then_some(inner)
    }

    /// Nodes of the hollows' walls: parts of the mesh's surface that are turned inside out.
    fn hollow_nodes(&self) -> Option<Vec<u32>> {
        let triangles = self.mesh.boundary_triangles();
        let parts = components(self.mesh.nodes.len(), triangles.iter().map(|t| &t[..]));
        let mut volumes: BTreeMap<u32, f64> = BTreeMap::new();
        for triangle in &triangles {
            let [a, b, c] = triangle.map(|n| self.mesh.nodes[n as usize] - self.mesh.nodes[0]);
            *volumes.entry(parts[triangle[0] as usize]).or_default() += a.dot(b.cross(c));
        }
        let nodes: BTreeSet<u32> = (triangles.iter().flatten().copied())
            .filter(|n| volumes[&parts[*n as usize]] < 0.0)
            .collect();
        (!nodes.is_empty()).then(|| nodes.into_iter().collect())
    }

    /// The deepest nodes.
    fn core_nodes(&self) -> Option<Vec<u32>> {
        let outside: BTreeSet<u32> = self
            .mesh
            .boundary_triangles()
            .into_iter()
            .flatten()
            .collect();
        let places: Vec<_> = outside
            .iter()
            .map(|&n| self.mesh.nodes[n as usize])
            .collect();
        let search = NearestPoint::new(&places);
        let depth: Vec<f64> = self
            .mesh
            .nodes
            .iter()
            .map(|n| search.distance(*n))
            .collect();
        let greatest = depth.iter().copied().fold(0.0, f64::max);
        let deep = (0u32..).zip(&depth).filter(|(_, d)| **d > CORE * greatest);
        (greatest > 0.0).then(|| deep.map(|(n, _)| n).collect())
    }
}

/// The lowest node of the piece that each node belongs to.
pub(super) fn pieces(mesh: &TetMesh) -> Vec<u32> {
    components(mesh.nodes.len(), mesh.tets.iter().map(|t| &t[..]))
}

/// The lowest of the nodes that each node is joined with by groups of nodes.
fn components<'a>(nodes: usize, groups: impl Iterator<Item = &'a [u32]>) -> Vec<u32> {
    let mut parent: Vec<u32> = (0..nodes as u32).collect();
    for group in groups {
        for pair in group.windows(2) {
            let (a, b) = (root(&mut parent, pair[0]), root(&mut parent, pair[1]));
            parent[a.max(b) as usize] = a.min(b);
        }
    }
    (0..nodes as u32).map(|n| root(&mut parent, n)).collect()
}

fn root(parent: &mut [u32], mut node: u32) -> u32 {
    while parent[node as usize] != node {
        let above = parent[parent[node as usize] as usize];
        parent[node as usize] = above;
        node = above;
    }
    node
}
