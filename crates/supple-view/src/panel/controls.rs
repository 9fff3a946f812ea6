//! What can be set, and what can be asked for.

use crate::stage::ValueMap;
use crate::touch::Tool;
use supple::Result;
use supple::potential::TissueFactors;
use supple::sim::Settings;

/// What is set in the panel or by keys.
#[derive(Clone, Debug, PartialEq)]
pub struct Controls {
    /// How many times as soft as it was baked.
    pub softness: f64,
    /// From 0 (it creeps back) by 0.5 (as baked) to 1.
    pub bounce: f64,
    /// A factor on gravity as tissue feels it.
    pub weight: f64,
    /// A factor on gravity.
    pub gravity: f64,
    /// A factor on friction.
    pub friction: f64,
    /// Of muscle, 0 to 1.
    pub tension: f64,
    /// How many fine handles may be awake, where the character has any.
    pub fine_handles: usize,
    /// s.
    pub time_step: f64,
    /// How firmly bones are held while something is grabbed: the power of ten of a factor on the scene's springs.
    pub grip: f64,
    /// Of the spring that grabs, N/m.
    pub pull: f64,
    /// What is on the cursor.
    pub tool: Tool,
    /// Half the width of a thing on the cursor, in parts of the character.
    pub width: f64,
    /// Which values colour the skin.
    pub map: ValueMap,
    /// Whether handles are drawn as dots.
    pub handles: bool,
    /// Whether colliders are drawn.
    pub colliders: bool,
}

impl Controls {
    /// As it was baked, for a scene of this time step.
    pub fn new(time_step: f64) -> Self {
        Self {
            softness: 1.0,
            bounce: 0.5,
            weight: 1.0,
            gravity: 1.0,
            friction: 1.0,
            tension: 0.0,
            fine_handles: Settings::default().fine_handles,
            time_step,
            grip: -4.0,
            pull: 300.0,
            tool: Tool::Hand,
            width: 0.05,
            map: ValueMap::None,
            handles: false,
            colliders: true,
        }
    }

    /// What the tissue has otherwise than baked.
    ///
    /// # Errors
    /// None: the sliders end where factors do.
    pub fn factors(&self) -> Result<TissueFactors> {
        let mut factors = TissueFactors::with_bounce(self.bounce)?;
        factors.stiffness = 1.0 / self.softness;
        factors.gravity = self.weight;
        factors.friction = self.friction;
        factors.tension = self.tension;
        Ok(factors)
    }
}

/// What is asked for once.
#[derive(Clone, Debug, PartialEq)]
pub enum Command {
    /// Back to the start.
    Reset,
    /// Throw a ball at what the cursor is over.
    Throw,
    /// Keep this moment.
    Keep,
    /// Go back to it.
    Restore,
    /// Write the last seconds as GLB.
    WriteGlb,
    /// Write how the character is baked.
    WriteRecipe,
    /// Look at all of it again.
    Fit,
    /// Show another character.
    Open(crate::bake::Request),
}
