//! Cubature points as an evaluation goes through them.

use super::asset::Asset;
use super::points::Points;
use super::{Basis, Incidence};
use crate::material::MaterialPoint;
use crate::math::Rows;
use crate::potential::{BlockPattern, TissueFactors};

/// Points, what moves them, and where their blocks go: the avatar's own ones, or those of an instance with fine handles
/// awake, which are the same with further ones behind them.
pub(super) struct Cubature<B> {
    pub points: Points<B>,
    pub incidence: Incidence,
    /// w of each, m³.
    pub measure: Vec<f64>,
    /// Which of the avatar's fine points those after its coarse ones are.
    pub children: Vec<u32>,
}

impl<B> Default for Cubature<B> {
    fn default() -> Self {
        Self {
            points: Points {
                skinning: Rows::default(),
                basis: Rows::default(),
            },
            incidence: Incidence::default(),
            measure: Vec::new(),
            children: Vec::new(),
        }
    }
}

impl<B: Basis> Cubature<B> {
    /// `points` of these measures, which have all their pairs of blocks in `pattern`.
    pub fn new(points: Points<B>, measure: Vec<f64>, pattern: &BlockPattern) -> Self {
        Self {
            incidence: points.incidence(pattern),
            points,
            measure,
            children: Vec::new(),
        }
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        self.points.len()
    }

    /// Takes all points out; the memory stays.
    pub fn clear(&mut self) {
        self.points.skinning.clear();
        self.points.basis.clear();
        self.incidence.clear();
        self.measure.clear();
        self.children.clear();
    }

    /// The tissue at point `i` as `factors` change it.
    pub fn tissue_at<'a, A: Basis>(
        &self,
        asset: &'a Asset<A>,
        i: usize,
        factors: &TissueFactors,
    ) -> MaterialPoint<'a> {
        let avatar = &*asset.avatar;
        let coarse = avatar.cubature.len();
        let mut tissue = match i.checked_sub(coarse) {
            None => avatar.tissue_at(i),
            Some(k) => {
                let local = avatar.fine.tissue.get(self.children[k] as usize);
                avatar.material.at(local.copied().unwrap_or_default())
            }
        };
        tissue.local = factors.on(tissue.local);
        tissue
    }
}
