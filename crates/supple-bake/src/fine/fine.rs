//! The bake of fine handles: places, columns on the skin, blocks below it, cells.

use super::cells::Cells;
use super::places::{Places, places};
use super::recipe::{FineExtension, FineRecipe};
use crate::bake::row_lengths;
use crate::basis::{
    Constraints, ManyColumns, basis_at_tets, basis_on_skin, rows_through, skinning_at_tets,
};
use crate::body::Body;
use crate::cubature::Tissue;
use crate::handles::Softness;
use crate::recipe::Recipe;
use crate::subspace::{ElasticExtension, by_node};
use glam::{DMat3, DVec3};
use serde::{Deserialize, Serialize};
use supple::Result;
use supple::internal::math::Rows;
use supple::model::{Avatar, BasisEntry, FineHandles, PointSet, PoseBlend, TetMesh};

/// What a bake of fine handles did.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FineReport {
    /// Handles.
    pub count: usize,
    /// No soft skin is farther from a handle, m.
    pub spacing: f64,
    /// Cubature points besides the coarse ones.
    pub points: usize,
    /// Cells that a handle wakes: mean and most.
    pub cells_per_handle: (f64, usize),
    /// Fine handles of a skin vertex that has any: mean and most.
    pub handles_per_vertex: (f64, usize),
    /// Fine handles of a node that has any: mean and most.
    pub handles_per_node: (f64, usize),
    /// What they take in memory, about, bytes.
    pub bytes: usize,
}

/// What fine handles continue.
#[derive(Clone, Copy)]
pub(crate) struct Coarse<'a> {
    /// The coarse handles' conditions.
    pub constraints: &'a Constraints,
    /// The tets of the coarse cubature points.
    pub tets: &'a [u32],
}

/// The fine handles of `avatar`, which is whole but for them; `body` is what it was baked from.
///
/// # Errors
/// [`supple::Error::Invalid`] where no fine handle finds a place; [`supple::Error::Solve`] where handles stand too close
/// for the mesh.
pub(crate) fn bake_fine(
    body: &Body,
    avatar: &Avatar,
    softness: &Softness,
    recipe: &Recipe,
    asked: &FineRecipe,
    coarse: Coarse<'_>,
) -> Result<(FineHandles, FineReport)> {
    let layer = &avatar.layer;
    let mesh = &layer.mesh;
    let Places {
        positions,
        constraints,
        spacing,
    } = places(body, &layer.skinning, softness, &avatar.handles, asked)?;
    let columns = skin_columns(avatar, recipe, coarse.constraints, &constraints)?;
    let scalar = scalar_rows(mesh.nodes.len(), &columns);
    let skin = basis_on_skin(&layer.skin_embedding, &scalar);
    let nodes = match asked.extension {
        FineExtension::Biharmonic => {
            scalar.map(|&(h, u)| (h, DMat3::from_diagonal(DVec3::splat(u))))
        }
        FineExtension::Elastic => {
            let on_skin = by_handle(positions.len(), &skin);
            let blocks = ElasticExtension::new(avatar)?.columns(&on_skin, asked.blocks());
            by_node(mesh.nodes.len(), &blocks)
        }
    };
    let tissue = Tissue {
        mesh,
        fraction: &layer.tissue_fraction,
    };
    let points = (asked.points_per_handle * positions.len() as f64).round() as usize;
    let cells = Cells::new(tissue, coarse.tets, &nodes, positions.len(), points);

    let tets = &cells.tets;
    let followers = rows_through(&avatar.attached, &skin);
    let mut on_skin = skin;
    (followers.iter()).for_each(|row| on_skin.push(row.iter().copied()));
    let all = coarse.tets.iter().chain(tets);
    let fine = FineHandles {
        slots: 0,
        spacing,
        skin: on_skin.map(|u| (u.handle, u.value as f32)),
        nodes: nodes.map(|(h, n)| (*h, n.to_cols_array().map(|e| e as f32))),
        points: PointSet {
            position: tets.iter().map(|&t| mesh.centroid(t as usize)).collect(),
            measure: cells.measure,
            skinning: skinning_at_tets(mesh, &layer.skinning, tets, recipe.bones_per_point),
            basis: basis_at_tets(mesh, &layer.basis, tets),
            pose_blend: PoseBlend::default(),
        },
        tissue: match layer.tissue.is_empty() {
            true => Vec::new(),
            false => tets.iter().map(|&t| layer.tissue[t as usize]).collect(),
        },
        corners: all.clone().map(|&t| mesh.tets[t as usize]).collect(),
        slopes: all.map(|&t| slopes(mesh, t as usize)).collect(),
        positions,
        cells: cells.of_handle,
        own_measure: cells.own_measure,
        cell_of_point: cells.cell_of_point,
    };
    let report = FineReport {
        count: fine.len(),
        spacing,
        points: fine.points.len(),
        cells_per_handle: row_lengths(&fine.cells),
        handles_per_vertex: row_lengths(&fine.skin),
        handles_per_node: row_lengths(&fine.nodes),
        bytes: fine.bytes(),
    };
    Ok((fine, report))
}

/// The columns of the `fine` handles among all, at the nodes, truncated as the coarse ones are.
fn skin_columns(
    avatar: &Avatar,
    recipe: &Recipe,
    coarse: &Constraints,
    fine: &Constraints,
) -> Result<Vec<Vec<(u32, f64)>>> {
    let layer = &avatar.layer;
    let rows = coarse.iter().chain(fine.iter());
    let all: Constraints = rows.map(|row| row.iter().copied()).collect();
    let fixed: Vec<bool> = layer.bone_of_node.iter().map(Option::is_some).collect();
    let system = ManyColumns::new(&layer.mesh, recipe.basis_energy, &fixed, &all)?;
    Ok(system.truncated(coarse.len()..all.len(), &recipe.truncation))
}

/// (column, u) of each node.
fn scalar_rows(nodes: usize, columns: &[Vec<(u32, f64)>]) -> Rows<(u32, f64)> {
    let mut rows = vec![Vec::new(); nodes];
    for (h, column) in (0..).zip(columns) {
        (column.iter()).for_each(|&(node, u)| rows[node as usize].push((h, u)));
    }
    rows.into_iter().collect()
}

/// (vertex, U) of each handle.
fn by_handle(handles: usize, skin: &Rows<BasisEntry>) -> Vec<Vec<(u32, f64)>> {
    let mut columns = vec![Vec::new(); handles];
    for (v, row) in (0..).zip(skin.iter()) {
        (row.iter()).for_each(|u| columns[u.handle as usize].push((v, u.value)));
    }
    columns
}

/// ∇λ of the first three corners, 1/m.
fn slopes(mesh: &TetMesh, t: usize) -> [[f32; 3]; 3] {
    let [a, b, c, _] = mesh.barycentric_gradients(t);
    [a, b, c].map(|g| g.as_vec3().to_array())
}
