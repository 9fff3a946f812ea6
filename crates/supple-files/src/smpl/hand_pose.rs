//! MANO's space of hand poses (Romero et al. 2017): a mean and its principal components.

use super::fields::Tree;
use super::{SmplKind, names};
use crate::arrays::Arrays;
use glam::DVec3;
use supple::{Error, Result};

/// Numbers of a hand's pose: a rotation vector for each of 15 bones.
const NUMBERS: usize = 45;

/// The poses of one hand.
#[derive(Clone, Debug, PartialEq)]
pub struct HandPose {
    /// The 15 bones, in the order of the pose's rotation vectors.
    pub bones: Vec<u32>,
    /// Mean pose: a rotation vector for each bone, rad.
    pub mean: Vec<DVec3>,
    /// Principal components, the largest first: a rotation vector for each bone, rad.
    pub components: Vec<Vec<DVec3>>,
}

impl HandPose {
    /// The rotation vector of each bone, relative to its parent: Σ c_k component_k, plus the mean
    /// unless `flat_hand_mean` says that a hand whose coefficients are 0 lies flat.
    ///
    /// # Errors
    /// [`Error::Invalid`] where there are more coefficients than components.
    pub fn rotations(&self, coefficients: &[f64], flat_hand_mean: bool) -> Result<Vec<DVec3>> {
        if coefficients.len() > self.components.len() {
            let problem = format!(
                "{} coefficients for {} components: leave some out",
                coefficients.len(),
                self.components.len()
            );
            return Err(Error::invalid("hand pose", problem));
        }
        let mut vectors = vec![DVec3::ZERO; self.bones.len()];
        for (coefficient, component) in coefficients.iter().zip(&self.components) {
            vectors
                .iter_mut()
                .zip(component)
                .for_each(|(v, c)| *v += *coefficient * *c);
        }
        Ok(self.with_mean(&vectors, flat_hand_mean))
    }

    /// Rotation vectors that a file gives relative to the mean, as `smplx` reads them; unchanged
    /// where `flat_hand_mean` says that they are not.
    pub fn with_mean(&self, vectors: &[DVec3], flat_hand_mean: bool) -> Vec<DVec3> {
        let mean = if flat_hand_mean { 0.0 } else { 1.0 };
        let both = vectors.iter().zip(&self.mean);
        both.map(|(v, m)| *v + mean * *m).collect()
    }
}

/// The hands whose components are in the file.
pub(super) fn read(arrays: &Arrays, kind: SmplKind, tree: &Tree) -> Result<Vec<HandPose>> {
    let sides: &[&str] = match kind {
        SmplKind::Mano => &[""],
        SmplKind::SmplH | SmplKind::SmplX => &["l", "r"],
        SmplKind::Smpl | SmplKind::Other => &[],
    };
    let mut hands = Vec::new();
    for (side, first) in sides.iter().zip(names::first_fingers(kind)) {
        let key = format!("hands_components{side}");
        if arrays.get(&key)?.is_none() {
            continue;
        }
        let vectors = |numbers: &[f64]| numbers.chunks_exact(3).map(DVec3::from_slice).collect();
        let components = arrays.expect(&key, &[None, Some(NUMBERS)])?;
        let mean = arrays.expect(&format!("hands_mean{side}"), &[Some(NUMBERS)])?;
        hands.push(HandPose {
            bones: (*first..first + NUMBERS / 3)
                .map(|old| tree.index_of(old))
                .collect(),
            mean: vectors(&mean.numbers),
            components: components
                .numbers
                .chunks_exact(NUMBERS)
                .map(vectors)
                .collect(),
        });
    }
    Ok(hands)
}
