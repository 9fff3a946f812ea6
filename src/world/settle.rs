//! Equilibrium of a whole world.

use super::contents::World;
use crate::Result;
use crate::sim::{Timings, settle};

impl World {
    /// Puts all characters into equilibrium with what drives and touches them, at rest, as if they had been there for long:
    /// tissue sags, springs give way, and nothing swings in the first step. For a level that is loaded, or a character that
    /// was put somewhere. Bodies stay where they are, and so does the root of a ragdoll. Without friction. Returns how far
    /// the last of its iterations still moved anything, m: a hundred-thousandth of a millimetre, but of what has no equilibrium.
    ///
    /// # Errors
    /// As [`World::step`]; all characters then are as they were.
    pub async fn settle(&mut self) -> Result<f64> {
        let usual = self.settings;
        self.put_settings(settle::settings(&usual));
        let mut before = Vec::new();
        for batch in &mut self.batches {
            let parents = &batch.avatar.skeleton.parents[..batch.avatar.bones()];
            for character in &mut batch.characters {
                let roots = (0..parents.len()).filter(|&j| parents[j].is_none());
                before.push(settle::Before::begin(&mut character.instance, roots));
            }
        }
        let done = self.settle_characters().await;
        self.put_settings(usual);
        let batches = self.batches.iter_mut();
        let characters = batches.flat_map(|b| b.characters.iter_mut().map(|c| (c, &b.avatar)));
        for ((character, avatar), before) in characters.zip(before) {
            before.end(&mut character.instance, done.is_ok());
            // Room for more bodies may have been made in the meantime.
            character.set_avatar(avatar);
        }
        done
    }

    async fn settle_characters(&mut self) -> Result<f64> {
        let mut settling = settle::Settling::new();
        while settling.goes_on() {
            let timings = &mut Timings::default();
            (self.substep(settle::TIME_STEP, false, true, timings)).await?;
            let characters = self.batches.iter_mut().flat_map(|b| &mut b.characters);
            characters.for_each(|character| settling.take(&mut character.instance));
        }
        self.posed = true;
        Ok(settling.moved)
    }

    /// [`World::settle`] on this thread until it is done.
    ///
    /// # Errors
    /// As [`World::settle`].
    #[cfg(not(target_arch = "wasm32"))]
    pub fn settle_blocking(&mut self) -> Result<f64> {
        pollster::block_on(self.settle())
    }
}
