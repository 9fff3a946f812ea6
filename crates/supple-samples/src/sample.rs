//! The bodies that the crate makes itself, each with its own recipe.

use crate::finger::Finger;
use crate::{body, hand};
use serde::{Deserialize, Serialize};
use supple::Result;
use supple::material::{Material, StableNeoHookean};
use supple::model::UpAxis;
use supple_bake::mesh::ShellOptions;
use supple_bake::{Body, CubatureRecipe, HandleRegion, Limb, Mesher, Recipe};

/// Bodies that the crate makes itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Sample {
    /// A body of 24 bones.
    Body,
    /// A hand of 16 bones.
    Hand,
    /// A finger of three bones.
    Finger,
    /// The bone press limb, mesh S.
    LimbS,
    /// The bone press limb, mesh M.
    LimbM,
}

/// A shape of [`Sample::Body`] by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SampleShape {
    /// The mean: breasts and belly of hardly any depth of their own.
    Mean,
    /// Large breasts, a belly and broad hips: what swings most on people.
    Full,
}

impl SampleShape {
    /// Amounts of the body's shape directions.
    pub fn betas(self) -> &'static [f64] {
        match self {
            Self::Mean => &[],
            // Weight, breasts, belly, in standard deviations. More of the breasts alone would make them less deep: a shell is
            // as deep as half the way to what faces away.
            Self::Full => &[0.0, 2.4, 0.0, 0.0, 0.3, 0.5],
        }
    }
}

impl Sample {
    /// The body and its own recipe.
    pub fn body(self) -> Result<(Body, Recipe)> {
        self.shaped(&[])
    }

    /// The same of shape `betas`, which only [`Sample::Body`] has.
    pub fn shaped(self, betas: &[f64]) -> Result<(Body, Recipe)> {
        match self {
            Self::LimbS => Ok((Limb::S.body()?, limb_recipe())),
            Self::LimbM => Ok((Limb::M.body()?, limb_recipe())),
            Self::Finger => Ok((Finger::default().body()?, handles(40))),
            Self::Body => {
                let sample = body()?;
                let mut body = Body::of_model("body", &sample.model, betas, Vec::new());
                body.painted.insert(SOFT.into(), map_of(&sample.soft));
                body.skeleton.limits = sample.limits;
                Ok((body, body_recipe()))
            }
            Self::Hand => {
                let hand = hand()?;
                let mut body = Body::of_model("hand", &hand.model, &[], hand.bones);
                body.up = UpAxis::Z;
                body.painted.insert(PALM.into(), map_of(&hand.palmar));
                body.skeleton.limits = hand.limits;
                Ok((body, hand_recipe()))
            }
        }
    }
}

/// Name of the map painted on the hand: where its handles stand.
pub const PALM: &str = "palm";

/// The same of the body.
pub const SOFT: &str = "soft";

/// A map that is 1 where `chosen` and 0 elsewhere.
pub fn map_of(chosen: &[bool]) -> Vec<f64> {
    chosen.iter().map(|c| f64::from(u8::from(*c))).collect()
}

/// The paper's body: 82 handles over the soft parts, 500 cubature points in one layer of prisms.
pub(crate) fn body_recipe() -> Recipe {
    Recipe {
        mesher: Mesher::PrismShell(ShellOptions {
            layers: Some(1),
            ..ShellOptions::default()
        }),
        handles: vec![HandleRegion {
            count: Some(82),
            painted: Some(SOFT.into()),
            soft: 0.5,
            ..HandleRegion::default()
        }],
        cubature: CubatureRecipe {
            points: Some(500),
            ..CubatureRecipe::default()
        },
        ..Recipe::default()
    }
}

/// The paper's hand: 87 handles over palm and finger pads, 700 cubature points.
pub(crate) fn hand_recipe() -> Recipe {
    let mut recipe = handles(87);
    recipe.handles[0].painted = Some(PALM.into());
    // Firm tissue that is pressed and hardly sways: scaled rows would take a quarter of a dent away.
    recipe.truncation.keep_sway = Some(false);
    recipe.cubature = CubatureRecipe {
        points: Some(700),
        ..CubatureRecipe::default()
    };
    recipe
}

/// So many handles all over the skin of firm tissue: these bodies are made to be pressed.
fn handles(count: usize) -> Recipe {
    Recipe {
        material: Some(Material::StableNeoHookean(StableNeoHookean {
            youngs_modulus: 30e3,
            poissons_ratio: 0.4,
        })),
        handles: vec![HandleRegion {
            count: Some(count),
            ..Default::default()
        }],
        ..Default::default()
    }
}

/// The bone press: its rest shape is that without gravity.
pub fn limb_recipe() -> Recipe {
    Recipe {
        captured_under_gravity: false,
        ..handles(82)
    }
}
