//! The soft layer between bone surfaces and a skin as a labelled body-centred cubic lattice.
//!
//! 1. The solid inside the skin is sampled on a grid eight times finer than the lattice.
//! 2. Samples of one tet that the solid connects make a piece; a tet holds as many pieces as the solid
//!    has parts in it, and each gets a tet of its own. Pieces of neighbouring tets that touch across a
//!    face share that face's nodes (virtual nodes: Molino, Bao and Fedkiw 2004; Sifakis et al. 2007).
//!    Fingers are thus never bridged, however near they are to each other.
//! 3. A tet's tissue fraction is the part of its samples that is in its piece and in no bone.
//! 4. Nodes inside a bone or within a quarter cell of it are held by it, if their pieces touch it.

use super::bcc::BccLattice;
use super::bone_nodes::{bones_of_nodes, nodes_near};
use super::disjoint_sets::DisjointSets;
use super::pieces::Pieces;
use super::samples::Samples;
use super::sound_skin::SoundSkin;
use crate::body::LayerMesh;
use glam::DVec3;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet, HashMap};
use supple::model::Surface;
use supple::{Error, Result};

/// How fine a lattice is.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum LatticeSize {
    /// Edge of a cubic cell, m; a cell has two nodes and twelve tets.
    Cell(f64),
    /// About this many nodes.
    Nodes(usize),
}

/// Samples along the edge of a cell.
const SAMPLES_PER_CELL: usize = 8;

/// Largest number of samples: 12 bytes each.
const MOST_SAMPLES: f64 = 64e6;

/// The part of a sample that a piece too small to hold one counts as.
const LEAST_SAMPLES: f64 = 0.25;

/// Meshes the tissue between `bones` (closed surfaces; empty ones are skipped) and `skin` (welded; it may
/// cut itself). Every skin vertex is embedded in a tet, unless no bone holds the part that it is on.
/// The bone nearest to the middle of a hole holds what is cut open there.
///
/// # Errors
/// [`Error::Invalid`] where a bone's surface is open or not finite, the size is out of range, or no
/// bone holds anything.
pub fn lattice(skin: &Surface, bones: &[Surface], size: LatticeSize) -> Result<LayerMesh> {
    let sound = SoundSkin::new(skin)?;
    let nearest = |h: usize| {
        let middle = sound.surface.positions[sound.report.vertices + h];
        let distance = |bone: &Surface| {
            let squares = bone.positions.iter().map(|p| p.distance_squared(middle));
            squares.fold(f64::INFINITY, f64::min)
        };
        let distances = bones.iter().map(distance).enumerate();
        distances
            .min_by(|a, b| a.1.total_cmp(&b.1))
            .map_or(0, |b| b.0 as u32)
    };
    let ends: Vec<u32> = (0..sound.rims.len()).map(nearest).collect();
    lattice_in(&sound, &ends, bones, size)
}

/// [`lattice`] in a skin that was looked through; `ends` is the bone at each of its holes.
pub(super) fn lattice_in(
    sound: &SoundSkin,
    ends: &[u32],
    bones: &[Surface],
    size: LatticeSize,
) -> Result<LayerMesh> {
    for (b, bone) in bones.iter().enumerate() {
        if !bone.triangles.is_empty() {
            validate_bone(&format!("bones[{b}]"), bone)?;
        }
    }
    let (skin, vertex) = sound.compact();
    let solid = Solid {
        sound,
        ends,
        bones,
        skin,
        vertex,
    };
    match size {
        LatticeSize::Cell(cell) => solid.lattice(cell, SAMPLES_PER_CELL),
        LatticeSize::Nodes(nodes) => solid.lattice(solid.cell_for_nodes(nodes)?, SAMPLES_PER_CELL),
    }
}

fn validate_bone(field: &str, surface: &Surface) -> Result<()> {
    let count = surface.positions.len();
    let sound = surface.positions.iter().all(|p| p.is_finite())
        && (surface.triangles.iter().flatten()).all(|&v| (v as usize) < count);
    if !sound {
        let problem = "holds a value that is not finite, or names a vertex that is not there";
        return Err(Error::invalid(field, problem));
    }
    if !surface.is_closed() {
        let cure = "is open or not welded: weld its seams and close its holes";
        return Err(Error::invalid(field, cure));
    }
    Ok(())
}

/// What a lattice is made in.
struct Solid<'a> {
    sound: &'a SoundSkin,
    /// The bone at each hole.
    ends: &'a [u32],
    bones: &'a [Surface],
    /// The closed skin without unused vertices.
    skin: Surface,
    /// The vertex of `sound` that each of `skin` is.
    vertex: Vec<u32>,
}

impl Solid<'_> {
    /// The cell that gives about `nodes` nodes: a few coarsely sampled tries.
    fn cell_for_nodes(&self, nodes: usize) -> Result<f64> {
        if !(50..=2_000_000).contains(&nodes) {
            return Err(Error::invalid(
                "recipe.mesher.nodes",
                "must be 50 to 2,000,000",
            ));
        }
        let volume = self.skin.volume().max(0.0);
        // Two nodes a cell, and half as much again where tets stick out.
        let mut cell = (3.0 * volume / nodes as f64).cbrt();
        for _ in 0..4 {
            let found = self.lattice(cell, SAMPLES_PER_CELL / 2)?.mesh.nodes.len();
            let ratio = found as f64 / nodes as f64;
            if (0.98..1.02).contains(&ratio) {
                break;
            }
            // Between a volume's power of 3 and a surface's of 2.
            cell *= ratio.powf(1.0 / 2.5);
        }
        Ok(cell)
    }

    /// The lattice of a cell, sampled `per_cell` along its edge, or half as finely where that would be
    /// too many.
    fn lattice(&self, cell: f64, per_cell: usize) -> Result<LayerMesh> {
        let positions = || self.skin.positions.iter().copied();
        let low = positions().fold(DVec3::INFINITY, DVec3::min);
        let high = positions().fold(DVec3::NEG_INFINITY, DVec3::max);
        let size = high - low;
        let count = |per_cell: usize| -> f64 {
            ((size / cell + 4.0) * per_cell as f64)
                .to_array()
                .iter()
                .product()
        };
        let coarse = SAMPLES_PER_CELL / 2;
        let per_cell = if count(per_cell) <= MOST_SAMPLES {
            per_cell
        } else {
            coarse
        };
        if !(cell > 0.0 && count(per_cell) <= MOST_SAMPLES) {
            let least = size.element_product().cbrt() * coarse as f64 / MOST_SAMPLES.cbrt();
            return Err(Error::invalid(
                "recipe.mesher.cell",
                format!("must be above {least:.2e} m for this skin"),
            ));
        }
        let lattice = BccLattice::covering(low, high, cell);
        let samples = Samples::new(&lattice, per_cell, &self.skin, self.bones);
        let mut pieces = Pieces::new(&lattice, &samples, &self.skin);
        let mut held = pieces.held_nodes(&bones_of_nodes(&lattice, self.bones));
        pieces.hold(&self.end_nodes(&lattice), &mut held);
        self.assemble(&lattice, &samples.per_tet(), &mut pieces, &held)
    }

    /// The lattice nodes at holes: within a quarter cell of the cap over one or on its far side, as if
    /// its bone went on there.
    fn end_nodes(&self, lattice: &BccLattice) -> BTreeMap<u32, u32> {
        let mut nodes = BTreeMap::new();
        for (h, &bone) in self.ends.iter().enumerate() {
            for (node, (offset, normal)) in nodes_near(lattice, &self.sound.cap(h), lattice.cell) {
                if offset.dot(normal) > 0.0 || offset.length() <= 0.25 * lattice.cell {
                    nodes.entry(node).or_insert(bone);
                }
            }
        }
        nodes
    }

    /// Numbers nodes and tets, drops what no bone holds, and embeds the skin.
    fn assemble(
        &self,
        lattice: &BccLattice,
        samples_per_tet: &[u32; 12],
        pieces: &mut Pieces,
        held: &BTreeMap<u32, u32>,
    ) -> Result<LayerMesh> {
        // Pieces of one tet whose nodes are all joined are one; their order is that of the lattice.
        let mut tets: BTreeMap<(u32, [u32; 4]), f64> = BTreeMap::new();
        let joined: Vec<[u32; 4]> = (0..pieces.list.len())
            .map(|p| pieces.joined_nodes(p))
            .collect();
        for (piece, nodes) in pieces.list.iter().zip(&joined) {
            if piece.tissue > 0 || piece.has_skin {
                *tets.entry((piece.tet, *nodes)).or_default() += f64::from(piece.tissue);
            }
        }
        for &p in &pieces.of_vertex {
            let key = (pieces.list[p as usize].tet, joined[p as usize]);
            tets.entry(key).or_default();
        }
        drop_loose_tets(&mut tets, held);
        if tets.is_empty() {
            let problem = "is connected to no bone: give it one inside";
            return Err(Error::invalid("skin", problem));
        }

        let mut layer = LayerMesh::default();
        let mut index_of_node: HashMap<u32, u32> = HashMap::new();
        let mut index_of_tet: HashMap<(u32, [u32; 4]), usize> = HashMap::new();
        for (&(tet, nodes), &tissue) in &tets {
            let lattice_nodes = lattice.tet_nodes(tet);
            index_of_tet.insert((tet, nodes), layer.mesh.tets.len());
            layer.mesh.tets.push(std::array::from_fn(|c| {
                *index_of_node.entry(nodes[c]).or_insert_with(|| {
                    layer
                        .mesh
                        .nodes
                        .push(lattice.node_position(lattice_nodes[c]));
                    layer.bone_of_node.push(held.get(&nodes[c]).copied());
                    layer.mesh.nodes.len() as u32 - 1
                })
            }));
            let all = f64::from(samples_per_tet[tet as usize % 12]);
            layer
                .tissue_fraction
                .push((tissue.max(LEAST_SAMPLES) / all).min(1.0));
        }
        let mut embedding = vec![Vec::new(); self.sound.report.vertices];
        for ((place, &p), &v) in
            (self.skin.positions.iter().zip(&pieces.of_vertex)).zip(&self.vertex)
        {
            let key = (pieces.list[p as usize].tet, joined[p as usize]);
            let tet = index_of_tet.get(&key);
            if let (Some(&tet), Some(row)) = (tet, embedding.get_mut(v as usize)) {
                let shares = layer.mesh.barycentric(tet, *place);
                *row = layer.mesh.tets[tet].into_iter().zip(shares).collect();
            }
        }
        layer.skin_embedding = (self.sound.stands_for.iter())
            .map(|&v| embedding[v as usize].iter().copied())
            .collect();
        Ok(layer)
    }
}

/// Drops parts of the mesh, connected by faces, that no bone holds.
fn drop_loose_tets(tets: &mut BTreeMap<(u32, [u32; 4]), f64>, held: &BTreeMap<u32, u32>) {
    let keys: Vec<_> = tets.keys().copied().collect();
    let mut parts = DisjointSets::new(keys.len());
    let mut face_of: HashMap<[u32; 3], u32> = HashMap::new();
    for (t, (_, nodes)) in keys.iter().enumerate() {
        for opposite in 0..4 {
            let mut face = [1, 2, 3].map(|i| nodes[(opposite + i) % 4]);
            face.sort_unstable();
            let twin = *face_of.entry(face).or_insert(t as u32);
            parts.union(t as u32, twin);
        }
    }
    let mut held_parts = BTreeSet::new();
    for (t, (_, nodes)) in keys.iter().enumerate() {
        if nodes.iter().any(|node| held.contains_key(node)) {
            held_parts.insert(parts.find(t as u32));
        }
    }
    for (t, key) in keys.iter().enumerate() {
        if !held_parts.contains(&parts.find(t as u32)) {
            tets.remove(key);
        }
    }
}
