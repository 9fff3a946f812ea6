//! The bones' tree out of a file's joints.

use super::container::File;
use super::nodes::Nodes;
use super::webxr;
use std::collections::{BTreeMap, BTreeSet};

/// Bones, parents before children, with one root.
pub(super) struct BoneTree {
    /// The node of each.
    pub nodes: Vec<usize>,
    pub parents: Vec<Option<u32>>,
}

impl BoneTree {
    /// A bone's parent is the nearest joint above it. Joints with none above them hang on the one of
    /// them that carries most weight with what is below it; those of a WebXR hand are often siblings
    /// and get the hierarchy that their names imply.
    pub fn new(
        file: &File,
        nodes: &Nodes,
        is_joint: &BTreeSet<usize>,
        weight: &[f64],
    ) -> Option<Self> {
        let mut above: BTreeMap<usize, Option<usize>> = BTreeMap::new();
        for &n in is_joint {
            above.insert(n, nodes.upward(n).skip(1).find(|a| is_joint.contains(a)));
        }
        if above.values().filter(|a| a.is_none()).count() > 1 {
            let names = file.document.nodes.iter().map(|n| n.name.as_deref());
            let pairs = webxr::parents(&names.collect::<Vec<_>>(), is_joint);
            // Only where none has a parent: a mixture could close a ring.
            if (pairs.iter())
                .all(|(child, parent)| [child, parent].iter().all(|n| above[n].is_none()))
            {
                above.extend(pairs.iter().map(|&(child, parent)| (child, Some(parent))));
            }
        }
        let mut carried = weight.to_vec();
        let mut order: Vec<usize> = Vec::new();
        for &n in nodes.order.iter().rev().filter(|n| is_joint.contains(n)) {
            order.push(n);
            if let Some(p) = above[&n] {
                carried[p] += carried[n];
            }
        }
        let roots = order.iter().rev().copied().filter(|n| above[n].is_none());
        let root = roots.reduce(|best, n| if carried[n] > carried[best] { n } else { best })?;

        let mut sorted = vec![root];
        let mut children: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        for &n in order.iter().rev().filter(|&&n| n != root) {
            children
                .entry(above[&n].unwrap_or(root))
                .or_default()
                .push(n);
        }
        let mut parents = vec![None];
        let mut next = 0;
        while let Some(n) = sorted.get(next) {
            for &child in children.get(n).into_iter().flatten() {
                sorted.push(child);
                parents.push(Some(next as u32));
            }
            next += 1;
        }
        Some(Self {
            nodes: sorted,
            parents,
        })
    }

    /// Number of bones that are one of `bones` or above one.
    pub fn count_above(&self, bones: impl Iterator<Item = u32>) -> usize {
        let mut above: BTreeSet<u32> = BTreeSet::new();
        for bone in bones {
            let mut next = Some(bone);
            while let Some(b) = next.filter(|b| above.insert(*b)) {
                next = self.parents[b as usize];
            }
        }
        above.len()
    }
}
