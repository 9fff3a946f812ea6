//! Which nodes of a file are bones, besides the joints of its skins.

use super::container::File;
use super::nodes::Nodes;
use super::primitive::Part;
use std::collections::BTreeSet;

/// The nodes that an animation turns or shifts; not those of skinned meshes, which stand where their joints do.
pub(super) fn moved(file: &File) -> BTreeSet<usize> {
    let channels = (file.document.animations.iter()).flat_map(|a| &a.channels);
    let moves = |path: &str| path == "rotation" || path == "translation";
    let targets = channels
        .filter(|c| moves(&c.target.path))
        .filter_map(|c| c.target.node);
    let matters = |n: &usize| {
        let node = file.document.nodes.get(*n);
        node.is_some_and(|node| node.skin.is_none() || !node.children.is_empty())
    };
    targets.filter(matters).collect()
}

/// The bones of a file without a skin: nodes that show something, those that are moved above or below them, and what is
/// between.
pub(super) fn rigid(file: &File, nodes: &Nodes, parts: &[Part]) -> BTreeSet<usize> {
    let shows: BTreeSet<usize> = parts.iter().map(|p| p.node).collect();
    let reach = Reach::new(nodes, &shows);
    let moved = moved(file).into_iter();
    let mut bones: BTreeSet<usize> = moved
        .filter(|&n| reach.above[n] || reach.below[n])
        .collect();
    bones.extend(shows);
    with_between(nodes, &BTreeSet::new(), &bones)
}

/// `more` nodes, and those between any of them, or between one of them and a `bone`; the bones too.
pub(super) fn with_between(
    nodes: &Nodes,
    bones: &BTreeSet<usize>,
    more: &BTreeSet<usize>,
) -> BTreeSet<usize> {
    let all: BTreeSet<usize> = bones.union(more).copied().collect();
    let (any, own) = (Reach::new(nodes, &all), Reach::new(nodes, more));
    let between = |n: &usize| any.above[*n] && own.below[*n] || own.above[*n] && any.below[*n];
    let between: Vec<usize> = nodes.order.iter().copied().filter(between).collect();
    all.into_iter().chain(between).collect()
}

/// All nodes of the trees that `some` are in.
pub(super) fn whole_trees(nodes: &Nodes, some: &BTreeSet<usize>) -> BTreeSet<usize> {
    let reach = Reach::new(nodes, some);
    let mut within = vec![false; nodes.parents.len()];
    for &n in &nodes.order {
        within[n] = match nodes.parents[n] {
            Some(p) => within[p],
            None => reach.below[n] || some.contains(&n),
        };
    }
    (0..within.len()).filter(|&n| within[n]).collect()
}

/// Of every node, whether one of some others is above it, and whether one is below.
struct Reach {
    above: Vec<bool>,
    below: Vec<bool>,
}

impl Reach {
    fn new(nodes: &Nodes, others: &BTreeSet<usize>) -> Self {
        let mut above = vec![false; nodes.parents.len()];
        let mut below = above.clone();
        for &n in &nodes.order {
            above[n] = nodes.parents[n].is_some_and(|p| above[p] || others.contains(&p));
        }
        for &n in nodes.order.iter().rev() {
            if let Some(p) = nodes.parents[n] {
                below[p] |= below[n] || others.contains(&n);
            }
        }
        Self { above, below }
    }
}
