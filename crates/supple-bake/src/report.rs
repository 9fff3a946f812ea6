//! What a bake did.

use crate::body::Body;
use crate::bones::{BoneMassReport, SpringReport};
use crate::cubature::CubatureReport;
use crate::depth::ThinPlace;
use crate::fine::FineReport;
use crate::math::NearestPoint;
use crate::mesh::MeshReport;
use crate::softness::RegionReport;
use glam::DVec3;
use serde::{Deserialize, Serialize};
use supple::material::Material;

/// Figures of a bake, for people and for JSON. A baked file keeps them, but for its cost.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BakeReport {
    /// What was baked.
    pub name: String,
    /// Size of the box around the skin, m.
    pub extent: [f64; 3],
    /// Names of the bones.
    pub bone_names: Vec<String>,
    /// Skin vertices.
    pub skin_vertices: usize,
    /// Triangles of the skin.
    pub skin_triangles: usize,
    /// What is drawn with the skin and is not part of it.
    pub attachments: Vec<AttachmentReport>,
    /// The layer's mesh, and the skin it was made from.
    pub mesh: MeshReport,
    /// Nodes that no bone holds.
    pub free_nodes: usize,
    /// Depth that counts as deep: 15 % of the skin's area lie over more, m.
    pub deep: f64,
    /// Depth of the tissue under the skin that each bone leads: least, median, greatest, m; 0 where it leads none.
    pub depth_per_bone: Vec<[f64; 3]>,
    /// Where it is much thinner than around, the largest place first.
    pub thin_places: Vec<ThinPlace>,
    /// The handles.
    pub handles: HandleReport,
    /// Their basis.
    pub basis: BasisReport,
    /// The cubature's weights.
    pub cubature: CubatureReport,
    /// The handles that sleep, where there are any.
    pub fine: Option<FineReport>,
    /// What the tissue is made of.
    pub material: Material,
    /// Whether the bake chose the material.
    pub material_chosen: bool,
    /// How soft its regions are.
    pub softness: Vec<RegionReport>,
    /// Factor on its stiffness by regions: least, mean over the volume, greatest, of the cubature points.
    pub stiffness: [f64; 3],
    /// Mass of the tissue, kg.
    pub tissue_mass: f64,
    /// The bones' masses.
    pub bones: BoneMassReport,
    /// What swings.
    pub springs: SpringReport,
    /// What was decided about the body's file, a sentence each.
    pub notes: Vec<String>,
    /// Time and memory; empty in a baked file, which is the same whatever a bake took.
    pub cost: BakeCost,
}

/// A surface drawn with the skin.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct AttachmentReport {
    /// Its name.
    pub name: String,
    /// Vertices.
    pub vertices: usize,
    /// Whether it follows the nearest tissue, or its bones alone.
    pub follows_tissue: bool,
    /// Its vertices that are near enough to the skin to move with it.
    pub following: usize,
}

/// Where handles stand.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct HandleReport {
    /// How many.
    pub count: usize,
    /// Whether the bake chose them.
    pub chosen: bool,
    /// How many each region of the recipe gave, in order.
    pub per_region: Vec<usize>,
    /// How many stand on each bone: where it has the largest weight.
    pub per_bone: Vec<usize>,
    /// Distance of each to the nearest other: least, median, greatest, m; 0 where there is one handle.
    pub spacing: [f64; 3],
}

/// How good the basis is.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct BasisReport {
    /// Largest error of Σ U_h f(X_h) + bones' affine columns = f, over f = 1 and the coordinates in
    /// units of the layer's size, before truncation.
    pub linear_precision: f64,
    /// Tets that hang on the rest by an edge or a corner, where the basis is a constant.
    pub loose_tets: usize,
    /// Relative change of the basis by truncation; 0 where it is off.
    pub truncation_cost: f64,
    /// Handles of a skin vertex that has any: mean and most.
    pub handles_per_vertex: (f64, usize),
    /// Handles of a cubature point: mean and most.
    pub handles_per_point: (f64, usize),
}

/// What a bake took.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct BakeCost {
    /// Seconds each phase took, in order.
    pub seconds: Vec<(String, f64)>,
    /// Most memory that the process ever held, bytes; `None` where the system does not tell.
    pub peak_memory: Option<u64>,
}

impl BakeCost {
    /// Seconds of all phases.
    pub fn total_seconds(&self) -> f64 {
        self.seconds.iter().map(|s| s.1).sum()
    }
}

impl HandleReport {
    /// Figures of handles at `positions`, each counted for the bone of the skin nearest to it.
    pub(crate) fn new(
        body: &Body,
        positions: &[DVec3],
        per_region: Vec<usize>,
        chosen: bool,
    ) -> Self {
        let skin = NearestPoint::new(&body.skin.positions);
        let mut per_bone = vec![0; body.skeleton.len()];
        for &place in positions {
            let nearest = skin.nearest(place);
            let row = nearest.map_or(&[][..], |(v, _)| body.skinning.row(v as usize));
            if let Some(w) = row.iter().max_by(|a, b| a.weight.total_cmp(&b.weight)) {
                per_bone[w.bone as usize] += 1;
            }
        }
        let gap = |h: usize| {
            let others = (0..positions.len()).filter(|&o| o != h);
            let distances = others.map(|o| positions[h].distance(positions[o]));
            distances.reduce(f64::min)
        };
        let mut gaps: Vec<f64> = (0..positions.len()).filter_map(gap).collect();
        gaps.sort_by(f64::total_cmp);
        let spacing = match (gaps.first(), gaps.last()) {
            (Some(&least), Some(&greatest)) => [least, gaps[gaps.len() / 2], greatest],
            _ => [0.0; 3],
        };
        Self {
            count: positions.len(),
            chosen,
            per_region,
            per_bone,
            spacing,
        }
    }
}

/// Most memory that this process ever held, bytes, where the system tells it (Linux).
pub(crate) fn peak_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|l| l.strip_prefix("VmHWM:"))?;
    let kibibytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(1024 * kibibytes)
}
