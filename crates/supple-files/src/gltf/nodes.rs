//! The node hierarchy: a forest, checked, with its matrices (glTF 2.0, §3.5).

use super::container::File;
use super::document::Node;
use super::polar::polar_factor;
use glam::{DAffine3, DMat3, DMat4, DQuat, DVec3};
use supple::Result;

/// Farther than this from the origin, m, nothing of a character is: numbers could overflow.
pub(super) const FARTHEST: f64 = 1e9;

/// Translation, rotation and scale of a node, or its matrix.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Local {
    pub translation: DVec3,
    pub rotation: DQuat,
    pub scale: DVec3,
    /// Takes the place of the three.
    pub matrix: Option<DAffine3>,
}

impl Local {
    pub fn affine(&self) -> DAffine3 {
        self.matrix.unwrap_or_else(|| {
            DAffine3::from_scale_rotation_translation(self.scale, self.rotation, self.translation)
        })
    }

    /// Its rotation, with its mirrors and without its scale.
    fn orthogonal(&self) -> DMat3 {
        let sign = |s: f64| if s < 0.0 { -1.0 } else { 1.0 };
        let mirrors = DVec3::from_array(self.scale.to_array().map(sign));
        match self.matrix {
            Some(matrix) => polar_factor(matrix.matrix3).unwrap_or(DMat3::IDENTITY),
            None => DMat3::from_quat(self.rotation) * DMat3::from_diagonal(mirrors),
        }
    }
}

/// The hierarchy of a file.
#[derive(Debug)]
pub(super) struct Nodes {
    pub parents: Vec<Option<usize>>,
    /// All nodes, parents before children.
    pub order: Vec<usize>,
    /// Placement in the parent at rest.
    pub rest: Vec<Local>,
    /// Placement in the world at rest.
    pub rest_world: Vec<DAffine3>,
    /// Rotation in the world at rest ([`Nodes::turned`]).
    pub rest_rotation: Vec<DMat3>,
    /// Whether the scene shows it.
    pub shown: Vec<bool>,
}

impl Nodes {
    /// The nodes of `file`: each has one parent at most and there is no cycle.
    pub fn read(file: &File) -> Result<Self> {
        let nodes = &file.document.nodes;
        let broken =
            |n: usize, problem: String| file.broken(format!("nodes[{n}].children"), problem);
        let mut parents = vec![None; nodes.len()];
        for (n, node) in nodes.iter().enumerate() {
            for &child in &node.children {
                let slot = parents.get_mut(child);
                let slot = slot.ok_or_else(|| broken(n, format!("node {child} is not there")))?;
                if let Some(other) = slot.replace(n) {
                    let problem = format!("node {child} is a child of node {other} too");
                    return Err(broken(n, problem));
                }
            }
        }
        let mut order: Vec<usize> = (0..nodes.len()).filter(|&n| parents[n].is_none()).collect();
        let mut next = 0;
        while let Some(&n) = order.get(next) {
            order.extend(&nodes[n].children);
            next += 1;
        }
        if order.len() < nodes.len() {
            let mut reached = vec![false; nodes.len()];
            order.iter().for_each(|&n| reached[n] = true);
            let n = reached.iter().position(|r| !r).unwrap_or(0);
            return Err(broken(n, "is among its own descendants".into()));
        }
        let rest = nodes.iter().enumerate();
        let rest =
            rest.map(|(n, node)| local(node).map_err(|e| file.broken(format!("nodes[{n}]"), e)));
        let rest: Vec<Local> = rest.collect::<Result<_>>()?;
        let mut out = Self {
            parents,
            order,
            rest_world: Vec::new(),
            rest_rotation: vec![DMat3::IDENTITY; nodes.len()],
            shown: vec![true; nodes.len()],
            rest,
        };
        out.rest_world = out.world(&out.rest);
        let near = |w: &DAffine3| w.to_cols_array().iter().all(|c| c.abs() < FARTHEST);
        if let Some(n) = out.rest_world.iter().position(|w| !near(w)) {
            return Err(file.broken(
                format!("nodes[{n}]"),
                "its place in the world is out of all bounds",
            ));
        }
        for &n in &out.order {
            out.rest_rotation[n] = out.turned(n, &out.rest[n], &out.rest_world, &out.rest_rotation);
        }
        out.show(file)?;
        Ok(out)
    }

    /// Marks what is below the roots of the file's scene and not hidden there (KHR_node_visibility). Where the file names no
    /// scene, its first is meant; where it has none, everything is in it.
    fn show(&mut self, file: &File) -> Result<()> {
        self.show_scene(file)?;
        let hidden = |n: usize| {
            let visibility = &file.document.nodes[n].extensions.visibility;
            visibility.as_ref().is_some_and(|v| !v.visible)
        };
        let mut hides = vec![false; self.shown.len()];
        for &n in &self.order {
            hides[n] = hidden(n) || self.parents[n].is_some_and(|p| hides[p]);
            self.shown[n] &= !hides[n];
        }
        Ok(())
    }

    fn show_scene(&mut self, file: &File) -> Result<()> {
        let document = &file.document;
        let index = document.scene.unwrap_or(0);
        let Some(scene) = document.scenes.get(index) else {
            return match document.scene {
                None => Ok(()),
                Some(_) => Err(file.broken("scene", format!("scene {index} is not there"))),
            };
        };
        self.shown.fill(false);
        for &n in &scene.nodes {
            let slot = self.shown.get_mut(n);
            *slot.ok_or_else(|| {
                let field = format!("scenes[{index}].nodes");
                file.broken(field, format!("node {n} is not there"))
            })? = true;
        }
        for &n in &self.order {
            self.shown[n] |= self.parents[n].is_some_and(|p| self.shown[p]);
        }
        Ok(())
    }

    /// Placement of every node in the world.
    pub fn world(&self, local: &[Local]) -> Vec<DAffine3> {
        let mut world = vec![DAffine3::IDENTITY; local.len()];
        for &n in &self.order {
            let above = self.parents[n].map_or(DAffine3::IDENTITY, |p| world[p]);
            world[n] = above * local[n].affine();
        }
        world
    }

    /// Rotation of node `n` in the world: the polar factor of its matrix, or, where that is scaled to nothing, its parent's
    /// rotation times its own. The `world` and `rotations` above it are known.
    pub fn turned(
        &self,
        n: usize,
        local: &Local,
        world: &[DAffine3],
        rotations: &[DMat3],
    ) -> DMat3 {
        polar_factor(world[n].matrix3).unwrap_or_else(|| {
            let above = self.parents[n].map_or(DMat3::IDENTITY, |p| rotations[p]);
            above * local.orthogonal()
        })
    }

    /// Placement of node `n` in the world at rest; of one that is scaled to nothing, without its scale.
    pub fn rest_with_inverse(&self, n: usize) -> DAffine3 {
        let world = self.rest_world[n];
        match polar_factor(world.matrix3) {
            Some(_) => world,
            None => DAffine3 {
                matrix3: self.rest_rotation[n],
                ..world
            },
        }
    }

    /// The nodes above `n`, itself first.
    pub fn upward(&self, n: usize) -> impl Iterator<Item = usize> {
        std::iter::successors(Some(n), |&n| self.parents[n])
    }
}

fn local(node: &Node) -> Result<Local, String> {
    let rotation = DQuat::from_array(node.rotation.unwrap_or([0.0, 0.0, 0.0, 1.0]));
    // A quaternion that is finite and has a length has an inverse of that length.
    let length = rotation.length();
    if !(length.is_finite() && length > 1e-6) {
        return Err("its rotation is no unit quaternion".into());
    }
    let matrix = node.matrix.map(|m| DMat4::from_cols_array(&m));
    if matrix.is_some_and(|m| (m.row(3) - glam::DVec4::W).abs().max_element() > 1e-6) {
        return Err("the last row of its matrix is not 0 0 0 1".into());
    }
    let local = Local {
        translation: DVec3::from_array(node.translation.unwrap_or([0.0; 3])),
        rotation: rotation / length,
        scale: DVec3::from_array(node.scale.unwrap_or([1.0; 3])),
        matrix: matrix.map(DAffine3::from_mat4),
    };
    match local.affine().is_finite() {
        true => Ok(local),
        false => Err("holds a value that is not finite".into()),
    }
}
