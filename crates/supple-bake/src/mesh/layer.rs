//! A body's layer from one of the meshers, with its report.

use super::bone_axes::{axis_surfaces, bone_axes, leading_bones, median};
use super::lattice::{LatticeSize, lattice_in};
use super::prism_shell::prism_shell;
use super::sound_skin::SoundSkin;
use super::thickness::{ShellOptions, thickness};
use super::{MeshQuality, MeshReport};
use crate::body::{Body, LayerMesh};
use crate::math::TriangleTree;
use supple::internal::math::par_map;
use supple::{Error, Result};

/// A lattice between the skin and the bones of `body`, derived where none are given.
pub(crate) fn mesh_lattice(body: &mut Body, size: LatticeSize, why: &str) -> Result<MeshReport> {
    let (sound, leading) = look_through(body)?;
    let mut derived_bones = 0;
    if body.bone_surfaces.iter().all(|b| b.triangles.is_empty()) {
        let axes = bone_axes(&body.skeleton, &sound, &body.skinning);
        body.bone_surfaces = axis_surfaces(&axes, body.skeleton.len());
        let derived = body
            .bone_surfaces
            .iter()
            .filter(|b| !b.triangles.is_empty());
        derived_bones = derived.count();
        if derived_bones == 0 {
            let problem = "no bone lies inside the skin that follows it: give bone surfaces, or mesh a prism shell";
            return Err(Error::invalid("skeleton", problem));
        }
    }
    let ends: Vec<u32> = sound
        .rims
        .iter()
        .map(|rim| most_common(rim, &leading))
        .collect();
    body.layer = lattice_in(&sound, &ends, &body.bone_surfaces, size)?;
    let bones = (body.bone_surfaces.iter())
        .flat_map(|bone| (0..bone.triangles.len()).map(|t| bone.corners(t)));
    let bones = TriangleTree::new(bones);
    let depth = par_map(body.skin.positions.len(), |v| {
        match body.layer.skin_embedding.row(v) {
            [] => 0.0,
            _ => bones.distance(body.skin.positions[v]),
        }
    });
    let mut report = report(body, &sound, &depth);
    report.mesher = format!("lattice, {why}");
    report.derived_bones = derived_bones;
    Ok(report)
}

/// A prism shell under the skin of `body`.
pub(crate) fn mesh_shell(body: &mut Body, options: &ShellOptions, why: &str) -> Result<MeshReport> {
    options.validate(body)?;
    let (sound, leading) = look_through(body)?;
    let axes = bone_axes(&body.skeleton, &sound, &body.skinning);
    let mut depth = thickness(body, &sound, &axes, options);
    let layers = options.layers_for(sound.skin_triangles);
    body.layer = prism_shell(&sound, &leading, &mut depth, layers)?;
    if body.layer.mesh.tets.is_empty() {
        let problem = "leaves no room for a layer: it is folded or flat everywhere";
        return Err(Error::invalid("skin", problem));
    }
    let mut report = report(body, &sound, &depth);
    report.mesher = format!("prism shell of {layers} layers, {why}");
    Ok(report)
}

/// The skin, made sound and turned outward in the body too, and the bone that leads each vertex.
fn look_through(body: &mut Body) -> Result<(SoundSkin, Vec<u32>)> {
    body.skeleton.validate()?;
    let sound = SoundSkin::new(&body.skin)?;
    body.skinning
        .validate("skinning", body.skin.positions.len())?;
    let bones = body.skeleton.len();
    let leading = leading_bones(&body.skinning)
        .into_iter()
        .enumerate()
        .map(|(v, bone)| match bone {
            Some(bone) if (bone as usize) < bones => Ok(bone),
            _ => Err(Error::invalid(
                "skinning",
                format!("vertex {v} has no bone"),
            )),
        })
        .collect::<Result<Vec<u32>>>()?;
    body.skin.triangles.clone_from(&sound.oriented);
    Ok((sound, leading))
}

/// The bone that leads most of `vertices`.
fn most_common(vertices: &[u32], leading: &[u32]) -> u32 {
    let mut bones: Vec<u32> = vertices.iter().map(|&v| leading[v as usize]).collect();
    bones.sort_unstable();
    let runs = bones.chunk_by(|a, b| a == b);
    // The first of equals.
    runs.rev()
        .max_by_key(|run| run.len())
        .map_or(0, |run| run[0])
}

fn report(body: &Body, sound: &SoundSkin, depth: &[f64]) -> MeshReport {
    let LayerMesh {
        mesh,
        skin_embedding,
        ..
    } = &body.layer;
    let covered: Vec<f64> = (depth.iter().zip(skin_embedding.iter()))
        .filter(|(depth, row)| !row.is_empty() && **depth > 0.0)
        .map(|(depth, _)| *depth)
        .collect();
    let skin_volume = sound.surface.volume();
    let tissue_volume = body.layer.tissue_volume();
    MeshReport {
        skin: sound.full_report(),
        quality: MeshQuality::of(mesh),
        skin_volume,
        tissue_volume,
        core_volume: skin_volume - tissue_volume,
        thickness: [
            covered.iter().copied().reduce(f64::min).unwrap_or(0.0),
            median(&covered),
            covered.iter().copied().fold(0.0, f64::max),
        ],
        bare_vertices: depth.len() - covered.len(),
        ..MeshReport::default()
    }
}
