//! `supple sample`.

use super::make_folder;
use super::terminal::print;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use supple::Result;
use supple::internal::write_whole;
use supple::model::UpAxis;
use supple_files::{
    TetMeshFile, pose_line, write_bvh, write_obj, write_painted, write_smpl, write_tet_mesh,
};
use supple_samples::hand::grasp;
use supple_samples::{Limb, PALM, SOFT, Sample, body, hand, map_of, walk};
use supple_scene::{AvatarSource, BodyOrigin, BodySource, CharacterSource};

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
                write_whole(folder.join("grasp.jsonl"), lines)?;
                print(format_args!("written to {}", folder.display()));
                return Ok(());
            }
            Model::Body => {
                let body = body()?;
                write_smpl(&body.model, folder.join("body.npz"))?;
                write_painted(&map_of(&body.soft), folder.join("body_soft.npy"))?;
                let character = CharacterSource {
                    painted: [(SOFT.to_string(), "body_soft.npy".into())].into(),
                    ..CharacterSource::new("body.npz")
                };
                AvatarSource::from(character).baked_by(Sample::Body.body()?.1)?
            }
            Model::Hand => {
                let hand = hand()?;
                write_smpl(&hand.model, folder.join("hand.npz"))?;
                let names = hand.model.names.iter().map(String::as_str);
                write_obj(names.zip(&hand.bones), folder.join("hand_bones.obj"))?;
                write_painted(&map_of(&hand.palmar), folder.join("hand_palm.npy"))?;
                let character = CharacterSource {
                    bones: Some("hand_bones.obj".into()),
                    painted: [(PALM.to_string(), "hand_palm.npy".into())].into(),
                    ..CharacterSource::new("hand.npz")
                };
                let source = BodySource {
                    from: BodyOrigin::Character(character),
                    scale: None,
                    up: Some(UpAxis::Z),
                    bake: Some(Sample::Hand.body()?.1),
                };
                AvatarSource::from(source)
            }
            Model::Finger => {
                let (body, recipe) = Sample::Finger.body()?;
                write_obj([("skin", &body.skin)], folder.join("finger_skin.obj"))?;
                AvatarSource::of_sample(Sample::Finger).baked_by(recipe)?
            }
            Model::Limb => {
                let (mesh, pinned, surface) = Limb::S.mesh()?;
                let file = TetMeshFile {
                    mesh,
                    pinned,
                    surface,
                };
                write_tet_mesh(&file, folder.join("limb.txt"))?;
                let tets = BodyOrigin::Tets {
                    mesh: "limb.txt".into(),
                    regions: BTreeMap::new(),
                };
                AvatarSource::from(tets).baked_by(Sample::LimbS.body()?.1)?
            }
        };
        let name = format!("{:?}.toml", self.model).to_lowercase();
        write_recipe(&source, &folder.join(name))?;
        print(format_args!("written to {}", folder.display()));
        Ok(())
    }
}

/// What a recipe's lines mean, by how they begin.
const COMMENTS: [(&str, &str); 16] = [
    ("model =", "The character file."),
    ("up =", "The axis that points up in it."),
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
    write_whole(path, out)
}
