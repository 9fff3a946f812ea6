//! `supple inspect`.

use super::animations::MotionPreview;
use super::bake_report::print_bake_report;
use super::preview::Preview;
use super::terminal::{print, print_json, print_table};
use serde::Serialize;
use std::path::PathBuf;
use supple::material::LocalTissue;
use supple::model::{Avatar, Joint, JointBone, UpAxis};
use supple::{Error, Result};
use supple_bake::{BakeReport, Baked, SpringReport, read_baked};
use supple_files::{CharacterFormat, FileKind, is_gltf_motion};

/// Arguments of `supple inspect`.
#[derive(clap::Args)]
pub struct Arguments {
    /// A baked file, a character file (.npz, .pkl, .glb, .gltf, .vrm, .obj, tets), or a glTF file of motions (.vrma too).
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
    /// The axis that points up in the reference shape.
    up: UpAxis,
    /// In the order in which a host gives their matrices.
    joints: Vec<ContentsJoint>,
    /// Number of joints of each of the file's skins; 0 where the scene does not show it.
    joints_of_skins: Vec<usize>,
    dofs: usize,
    handles: usize,
    cubature_points: usize,
    vertices: usize,
    attached_vertices: usize,
    springs: SpringReport,
    triangles: usize,
    nodes: usize,
    tets: usize,
    tissue_volume_ml: f64,
    tissue_mass_kg: f64,
    bone_mass_kg: f64,
    density: f64,
    /// Stiffness-proportional damping β, s: least and greatest over the cubature points.
    damping_time: [f64; 2],
    /// Share of muscle: least and greatest over the cubature points.
    muscle: [f64; 2],
    captured_under_gravity: bool,
    pose_features: usize,
    most_bones_of_a_vertex: usize,
    most_handles_of_a_vertex: usize,
    most_handles_of_a_point: usize,
    material: supple::material::Material,
    /// Factor on its stiffness: least and greatest over the cubature points.
    stiffness: [f64; 2],
    /// What the bake did.
    bake: Option<BakeReport>,
}

/// A node of the character's file, as a host knows it.
#[derive(Serialize)]
struct ContentsJoint {
    name: String,
    /// The bone that it is or rides on.
    bone: String,
    rides: bool,
}

impl ContentsJoint {
    fn of(avatar: &Avatar, joint: &Joint) -> Self {
        let bone = avatar.skeleton.names.get(joint.bone.bone());
        Self {
            name: joint.name.clone(),
            bone: bone.cloned().unwrap_or_default(),
            rides: matches!(joint.bone, JointBone::RidesOn(_)),
        }
    }
}

impl Contents {
    fn new(avatar: &Avatar, bake: Option<BakeReport>) -> Self {
        Self {
            name: avatar.name.clone(),
            bones: avatar.skeleton.len(),
            up: avatar.up,
            joints: (avatar.joints.joints().iter())
                .map(|joint| ContentsJoint::of(avatar, joint))
                .collect(),
            joints_of_skins: (avatar.joints.skins().iter())
                .map(|skin| skin.joints.len())
                .collect(),
            dofs: avatar.space().dofs(),
            handles: avatar.handles.len(),
            cubature_points: avatar.cubature.len(),
            vertices: avatar.tissue_vertices(),
            attached_vertices: avatar.attached.len(),
            springs: SpringReport::of(&avatar.springs),
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
            damping_time: range(avatar, |local| local.damping_time),
            muscle: range(avatar, |local| local.muscle),
            captured_under_gravity: avatar.captured_under_gravity,
            pose_features: avatar.skin.pose_blend.features,
            most_bones_of_a_vertex: avatar.skin.skinning.longest(),
            most_handles_of_a_vertex: avatar.skin.basis.longest(),
            most_handles_of_a_point: avatar.cubature.basis.longest(),
            material: avatar.material,
            stiffness: range(avatar, |local| local.stiffness),
            bake,
        }
    }

    /// What the bake's report does not say, and all of it where there is none.
    fn print(&self) {
        if self.bake.is_none() {
            print_table([
                ("name", self.name.clone()),
                ("bones", self.bones.to_string()),
                ("handles", self.handles.to_string()),
                ("cubature points", self.cubature_points.to_string()),
                (
                    "skin",
                    format!("{} vertices, {} triangles", self.vertices, self.triangles),
                ),
                ("attached", format!("{} vertices", self.attached_vertices)),
                ("spring bones", self.springs.to_string()),
                (
                    "soft layer",
                    format!("{} nodes, {} tets", self.nodes, self.tets),
                ),
                (
                    "tissue",
                    format!(
                        "{:.1} ml, {:.4} kg",
                        self.tissue_volume_ml, self.tissue_mass_kg
                    ),
                ),
                ("bones' mass", format!("{:.4} kg", self.bone_mass_kg)),
                ("material", self.material.to_string()),
            ]);
        }
        print_table([
            ("degrees of freedom", self.dofs.to_string()),
            ("density", format!("{} kg/m³", self.density)),
            (
                "damping time",
                format!("{} to {} s", self.damping_time[0], self.damping_time[1]),
            ),
            (
                "muscle",
                format!(
                    "{:.2} to {:.2} of the tissue",
                    self.muscle[0], self.muscle[1]
                ),
            ),
            (
                "captured under gravity",
                self.captured_under_gravity.to_string(),
            ),
            ("pose features", self.pose_features.to_string()),
            (
                "bones of a vertex",
                format!("at most {}", self.most_bones_of_a_vertex),
            ),
            (
                "handles of a vertex",
                format!("at most {}", self.most_handles_of_a_vertex),
            ),
            (
                "handles of a point",
                format!("at most {}", self.most_handles_of_a_point),
            ),
            (
                "stiffness",
                format!("× {:.2} to {:.2}", self.stiffness[0], self.stiffness[1]),
            ),
            ("up", format!("{:?}", self.up).to_lowercase()),
            (
                "joints of the file's skins",
                format!("{:?}", self.joints_of_skins),
            ),
        ]);
        print("joints, in the order of a host's matrices:");
        for (j, joint) in self.joints.iter().enumerate() {
            let what = if joint.rides { "rides on" } else { "is" };
            print(format_args!(
                "{j:>4}  {:<24} {what} {}",
                joint.name, joint.bone
            ));
        }
    }
}

/// Least and greatest of a value over the cubature points; zeros where there are none.
fn range(avatar: &Avatar, of: impl Fn(&LocalTissue) -> f64) -> [f64; 2] {
    let values = (0..avatar.cubature.len()).map(|i| of(&avatar.tissue_at(i).local));
    let range = values.map(|v| [v, v]);
    let wider = |[low, high]: [f64; 2], [a, b]: [f64; 2]| [low.min(a), high.max(b)];
    range.reduce(wider).unwrap_or_default()
}

impl Arguments {
    /// Reads and tells.
    pub fn run(self) -> Result<()> {
        match FileKind::of(&self.file)? {
            FileKind::Baked => {
                let Baked { avatar, report } = read_baked(&self.file)?;
                let contents = Contents::new(&avatar, report);
                if self.json {
                    return print_json(&contents);
                }
                if let Some(report) = &contents.bake {
                    print_bake_report(report);
                }
                contents.print();
            }
            FileKind::Character(CharacterFormat::Gltf) if is_gltf_motion(&self.file)? => {
                let preview = MotionPreview::read(&self.file)?;
                if self.json {
                    return print_json(&preview);
                }
                preview.print();
                let file = self.file.display();
                print(format_args!(
                    "\na motion and no character: supple motion {file} --avatar CHARACTER"
                ));
            }
            FileKind::Character(_) => {
                let preview = Preview::read(&self.file)?;
                if self.json {
                    return print_json(&preview);
                }
                preview.print();
                let file = self.file.display();
                print(format_args!("\nnot baked yet: supple bake {file}"));
            }
            FileKind::Toml => {
                let problem = "is a recipe or a scene, not a baked avatar: `supple bake` it first";
                return Err(Error::format(&self.file, "format", problem));
            }
        }
        Ok(())
    }
}
