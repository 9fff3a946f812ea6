//! `supple sample`.

use super::make_folder;
use super::terminal::print;
use std::path::{Path, PathBuf};
use supple::{Error, Result};
use supple_files::TetMeshFile;
use supple_files::{pose_line, write_bvh, write_obj, write_painted, write_smpl, write_tet_mesh};
use supple_samples::{Limb, body, hand, hand::grasp, walk};
use supple_samples::{PALM, SOFT, Sample, map_of};
use supple_scene::AvatarSource;

#[derive(Clone, Copy, Debug, clap::ValueEnum)]
enum Model {
    /// An SMPL archive, a map of its soft parts and a recipe.
    Body,
    /// An SMPL archive, bone surfaces and a recipe.
    Hand,
    /// A skin and a recipe.
    Finger,
    /// A tet mesh and a recipe.
    Limb,
    /// A walk on SMPL's joint tree, as BVH.
    Walk,
    /// Poses of the hand that grasps and lifts, as JSON lines.
    Grasp,
}

/// Arguments of `supple sample`.
#[derive(clap::Args)]
pub struct Arguments {
    /// Which model.
    model: Model,
    /// Where its files go.
    #[arg(short, long)]
    output: PathBuf,
}

impl Arguments {
    /// Writes the model's files.
    pub fn run(self) -> Result<()> {
        let folder = &self.output;
        make_folder(folder)?;
        let source = match self.model {
            Model::Walk => {
                write_bvh(&walk(), folder.join("walk.bvh"))?;
                print(format_args!("written to {}", folder.display()));
                return Ok(());
            }
            Model::Grasp => {
                let lines: String = grasp().iter().map(pose_line).collect();
                let path = folder.join("grasp.jsonl");
                std::fs::write(&path, lines).map_err(|e| Error::io(&path, e))?;
                print(format_args!("written to {}", folder.display()));
                return Ok(());
            }
            Model::Body => {
                let body = body()?;
                write_smpl(&body.model, folder.join("body.npz"))?;
                write_painted(&map_of(&body.soft), folder.join("body_soft.npy"))?;
                AvatarSource {
                    model: Some("body.npz".into()),
                    painted: [(SOFT.to_string(), "body_soft.npy".into())].into(),
                    bake: Some(Sample::Body.body()?.1),
                    ..AvatarSource::default()
                }
            }
            Model::Hand => {
                let hand = hand()?;
                write_smpl(&hand.model, folder.join("hand.npz"))?;
                let names = hand.model.names.iter().map(String::as_str);
                write_obj(names.zip(&hand.bones), folder.join("hand_bones.obj"))?;
                write_painted(&map_of(&hand.palmar), folder.join("hand_palm.npy"))?;
                AvatarSource {
                    model: Some("hand.npz".into()),
                    bones: Some("hand_bones.obj".into()),
                    painted: [(PALM.to_string(), "hand_palm.npy".into())].into(),
                    bake: Some(Sample::Hand.body()?.1),
                    ..AvatarSource::default()
                }
            }
            Model::Finger => {
                let (body, recipe) = Sample::Finger.body()?;
                write_obj([("skin", &body.skin)], folder.join("finger_skin.obj"))?;
                AvatarSource {
                    bake: Some(recipe),
                    ..AvatarSource::of_sample(Sample::Finger)
                }
            }
            Model::Limb => {
                let (mesh, pinned, surface) = Limb::S.mesh()?;
                let file = TetMeshFile {
                    mesh,
                    pinned,
                    surface,
                };
                write_tet_mesh(&file, folder.join("limb.txt"))?;
                AvatarSource {
                    mesh: Some("limb.txt".into()),
                    bake: Some(Sample::LimbS.body()?.1),
                    ..AvatarSource::default()
                }
            }
        };
        let name = format!("{:?}.toml", self.model).to_lowercase();
        write_recipe(&source, &folder.join(name))?;
        print(format_args!("written to {}", folder.display()));
        Ok(())
    }
}

/// What a recipe's lines mean, by how they begin.
const COMMENTS: [(&str, &str); 15] = [
    ("model =", "The character file."),
    ("mesh =", "Tets around one bone."),
    ("sample =", "A body that supple makes itself."),
    (
        "bones = \"",
        "Closed surfaces of its bones: objects with their names.",
    ),
    (
        "[painted]",
        "Maps on the skin, by name: a number for each vertex of the model's file.",
    ),
    ("density =", "kg/m³, of tissue and bones."),
    ("damping_time =", "Stiffness-proportional damping, s."),
    (
        "captured_under_gravity =",
        "Whether the shape sags already, as a scanned body does.",
    ),
    (
        "mesher =",
        "auto, { lattice = { nodes = 20000 } } or { prism_shell = { thickness = 0.03 } } (m).",
    ),
    ("basis_energy =", "biharmonic or triharmonic."),
    (
        "[bake.material",
        "Pa. Without it the bake chooses a tissue that sways visibly.",
    ),
    (
        "[[bake.stiffness]]",
        "Where tissue is `scale` times as stiff: `bones`, `within` a box, a `painted` map.",
    ),
    (
        "[[bake.handles]]",
        "Where handles stand: `count` or `spacing` (m) over `bones`, a `painted` map, `vertices` or `within` a box.",
    ),
    (
        "[bake.truncation]",
        "Values of the basis below `below` vanish, above `above` they stay.",
    ),
    ("[bake.cubature]", "Points that carry mass and elasticity."),
];

/// A recipe that explains itself.
fn write_recipe(source: &AvatarSource, path: &Path) -> Result<()> {
    let text = source.to_toml()?;
    let file = path.file_name().unwrap_or_default().to_string_lossy();
    let mut out = format!(
        "# Bake it: supple bake {file}. Files lie beside this one; every key under [bake] may be left out.\n\n"
    );
    for line in text.lines() {
        for (start, comment) in COMMENTS {
            if line.starts_with(start) {
                out += &format!("# {comment}\n");
            }
        }
        out += &format!("{line}\n");
    }
    std::fs::write(path, out).map_err(|e| Error::io(path, e))
}
