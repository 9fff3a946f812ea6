//! `supple sample`.

use super::{make_folder, print};
use crate::export::{write_bvh, write_obj, write_painted, write_smpl, write_tet_mesh};
use crate::load::{AvatarSource, PALM, SOFT, Sample, TetMeshFile, map_of};
use crate::sample::{Limb, body, hand, walk};
use crate::{Error, Result};
use std::path::{Path, PathBuf};

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

fn write_recipe(source: &AvatarSource, path: &Path) -> Result<()> {
    let text = toml::to_string(source)
        .map_err(|e| Error::invalid("recipe", format!("cannot be written as TOML: {e}")))?;
    std::fs::write(path, text).map_err(|e| Error::io(path, e))
}
