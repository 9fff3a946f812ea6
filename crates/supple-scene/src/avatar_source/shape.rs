//! Shape, size and up that are asked of an avatar's source.

use super::{AvatarSource, BodyOrigin, BodySource};
use std::path::Path;
use supple::model::UpAxis;
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

    /// Says the size of the file's unit, m.
    ///
    /// # Errors
    /// [`Error::Invalid`] of a size that is not positive, and of what is baked already.
    pub fn set_scale(&mut self, scale: f64) -> Result<()> {
        if !(scale > 0.0 && scale.is_finite()) {
            let problem = format!("must be positive (m a unit), is {scale}");
            return Err(Error::invalid("scale", problem));
        }
        self.unbaked("scale")?.scale = Some(scale);
        Ok(())
    }

    /// Says which axis points up in the file.
    ///
    /// # Errors
    /// [`Error::Invalid`] of what is baked already.
    pub fn set_up(&mut self, up: UpAxis) -> Result<()> {
        self.unbaked("up")?.up = Some(up);
        Ok(())
    }

    /// Asks for fine handles, by default where the recipe says nothing of them.
    ///
    /// # Errors
    /// [`Error::Invalid`] of what is baked already; what reading the body says.
    pub fn set_fine_handles(&mut self) -> Result<()> {
        let recipe = match &self.unbaked("fine_handles")?.bake {
            Some(recipe) => recipe.clone(),
            None => self.body()?.1,
        };
        let body = self.unbaked("fine_handles")?;
        let recipe = body.bake.insert(recipe);
        recipe.fine_handles.get_or_insert_default();
        Ok(())
    }

    fn unbaked(&mut self, key: &str) -> Result<&mut BodySource> {
        match self {
            Self::Body(body) => Ok(body),
            _ => Err(Error::invalid(
                key,
                "is for a bake, and this is baked already",
            )),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fine_handles_are_added_to_the_recipe_that_is_there() {
        let mut limb = AvatarSource::of_sample(Sample::LimbS);
        let own = limb.body().unwrap().1;
        assert!(own.fine_handles.is_none());
        limb.set_fine_handles().unwrap();
        let asked = limb.body().unwrap().1;
        assert!(asked.fine_handles.is_some());
        assert_eq!(asked.handles, own.handles);
        let mut baked = AvatarSource::Baked("baked.supple".into());
        let error = baked.set_fine_handles().unwrap_err().to_string();
        assert!(error.contains("fine_handles"), "{error}");
    }
}
