//! The parts of the solid in the lattice's tets, and which nodes they share.

use super::bcc::{BccLattice, shared_corners};
use super::disjoint_sets::DisjointSets;
use super::samples::Samples;
use super::skin_points::SkinPoints;
use std::collections::{BTreeMap, BTreeSet};
use supple::internal::math::par_map;
use supple::model::Surface;

/// One connected part of the solid in one tet.
#[derive(Clone, Debug)]
pub(super) struct Piece {
    /// The lattice tet.
    pub tet: u32,
    /// Its lattice nodes.
    pub nodes: [u32; 4],
    /// Samples in it and in no bone.
    pub tissue: u32,
    /// Whether it holds a point of the skin's wireframe.
    pub has_skin: bool,
    /// The bones that hold samples of it.
    bones: BTreeSet<u32>,
}

/// All pieces of a solid. Each gets a tet of its own.
pub(super) struct Pieces {
    /// In the order of their first samples.
    pub list: Vec<Piece>,
    /// Corner `c` of piece `p` is element 4 p + c; joined corners are one node.
    corners: DisjointSets,
    /// The piece of each skin vertex.
    pub of_vertex: Vec<u32>,
}

impl Pieces {
    /// Cuts the solid into pieces and joins the corners of those that touch across a face.
    pub fn new(lattice: &BccLattice, samples: &Samples, skin: &Surface) -> Self {
        let mut sets = DisjointSets::new(samples.len());
        samples.join_within_tets(&mut sets);
        let points = SkinPoints::new(lattice, samples, skin, &mut sets);

        let mut list: Vec<Piece> = Vec::new();
        let mut piece_of = vec![u32::MAX; sets.len()];
        let mut enter = |element: usize, tet: u32| {
            // A set's representative is its smallest member and so comes first.
            let first = sets.find(element as u32) as usize;
            if first == element {
                piece_of[element] = list.len() as u32;
                list.push(Piece {
                    tet,
                    nodes: lattice.tet_nodes(tet),
                    tissue: 0,
                    has_skin: false,
                    bones: BTreeSet::new(),
                });
            }
            piece_of[element] = piece_of[first];
        };
        samples.for_each_solid(|s| enter(s, samples.tet(s)));
        for (i, &tet) in points.tets.iter().enumerate() {
            enter(samples.len() + i, tet);
        }
        samples.for_each_solid(|s| {
            let piece = &mut list[piece_of[s] as usize];
            match samples.bone(s) {
                Some(bone) => drop(piece.bones.insert(bone.into())),
                None => piece.tissue += 1,
            }
        });
        for &piece in &piece_of[samples.len()..] {
            list[piece as usize].has_skin = true;
        }

        let mut pieces = Self {
            corners: DisjointSets::new(4 * list.len()),
            of_vertex: piece_of[samples.len()..][..skin.positions.len()].to_vec(),
            list,
        };
        samples.for_each_solid(|s| {
            for next in (0..3).filter_map(|axis| samples.linked(s, axis)) {
                pieces.join_across_face(piece_of[s], piece_of[next]);
            }
        });
        for &(a, b) in &points.across_faces {
            pieces.join_across_face(piece_of[a as usize], piece_of[b as usize]);
        }
        pieces.join_needless_doubles(samples, &piece_of);
        pieces
    }

    /// Joins the doubles of a lattice node between which the solid around it is connected, where
    /// what connects them is too small for a sample of its tet.
    fn join_needless_doubles(&mut self, samples: &Samples, piece_of: &[u32]) {
        let mut doubles: BTreeMap<u32, BTreeSet<u32>> = BTreeMap::new();
        for p in 0..self.list.len() {
            let joined = self.joined_nodes(p);
            for (node, joined) in self.list[p].nodes.into_iter().zip(joined) {
                doubles.entry(node).or_default().insert(joined);
            }
        }
        doubles.retain(|_, joined| joined.len() > 1);
        let nodes: Vec<u32> = doubles.into_keys().collect();
        let parts = par_map(nodes.len(), |i| samples.parts_around(nodes[i]));
        for (node, parts) in nodes.into_iter().zip(parts) {
            let mut corner_of_part: BTreeMap<usize, u32> = BTreeMap::new();
            for (s, part) in parts {
                let p = piece_of[s];
                let corner = self.list[p as usize].nodes.iter().position(|&n| n == node);
                if let Some(c) = corner {
                    let corner = 4 * p + c as u32;
                    let first = *corner_of_part.entry(part).or_insert(corner);
                    self.corners.union(first, corner);
                }
            }
        }
    }

    fn join_across_face(&mut self, a: u32, b: u32) {
        let [p, q] = [a, b].map(|i| &self.list[i as usize]);
        if p.tet == q.tet {
            return;
        }
        let (p, q) = (p.nodes, q.nodes);
        for (i, j) in shared_corners(&p, &q) {
            self.corners.union(4 * a + i as u32, 4 * b + j as u32);
        }
    }

    /// The nodes of piece `p`, each named by its smallest corner.
    pub fn joined_nodes(&mut self, p: usize) -> [u32; 4] {
        [0, 1, 2, 3].map(|c| self.corners.find(4 * p as u32 + c))
    }

    /// The bone of each node that one holds: of the `candidates` of its lattice node the first that a
    /// piece around it touches. So a bone does not reach into the finger beside it.
    pub fn held_nodes(&mut self, candidates: &BTreeMap<u32, Vec<u32>>) -> BTreeMap<u32, u32> {
        let mut touching: BTreeMap<u32, (u32, BTreeSet<u32>)> = BTreeMap::new();
        for p in 0..self.list.len() {
            let joined = self.joined_nodes(p);
            let piece = &self.list[p];
            for (node, joined) in piece.nodes.into_iter().zip(joined) {
                if candidates.contains_key(&node) {
                    let (_, bones) = touching.entry(joined).or_insert((node, BTreeSet::new()));
                    bones.extend(&piece.bones);
                }
            }
        }
        (touching.into_iter())
            .filter_map(|(joined, (node, bones))| {
                let bone = candidates[&node].iter().find(|bone| bones.contains(bone))?;
                Some((joined, *bone))
            })
            .collect()
    }

    /// Adds the nodes of `ends`, each with its bone, to those that are `held`.
    pub fn hold(&mut self, ends: &BTreeMap<u32, u32>, held: &mut BTreeMap<u32, u32>) {
        for p in 0..self.list.len() {
            let joined = self.joined_nodes(p);
            for (node, joined) in self.list[p].nodes.into_iter().zip(joined) {
                if let Some(&bone) = ends.get(&node) {
                    held.entry(joined).or_insert(bone);
                }
            }
        }
    }
}
