//! Where handles stand: on the skin, at nodes or at points inside the volume.

use super::biharmonic::Constraints;
use super::sampling::{Density, farthest_points};
use crate::math::Rows;
use crate::model::{Body, SkinWeight};
use crate::{Error, Result};
use glam::DVec3;
use serde::{Deserialize, Serialize};

/// Some handles: a region, and how densely it is sampled. Without count and spacing every candidate
/// becomes a handle: that is an exact list.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct HandleRegion {
    /// What the candidates are.
    pub place: HandlePlace,
    /// Only where one of these bones has the largest weight; none named: everywhere.
    pub bones: Vec<String>,
    /// Only these skin vertices (`skin`) or nodes (`volume`); none named: all.
    pub vertices: Vec<u32>,
    /// Only inside this box: lowest and highest corner in the reference shape, m.
    pub within: Option<[[f64; 3]; 2]>,
    /// The points themselves (`points`), in the reference shape, m.
    pub points: Vec<[f64; 3]>,
    /// How many, by farthest-point sampling.
    pub count: Option<usize>,
    /// Or until no candidate is farther than this from a handle, m.
    pub spacing: Option<f64>,
}

/// What the candidates of a region are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum HandlePlace {
    /// Skin vertices.
    #[default]
    Skin,
    /// Nodes of the layer that no bone holds, skin included.
    Volume,
    /// Points given by their coordinates, inside the layer.
    Points,
}

/// Handles of a body.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Handles {
    /// Rest position of each, m.
    pub positions: Vec<DVec3>,
    /// The condition on the nodes that makes U = 1 there.
    pub constraints: Constraints,
}

/// A place a handle can take.
struct Candidate {
    position: DVec3,
    row: Vec<(u32, f64)>,
}

impl Handles {
    /// The handles of all `regions` in order, each region keeping away from those before it.
    /// `node_skinning` is the bones of each node.
    ///
    /// # Errors
    /// [`Error::Invalid`] where a region names what is not there, holds no candidate, or a point of an
    /// exact list lies outside the layer, on a bone, or where a handle already is.
    pub fn place(
        body: &Body,
        node_skinning: &Rows<SkinWeight>,
        regions: &[HandleRegion],
    ) -> Result<Self> {
        let mut handles = Self::default();
        for (r, region) in regions.iter().enumerate() {
            let field = format!("handles[{r}]");
            let candidates = candidates(body, node_skinning, region, &field)?;
            if candidates.is_empty() {
                return Err(Error::invalid(field, "no soft place lies in this region"));
            }
            let density = match (region.count, region.spacing) {
                (None, None) => None,
                (Some(count), None) if count > 0 => Some(Density::Count(count)),
                (None, Some(spacing)) if spacing > 0.0 => Some(Density::Spacing(spacing)),
                _ => {
                    let problem = "needs a positive count or a positive spacing (m), not both";
                    return Err(Error::invalid(field, problem));
                }
            };
            let positions: Vec<DVec3> = candidates.iter().map(|c| c.position).collect();
            let chosen = match density {
                Some(density) => farthest_points(&positions, &handles.positions, density),
                None => (0..candidates.len() as u32).collect(),
            };
            for i in chosen {
                let Candidate { position, row } = &candidates[i as usize];
                if handles.positions.contains(position) {
                    let problem = format!("two handles stand at {position}");
                    return Err(Error::invalid(field, problem));
                }
                handles.positions.push(*position);
                handles.constraints.push(row.iter().copied());
            }
        }
        if handles.positions.is_empty() {
            return Err(Error::invalid("handles", "at least one is needed"));
        }
        Ok(handles)
    }
}

fn candidates(
    body: &Body,
    node_skinning: &Rows<SkinWeight>,
    region: &HandleRegion,
    field: &str,
) -> Result<Vec<Candidate>> {
    let layer = &body.layer;
    let bones = region
        .bones
        .iter()
        .map(|name| {
            let bone = body.skeleton.find(name).map(|b| b as u32);
            bone.ok_or_else(|| {
                Error::invalid(format!("{field}.bones"), format!("no bone {name:?}"))
            })
        })
        .collect::<Result<Vec<u32>>>()?;
    let on_bones = |row: &[SkinWeight]| {
        let heaviest = row.iter().max_by(|a, b| a.weight.total_cmp(&b.weight));
        bones.is_empty() || heaviest.is_some_and(|w| bones.contains(&w.bone))
    };
    let inside = |p: DVec3| {
        let [low, high] = region
            .within
            .unwrap_or([[f64::NEG_INFINITY; 3], [f64::INFINITY; 3]]);
        p.cmpge(low.into()).all() && p.cmple(high.into()).all()
    };
    // A row mostly on bone nodes cannot reach 1 without a large value at the others.
    let soft = |row: &[(u32, f64)]| {
        let free = row
            .iter()
            .filter(|e| layer.bone_of_node[e.0 as usize].is_none());
        free.map(|e| e.1).sum::<f64>() > 0.5
    };
    let chosen = |count: usize| -> Result<Vec<u32>> {
        if region.vertices.iter().any(|&v| v as usize >= count) {
            let problem = format!("names one that is not there: there are {count}");
            return Err(Error::invalid(format!("{field}.vertices"), problem));
        }
        Ok(if region.vertices.is_empty() {
            (0..count as u32).collect()
        } else {
            region.vertices.clone()
        })
    };
    let skin_vertex = |v: u32| {
        let row = layer.skin_embedding.row(v as usize);
        let position = body.skin.positions[v as usize];
        let fits = on_bones(body.skinning.row(v as usize)) && inside(position) && soft(row);
        fits.then(|| Candidate {
            position,
            row: row.to_vec(),
        })
    };
    let node = |n: u32| {
        let (position, row) = (layer.mesh.nodes[n as usize], vec![(n, 1.0)]);
        let fits = on_bones(node_skinning.row(n as usize)) && inside(position) && soft(&row);
        fits.then_some(Candidate { position, row })
    };
    match region.place {
        HandlePlace::Skin => {
            let vertices = chosen(body.skin.positions.len())?;
            Ok(vertices.into_iter().filter_map(skin_vertex).collect())
        }
        HandlePlace::Volume => {
            let tissue = nodes_in_tissue(body);
            let nodes = chosen(layer.mesh.nodes.len())?.into_iter();
            Ok(nodes
                .filter(|&n| tissue[n as usize])
                .filter_map(node)
                .collect())
        }
        HandlePlace::Points => region
            .points
            .iter()
            .map(|&p| point(body, p.into(), field))
            .collect(),
    }
}

/// Nodes with a tet around them that is all tissue: a lattice has nodes outside the skin.
fn nodes_in_tissue(body: &Body) -> Vec<bool> {
    let mut inside = vec![false; body.layer.mesh.nodes.len()];
    for (tet, fraction) in body.layer.mesh.tets.iter().zip(&body.layer.tissue_fraction) {
        if *fraction >= 1.0 {
            tet.iter().for_each(|&n| inside[n as usize] = true);
        }
    }
    inside
}

/// The candidate at `position`: its barycentric coordinates in the tet that holds it.
fn point(body: &Body, position: DVec3, field: &str) -> Result<Candidate> {
    let mesh = &body.layer.mesh;
    let depth = |t: usize| {
        mesh.barycentric(t, position)
            .into_iter()
            .fold(f64::INFINITY, f64::min)
    };
    let deepest = (0..mesh.tets.len())
        .map(|t| (t, depth(t)))
        .max_by(|a, b| a.1.total_cmp(&b.1).then(b.0.cmp(&a.0)));
    match deepest {
        Some((t, depth)) if depth >= -1e-9 => {
            let shares = mesh.barycentric(t, position);
            Ok(Candidate {
                position,
                row: mesh.tets[t].into_iter().zip(shares).collect(),
            })
        }
        _ => {
            let problem = format!("{position} lies outside the layer");
            Err(Error::invalid(format!("{field}.points"), problem))
        }
    }
}
