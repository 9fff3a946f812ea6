//! A press in a reduced space, against its truth.

use super::presses::Press;
use super::truth::Truth;
use crate::awake::{Points, awake_space, nearest, scalar_blocks};
use crate::press::press_along;
use glam::DMat3;
use serde::Serialize;
use std::sync::Arc;
use supple::Result;
use supple::internal::math::{Rows, Stopwatch};
use supple::model::Avatar;
use supple_bake::Truncation;
use supple_bake::subspace::elastic_extension;

/// How handles' columns go on below the skin.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Form {
    /// Coarse and fine as the biharmonic basis does.
    Biharmonic,
    /// The coarse ones so, the fine ones elastically.
    Mixed,
    /// All elastically.
    Elastic,
}

impl Form {
    pub const ALL: [Self; 3] = [Self::Biharmonic, Self::Mixed, Self::Elastic];

    pub fn name(self) -> &'static str {
        match self {
            Self::Biharmonic => "biharmonic",
            Self::Mixed => "mixed",
            Self::Elastic => "elastic",
        }
    }
}

/// A body with its fine handles in every form.
pub struct Forms {
    /// Its fine handles are elastic.
    pub elastic: Arc<Avatar>,
    /// The same with biharmonic ones.
    pub biharmonic: Arc<Avatar>,
    scalar: Rows<(u32, DMat3)>,
    blocks: Option<Rows<(u32, DMat3)>>,
}

/// Blocks of the coarse handles below the skin, as those of the fine ones are truncated.
const DEPTH: Truncation = Truncation {
    below: 0.01,
    above: 0.03,
    enabled: true,
    keep_sway: None,
};

impl Forms {
    /// `all`: with coarse elastic columns too.
    ///
    /// # Errors
    /// As [`elastic_extension`].
    pub fn new(elastic: Arc<Avatar>, biharmonic: Arc<Avatar>, all: bool) -> Result<Self> {
        let blocks = match all {
            true => Some(elastic_extension(&elastic, DEPTH)?.nodes().clone()),
            false => None,
        };
        Ok(Self {
            scalar: scalar_blocks(&elastic),
            elastic,
            biharmonic,
            blocks,
        })
    }

    /// The forms that there are.
    pub fn list(&self) -> Vec<Form> {
        let there = |form: &Form| *form != Form::Elastic || self.blocks.is_some();
        Form::ALL.into_iter().filter(there).collect()
    }
}

/// How a press went in a reduced space.
#[derive(Clone, Debug, Serialize)]
pub struct Trial {
    pub form: Form,
    /// Fine handles that were awake.
    pub awake: usize,
    /// Whether every tet was integrated.
    pub all_tets: bool,
    /// ‖u − u_truth‖ / ‖u_truth‖ over the skin.
    pub error: f64,
    /// What the sphere is pushed back with, N.
    pub force: f64,
    /// Smallest det F over all tets.
    pub min_det_f: f64,
    /// Wall-clock time of all load steps, ms.
    pub ms: f64,
    #[serde(skip)]
    pub displacement: Vec<glam::DVec3>,
}

/// `press` with the `budget` fine handles awake that are nearest to it.
///
/// # Errors
/// Whatever a step says.
pub fn trial(
    forms: &Forms,
    press: &Press,
    truth: &Truth,
    form: Form,
    budget: usize,
    points: Points,
) -> Result<Trial> {
    let (avatar, coarse) = match form {
        Form::Biharmonic => (&forms.biharmonic, &forms.scalar),
        Form::Mixed => (&forms.elastic, &forms.scalar),
        Form::Elastic => (
            &forms.elastic,
            forms.blocks.as_ref().unwrap_or(&forms.scalar),
        ),
    };
    let awake = nearest(&avatar.fine, press.place, budget);
    let space = awake_space(avatar, coarse, &awake, points)?;
    let watch = Stopwatch::start();
    let potential = space.reference(1)?;
    let pressed = press_along(
        space.avatar(),
        potential,
        None,
        press.shape(),
        &press.frames(),
    )?;
    Ok(Trial {
        form,
        awake: awake.len(),
        all_tets: points == Points::AllTets,
        error: pressed.relative_error(&truth.pressed),
        force: pressed.force(),
        min_det_f: space.min_det_f(&pressed.state)?,
        ms: watch.ms(),
        displacement: pressed.displacement,
    })
}
