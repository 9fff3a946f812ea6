//! The places that handles of a region can take.

use super::handles::{HandleCandidates, HandleRegion};
use super::softness::{STIFF, Softness};
use crate::body::Body;
use crate::math::NearestPoint;
use glam::DVec3;
use supple::internal::math::Rows;
use supple::model::SkinWeight;
use supple::{Error, Result};

/// A place a handle can take.
pub(crate) struct Candidate {
    pub position: DVec3,
    /// Nodes and their shares.
    pub row: Vec<(u32, f64)>,
    /// How densely handles stand here, relative to other places; positive.
    pub weight: f64,
}

/// The candidates of `region`; `field` names it in errors.
pub(crate) fn candidates(
    body: &Body,
    node_skinning: &Rows<SkinWeight>,
    softness: &Softness,
    region: &HandleRegion,
    field: &str,
) -> Result<Vec<Candidate>> {
    let layer = &body.layer;
    let painted = (region.painted.as_ref())
        .map(|name| body.painted_map(name, &format!("{field}.painted")))
        .transpose()?;
    let bones = body
        .skeleton
        .named(&region.bones, &format!("{field}.bones"))?;
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
    let free = |row: &[(u32, f64)]| {
        let free = (row.iter()).filter(|e| layer.bone_of_node[e.0 as usize].is_none());
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
    let weight = |v: u32| {
        let s = softness.softness[v as usize];
        let soft = match region.soft {
            0.0 => 1.0,
            _ if s < STIFF => 0.0,
            power => s.powf(power) * softness.drawn.get(v as usize).unwrap_or(&1.0),
        };
        soft * painted.map_or(1.0, |map| map[v as usize].max(0.0))
    };
    let skin_vertex = |v: u32| {
        let row = layer.skin_embedding.row(v as usize);
        let (position, weight) = (body.skin.positions[v as usize], weight(v));
        let fits = on_bones(body.skinning.row(v as usize)) && inside(position) && free(row);
        (fits && weight > 0.0).then(|| Candidate {
            position,
            row: row.to_vec(),
            weight,
        })
    };
    match region.candidates {
        HandleCandidates::Skin => {
            let vertices = chosen(body.skin.positions.len())?;
            Ok(vertices.into_iter().filter_map(skin_vertex).collect())
        }
        HandleCandidates::Volume => {
            let tissue = nodes_in_tissue(body);
            let skin = NearestPoint::new(&body.skin.positions);
            let node = |n: u32| {
                let (position, row) = (layer.mesh.nodes[n as usize], vec![(n, 1.0)]);
                let fits = tissue[n as usize]
                    && on_bones(node_skinning.row(n as usize))
                    && inside(position)
                    && free(&row);
                // A node is as soft as the skin over it.
                let weight = match skin.nearest(position) {
                    Some((v, _)) if fits => weight(v),
                    _ => 0.0,
                };
                (weight > 0.0).then_some(Candidate {
                    position,
                    row,
                    weight,
                })
            };
            let nodes = chosen(layer.mesh.nodes.len())?.into_iter();
            Ok(nodes.filter_map(node).collect())
        }
        HandleCandidates::Points => region
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
                weight: 1.0,
            })
        }
        _ => {
            let problem = format!("{position} lies outside the layer");
            Err(Error::invalid(format!("{field}.points"), problem))
        }
    }
}
