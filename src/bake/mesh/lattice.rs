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
use super::bone_nodes::bones_of_nodes;
use super::disjoint_sets::DisjointSets;
use super::pieces::Pieces;
use super::samples::Samples;
use crate::model::{LayerMesh, Surface};
use crate::{Error, Result};
use glam::DVec3;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet, HashMap};

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

/// Meshes the tissue between `bones` (closed surfaces; empty ones are skipped) and `skin` (closed,
/// welded; it may cut itself). Every skin vertex is embedded in a tet.
///
/// # Errors
/// [`Error::Invalid`] where a surface is open or not finite, the size is out of range, or a part of
/// the skin is connected to no bone.
pub fn lattice(skin: &Surface, bones: &[Surface], size: LatticeSize) -> Result<LayerMesh> {
    validate("skin", skin)?;
    for (b, bone) in bones.iter().enumerate() {
        if !bone.triangles.is_empty() {
            validate(&format!("bones[{b}]"), bone)?;
        }
    }
    match size {
        LatticeSize::Cell(cell) => lattice_of_cell(skin, bones, cell, SAMPLES_PER_CELL),
        LatticeSize::Nodes(nodes) => {
            let cell = cell_for_nodes(skin, bones, nodes)?;
            lattice_of_cell(skin, bones, cell, SAMPLES_PER_CELL)
        }
    }
}

fn validate(field: &str, surface: &Surface) -> Result<()> {
    let count = surface.positions.len();
    let sound = surface.positions.iter().all(|p| p.is_finite())
        && surface
            .triangles
            .iter()
            .flatten()
            .all(|&v| (v as usize) < count);
    if !sound {
        let problem = "holds a value that is not finite, or names a vertex that is not there";
        return Err(Error::invalid(field, problem));
    }
    if !surface.is_closed() {
        let cure = "is open or not welded: weld its seams and close its holes";
        return Err(Error::invalid(field, cure));
    }
    let mut used = vec![false; count];
    surface
        .triangles
        .iter()
        .flatten()
        .for_each(|&v| used[v as usize] = true);
    match used.iter().position(|used| !used) {
        Some(v) => Err(Error::invalid(
            field,
            format!("vertex {v} is in no triangle: remove it"),
        )),
        None => Ok(()),
    }
}

/// The cell that gives about `nodes` nodes: a few coarsely sampled tries.
fn cell_for_nodes(skin: &Surface, bones: &[Surface], nodes: usize) -> Result<f64> {
    if !(50..=2_000_000).contains(&nodes) {
        return Err(Error::invalid("nodes", "must be 50 to 2,000,000"));
    }
    let volume = skin.volume().max(0.0);
    // Two nodes a cell, and half as much again where tets stick out.
    let mut cell = (3.0 * volume / nodes as f64).cbrt();
    for _ in 0..4 {
        let found = lattice_of_cell(skin, bones, cell, SAMPLES_PER_CELL / 2)?
            .mesh
            .nodes
            .len();
        let ratio = found as f64 / nodes as f64;
        if (0.98..1.02).contains(&ratio) {
            break;
        }
        // Between a volume's power of 3 and a surface's of 2.
        cell *= ratio.powf(1.0 / 2.5);
    }
    Ok(cell)
}

fn lattice_of_cell(
    skin: &Surface,
    bones: &[Surface],
    cell: f64,
    per_cell: usize,
) -> Result<LayerMesh> {
    let low = skin
        .positions
        .iter()
        .copied()
        .fold(DVec3::INFINITY, DVec3::min);
    let high = skin
        .positions
        .iter()
        .copied()
        .fold(DVec3::NEG_INFINITY, DVec3::max);
    let size = high - low;
    let count = ((size / cell + 4.0) * per_cell as f64)
        .to_array()
        .iter()
        .product::<f64>();
    if !(cell > 0.0 && count <= MOST_SAMPLES) {
        let least = size.element_product().cbrt() * per_cell as f64 / MOST_SAMPLES.cbrt();
        return Err(Error::invalid(
            "cell",
            format!("must be above {least:.2e} m for this skin"),
        ));
    }
    let lattice = BccLattice::covering(low, high, cell);
    let samples = Samples::new(&lattice, per_cell, skin, bones);
    let mut pieces = Pieces::new(&lattice, &samples, skin);
    let held = pieces.held_nodes(&bones_of_nodes(&lattice, bones));
    assemble(&lattice, &samples.per_tet(), &mut pieces, &held, skin)
}

/// Numbers nodes and tets, drops what no bone holds, and embeds the skin.
fn assemble(
    lattice: &BccLattice,
    samples_per_tet: &[u32; 12],
    pieces: &mut Pieces,
    held: &BTreeMap<u32, u32>,
    skin: &Surface,
) -> Result<LayerMesh> {
    // Pieces of one tet whose nodes are all joined are one; their order is that of the lattice.
    let mut tets: BTreeMap<(u32, [u32; 4]), (f64, bool)> = BTreeMap::new();
    let joined: Vec<[u32; 4]> = (0..pieces.list.len())
        .map(|p| pieces.joined_nodes(p))
        .collect();
    for (piece, nodes) in pieces.list.iter().zip(&joined) {
        if piece.tissue > 0 || piece.has_skin {
            let tet = tets.entry((piece.tet, *nodes)).or_default();
            tet.0 += f64::from(piece.tissue);
        }
    }
    for &p in &pieces.of_vertex {
        let key = (pieces.list[p as usize].tet, joined[p as usize]);
        tets.entry(key).or_default().1 = true;
    }
    drop_loose_tets(lattice, &mut tets, held)?;

    let mut layer = LayerMesh::default();
    let mut index_of_node: HashMap<u32, u32> = HashMap::new();
    let mut index_of_tet: HashMap<(u32, [u32; 4]), usize> = HashMap::new();
    for (&(tet, nodes), &(tissue, _)) in &tets {
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
    for (place, &p) in skin.positions.iter().zip(&pieces.of_vertex) {
        let key = (pieces.list[p as usize].tet, joined[p as usize]);
        let tet = index_of_tet[&key];
        let shares = layer.mesh.barycentric(tet, *place);
        layer
            .skin_embedding
            .push(layer.mesh.tets[tet].into_iter().zip(shares));
    }
    Ok(layer)
}

/// Drops parts of the mesh, connected by faces, that no bone holds.
fn drop_loose_tets(
    lattice: &BccLattice,
    tets: &mut BTreeMap<(u32, [u32; 4]), (f64, bool)>,
    held: &BTreeMap<u32, u32>,
) -> Result<()> {
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
        if held_parts.contains(&parts.find(t as u32)) {
            continue;
        }
        if tets.remove(key).is_some_and(|(_, embeds_skin)| embeds_skin) {
            let place = lattice.node_position(lattice.tet_nodes(key.0)[0]);
            return Err(Error::invalid(
                "skin",
                format!(
                    "the part near {place:.4} m is connected to no bone: remove it, or give it a bone"
                ),
            ));
        }
    }
    Ok(())
}
