//! The shape that is asked of an avatar's source.

use super::{AvatarSource, BodyOrigin};
use std::path::Path;
use supple::{Error, Result};
use supple_samples::Sample;

impl AvatarSource {
    /// Asks for the shape of the person in the `motion` of AMASS.
    ///
    /// # Errors
    /// [`Error::Invalid`] of a source that is no character file.
    pub fn set_shape_of(&mut self, motion: &Path) -> Result<()> {
        if let Self::Body(body) = self
            && let BodyOrigin::Character(character) = &mut body.from
        {
            character.betas_of = Some(motion.to_path_buf());
            return Ok(());
        }
        let problem = "a motion's person shapes a model of SMPL only";
        Err(Error::invalid("betas_of", problem))
    }

    /// Asks for the shape `betas` of the model.
    ///
    /// # Errors
    /// [`Error::Invalid`] of a source that has one shape only.
    pub fn set_shape(&mut self, betas: &[f64]) -> Result<()> {
        let own = match self {
            Self::Body(body) => match &mut body.from {
                BodyOrigin::Character(character) => Some(&mut character.betas),
                BodyOrigin::Sample {
                    sample: Sample::Body,
                    betas,
                } => Some(betas),
                _ => None,
            },
            _ => None,
        };
        let problem =
            "this body has one shape only; a character file that has shape directions is needed";
        *own.ok_or_else(|| Error::invalid("shape", problem))? = betas.to_vec();
        Ok(())
    }
}
