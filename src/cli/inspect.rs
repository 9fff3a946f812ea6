//! `supple inspect`.

use super::{print_json, print_table};
use crate::Result;
use crate::bake::read_avatar;
use crate::model::Avatar;
use serde::Serialize;
use std::path::PathBuf;

/// Arguments of `supple inspect`.
#[derive(clap::Args)]
pub struct Arguments {
    /// A baked file.
    file: PathBuf,
    /// JSON in place of a table.
    #[arg(long)]
    json: bool,
}

/// What a baked file holds.
#[derive(Serialize)]
struct Contents {
    name: String,
    bones: usize,
    dofs: usize,
    handles: usize,
    cubature_points: usize,
    vertices: usize,
    triangles: usize,
    nodes: usize,
    tets: usize,
    tissue_volume_ml: f64,
    tissue_mass_kg: f64,
    bone_mass_kg: f64,
    density: f64,
    damping_time: f64,
    captured_under_gravity: bool,
    pose_features: usize,
    most_bones_of_a_vertex: usize,
    most_handles_of_a_vertex: usize,
    most_handles_of_a_point: usize,
    material: crate::material::Material,
}

impl Contents {
    fn new(avatar: &Avatar) -> Self {
        Self {
            name: avatar.name.clone(),
            bones: avatar.skeleton.len(),
            dofs: avatar.space().dofs(),
            handles: avatar.handles.len(),
            cubature_points: avatar.cubature.len(),
            vertices: avatar.skin.len(),
            triangles: avatar.triangles.len(),
            nodes: avatar.layer.mesh.nodes.len(),
            tets: avatar.layer.mesh.tets.len(),
            tissue_volume_ml: 1e6 * avatar.cubature.measure.iter().sum::<f64>(),
            tissue_mass_kg: avatar.tissue_mass(),
            bone_mass_kg: avatar
                .bone_masses
                .iter()
                .map(|b| b.second_moment[3][3])
                .sum(),
            density: avatar.density,
            damping_time: avatar.damping_time,
            captured_under_gravity: avatar.captured_under_gravity,
            pose_features: avatar.skin.pose_blend.features,
            most_bones_of_a_vertex: avatar.skin.skinning.longest(),
            most_handles_of_a_vertex: avatar.skin.basis.longest(),
            most_handles_of_a_point: avatar.cubature.basis.longest(),
            material: avatar.material,
        }
    }
}

impl Arguments {
    /// Reads and tells.
    pub fn run(self) -> Result<()> {
        let c = Contents::new(&read_avatar(&self.file)?);
        if self.json {
            return print_json(&c);
        }
        print_table([
            ("name", c.name),
            ("bones", c.bones.to_string()),
            ("handles", c.handles.to_string()),
            ("degrees of freedom", c.dofs.to_string()),
            ("cubature points", c.cubature_points.to_string()),
            (
                "skin",
                format!("{} vertices, {} triangles", c.vertices, c.triangles),
            ),
            ("soft layer", format!("{} nodes, {} tets", c.nodes, c.tets)),
            (
                "tissue",
                format!("{:.1} ml, {:.4} kg", c.tissue_volume_ml, c.tissue_mass_kg),
            ),
            ("bones' mass", format!("{:.4} kg", c.bone_mass_kg)),
            ("material", c.material.to_string()),
            ("density", format!("{} kg/m³", c.density)),
            ("damping time", format!("{} s", c.damping_time)),
            (
                "captured under gravity",
                c.captured_under_gravity.to_string(),
            ),
            ("pose features", c.pose_features.to_string()),
            (
                "bones of a vertex",
                format!("at most {}", c.most_bones_of_a_vertex),
            ),
            (
                "handles of a vertex",
                format!("at most {}", c.most_handles_of_a_vertex),
            ),
            (
                "handles of a point",
                format!("at most {}", c.most_handles_of_a_point),
            ),
        ]);
        Ok(())
    }
}
