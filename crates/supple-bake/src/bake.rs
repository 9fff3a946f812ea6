//! The bake itself, phase after phase.

use super::attached::{followed, with_attachments};
use super::contact_stiffness::contact_stiffness;
use super::interior::InteriorField;
use super::local_tissue::local_tissue;
use super::pose_extension::pose_extension;
use super::report::{
    AttachmentReport, BakeCost, BakeReport, BasisReport, HandleReport, peak_memory,
};
use super::{Recipe, set_limits};
use crate::basis::{BiharmonicSystem, basis_at_tets, basis_on_skin, skinning_at_tets};
use crate::body::Body;
use crate::bones::{BoneLoads, SpringReport, bone_masses, drop_bones, left_to_tissue, retain};
use crate::cubature::{Cubature, Tissue};
use crate::depth::{depth_per_bone, thin_places};
use crate::fine::{Coarse, bake_fine};
use crate::handles::{HandleCandidates, Handles, Softness, automatic};
use crate::mesh::{MeshQuality, MeshReport};
use crate::softness::Regions;
use crate::sway::SwayProfile;
use std::sync::Arc;
use supple::internal::math::{Rows, Stopwatch};
use supple::model::{Avatar, PointSet, SoftLayer, SpringBones, TetMesh};
use supple::{Error, Result};

/// The phases of a bake, in order.
pub const PHASES: [&str; 7] = [
    "mesh",
    "skin weights",
    "basis",
    "cubature",
    "points",
    "bones",
    "fine handles",
];

/// A basis that misses affine functions by more than this was not determined by its constraints.
const LINEAR_PRECISION: f64 = 1e-6;

/// Called at the start of each phase with its index in [`PHASES`], and once more with their number.
pub type Progress<'a> = dyn FnMut(usize) + 'a;

/// Bakes a body: the layer's mesh where it has none, basis at the handles, cubature, skin weights and blend shapes inside, bone masses.
/// The same body and recipe give the same avatar, bit for bit, whatever the number of threads.
///
/// # Errors
/// [`Error::Invalid`] where the body or the recipe is not usable; [`Error::Solve`] where the layer hangs
/// together too loosely, or handles stand too close for its mesh.
pub fn bake(
    body: &Body,
    recipe: &Recipe,
    progress: &mut Progress<'_>,
) -> Result<(Avatar, BakeReport)> {
    bake_phases(body, recipe, progress).map_err(|e| with_tissue(body, e))
}

/// `error` with the parts that were chosen as tissue, where some were not: the choice may be what is wrong.
fn with_tissue(body: &Body, error: Error) -> Error {
    let parts = body.tissue_parts();
    if body.attachments.is_empty() || parts.is_empty() {
        return error;
    }
    let told = |problem: String| format!("{problem} (tissue is {})", parts.join(", "));
    match error {
        Error::Invalid { field, problem } if field.inside("recipe").is_none() => {
            let problem = told(problem);
            Error::Invalid { field, problem }
        }
        Error::Solve { system, problem } => {
            let problem = told(problem);
            Error::Solve { system, problem }
        }
        other => other,
    }
}

fn bake_phases(
    body: &Body,
    recipe: &Recipe,
    progress: &mut Progress<'_>,
) -> Result<(Avatar, BakeReport)> {
    let of_recipe = |e: Error| e.within("recipe");
    recipe.validate().map_err(of_recipe)?;
    let mut clock = Clock::new(progress);

    clock.start(0);
    let mut meshed;
    let mut mesh_report = MeshReport::default();
    let body = if body.layer.mesh.tets.is_empty() {
        meshed = body.clone();
        mesh_report = recipe.mesher.mesh(&mut meshed)?;
        &meshed
    } else {
        body
    };
    body.validate()?;
    let layer = &body.layer;
    let mesh = &layer.mesh;
    check_nodes(mesh)?;
    let quality = MeshQuality::of(mesh);
    let tissue = Tissue {
        mesh,
        fraction: &layer.tissue_fraction,
    };
    let areas = body.skin.vertex_areas();

    clock.start(1);
    let field = InteriorField::new(mesh, &layer.bone_of_node, &layer.skin_embedding, &areas)?;
    let node_skinning =
        field.skin_weights(&body.skinning, body.skeleton.len(), recipe.bones_per_point)?;

    clock.start(2);
    let mut softness = Softness::of(body);
    if recipe.handles.is_empty() {
        softness.drawn = automatic::drawn(body);
    }
    let automatic = [automatic::handle_region(&softness)];
    let regions = if recipe.handles.is_empty() {
        &automatic[..]
    } else {
        &recipe.handles
    };
    let handles = Handles::place(body, &node_skinning, &softness, regions)?;
    let fixed: Vec<bool> = layer.bone_of_node.iter().map(Option::is_some).collect();
    let system = BiharmonicSystem::new(mesh, recipe.basis_energy, &fixed, &handles.constraints)?;
    let columns = system.basis();
    let linear_precision = system.linear_precision(mesh, &columns);
    let loose_tets = system.loose_tets();
    drop(system);
    if linear_precision.is_nan() || linear_precision > LINEAR_PRECISION {
        let problem = format!(
            "misses affine functions by {linear_precision:.1e}: too few handles and bone nodes, handles too \
             close together, or a layer in parts"
        );
        let system = "biharmonic basis";
        return Err(Error::Solve { system, problem });
    }
    let on_skin = (regions.iter()).all(|region| region.candidates == HandleCandidates::Skin);
    let keeps_sway = recipe.truncation.enabled && recipe.truncation.keep_sway.unwrap_or(on_skin);
    let sway = match keeps_sway {
        true => Some(SwayProfile::new(layer, &handles.constraints, &columns)?),
        false => None,
    };
    let nodal_volumes = tissue.nodal_volumes();
    let (basis, truncation_cost) =
        (recipe.truncation).rows(&columns, &nodal_volumes, sway.as_ref());
    drop(columns);

    clock.start(3);
    let (base, selected) = local_tissue(body, &field, &node_skinning, recipe)?;
    let mut soft = Regions::new(body, recipe, &softness, &node_skinning, &selected)?;
    let layer_tissue = soft.on(&base);
    let cubature = if recipe.cubature.all_tets {
        Cubature::all_tets(tissue)
    } else {
        let count = recipe.points_for(handles.positions.len());
        let stiffness: Vec<f64> = layer_tissue.iter().map(|t| t.stiffness).collect();
        Cubature::sampled(tissue, recipe.cubature.method, count, &basis, &stiffness)?
    };

    clock.start(4);
    let points = PointSet {
        position: (cubature.tets.iter())
            .map(|&t| mesh.centroid(t as usize))
            .collect(),
        measure: cubature.weights,
        skinning: skinning_at_tets(mesh, &node_skinning, &cubature.tets, recipe.bones_per_point),
        basis: basis_at_tets(mesh, &basis, &cubature.tets),
        pose_blend: field.pose_blend(&body.pose_blend, mesh, &cubature.tets),
    };
    // A study in all tets has a solve for each to pay for, and no host.
    let extension = match recipe.cubature.all_tets {
        true => Rows::default(),
        false => pose_extension(&field, mesh, &cubature.tets),
    };
    let skin = PointSet {
        position: body.skin.positions.clone(),
        measure: areas.clone(),
        skinning: body.skinning.clone(),
        basis: basis_on_skin(&layer.skin_embedding, &basis),
        pose_blend: body.pose_blend.clone(),
    };
    let attached = followed(body);
    let (skin, triangles) = with_attachments(body, skin, &attached);

    clock.start(5);
    let (masses, mut bones) = bone_masses(body, &node_skinning, recipe.density);
    let loads = BoneLoads::of(body);

    let material = soft.material;
    let mut skeleton = body.skeleton.clone();
    set_limits(&mut skeleton, &recipe.limits).map_err(of_recipe)?;
    let mut avatar = Avatar {
        name: body.name.clone(),
        skeleton,
        joints: body.joints.clone(),
        up: body.up,
        bone_masses: masses,
        springs: match recipe.springs {
            true => body.springs.clone(),
            false => SpringBones::default(),
        },
        handles: handles.positions,
        cubature: points,
        skin,
        triangles,
        contact_stiffness: Vec::new(),
        attached,
        pose_extension: extension,
        render_meshes: body.render_meshes.clone(),
        appearance: body.appearance.clone(),
        material,
        tissue: (cubature.tets.iter())
            .map(|&t| layer_tissue[t as usize])
            .collect(),
        density: recipe.density,
        captured_under_gravity: recipe.captured_under_gravity,
        fine: Arc::default(),
        layer: SoftLayer {
            mesh: mesh.clone(),
            tissue_fraction: layer.tissue_fraction.clone(),
            bone_of_node: layer.bone_of_node.clone(),
            skinning: node_skinning,
            basis,
            skin_embedding: layer.skin_embedding.clone(),
            tissue: layer_tissue,
        },
        bodies: Vec::new(),
        body_slots: 0,
    };
    soft.calibrate(&mut avatar, &cubature.tets, &base)?;
    if recipe.contact_by_tissue {
        avatar.contact_stiffness = contact_stiffness(&avatar, &softness.depth);
    }
    let mut handle_report = HandleReport::new(
        body,
        &avatar.handles,
        handles.per_region,
        recipe.handles.is_empty(),
    );
    drop_bones(&mut avatar, &loads.anything)?;
    let notes = left_to_tissue(&mut avatar);
    retain(&mut bones.masses, &loads.anything);
    retain(&mut handle_report.per_bone, &loads.anything);
    let mut depth_per_bone = depth_per_bone(body, &softness.depth);
    retain(&mut depth_per_bone, &loads.anything);

    clock.start(6);
    let coarse = Coarse {
        constraints: &handles.constraints,
        tets: &cubature.tets,
    };
    let fine = (recipe.fine_handles.as_ref())
        .map(|asked| bake_fine(body, &avatar, &softness, recipe, asked, coarse))
        .transpose()?;
    let fine_report = fine.map(|(fine, report)| {
        avatar.fine = Arc::new(fine);
        report
    });
    let seconds = clock.finish();
    avatar.validate()?;
    mesh_report.quality = quality;
    let (low, high) = body.skin.bounds();
    let report = BakeReport {
        name: avatar.name.clone(),
        extent: (high - low).to_array(),
        bone_names: avatar.skeleton.names.clone(),
        skin_vertices: body.skin.positions.len(),
        skin_triangles: body.skin.triangles.len(),
        attachments: AttachmentReport::of(body, &avatar.attached),
        mesh: mesh_report,
        free_nodes: fixed.iter().filter(|f| !**f).count(),
        deep: softness.deep,
        depth_per_bone,
        thin_places: thin_places(body, &softness.depth, softness.deep),
        handles: handle_report,
        basis: BasisReport {
            linear_precision,
            loose_tets,
            truncation_cost,
            handles_per_vertex: row_lengths(&avatar.skin.basis),
            handles_per_point: row_lengths(&avatar.cubature.basis),
        },
        cubature: cubature.report,
        fine: fine_report,
        material,
        material_chosen: recipe.material.is_none(),
        softness: soft.reports(),
        stiffness: stiffness_spread(&avatar),
        tissue_mass: avatar.tissue_mass(),
        bones,
        springs: SpringReport::of(&avatar.springs),
        notes: notes.into_iter().collect(),
        cost: BakeCost {
            seconds,
            peak_memory: peak_memory(),
        },
    };
    Ok((avatar, report))
}

/// Least, mean over the tissue's volume and greatest factor on the stiffness.
fn stiffness_spread(avatar: &Avatar) -> [f64; 3] {
    let values = || avatar.tissue.iter().map(|t| t.stiffness);
    let weights = &avatar.cubature.measure;
    let sum: f64 = values().zip(weights).map(|(s, w)| s * w).sum();
    let (least, greatest) = values().fold((f64::INFINITY, 0.0_f64), |(low, high), s| {
        (low.min(s), high.max(s))
    });
    [least, sum / weights.iter().sum::<f64>(), greatest]
}

/// A node of no tet would be a handle without stiffness.
fn check_nodes(mesh: &TetMesh) -> Result<()> {
    let mut used = vec![false; mesh.nodes.len()];
    (mesh.tets.iter().flatten()).for_each(|&n| used[n as usize] = true);
    match used.iter().position(|u| !u) {
        None if !mesh.tets.is_empty() => Ok(()),
        None => Err(Error::invalid(
            "layer.mesh",
            "is empty: mesh the layer first",
        )),
        Some(n) => {
            let problem = format!("node {n} belongs to no tet: remove it");
            Err(Error::invalid("layer.mesh", problem))
        }
    }
}

/// Mean length of the rows that hold anything, and the longest.
pub(crate) fn row_lengths<T>(rows: &Rows<T>) -> (f64, usize) {
    let filled = rows.iter().filter(|r| !r.is_empty()).count();
    (
        rows.entries().len() as f64 / filled.max(1) as f64,
        rows.longest(),
    )
}

/// Tells the phases and times them.
struct Clock<'a, 'b> {
    progress: &'a mut Progress<'b>,
    phase: usize,
    since: Stopwatch,
    seconds: Vec<(String, f64)>,
}

impl<'a, 'b> Clock<'a, 'b> {
    fn new(progress: &'a mut Progress<'b>) -> Self {
        Self {
            progress,
            phase: 0,
            since: Stopwatch::start(),
            seconds: Vec::new(),
        }
    }

    fn start(&mut self, phase: usize) {
        if phase > 0 {
            self.note();
        }
        self.phase = phase;
        self.since = Stopwatch::start();
        (self.progress)(phase);
    }

    fn note(&mut self) {
        let seconds = self.since.ms() / 1e3;
        self.seconds.push((PHASES[self.phase].into(), seconds));
    }

    fn finish(mut self) -> Vec<(String, f64)> {
        self.note();
        (self.progress)(PHASES.len());
        self.seconds
    }
}
