//! Colliders of a world, which all avatars and bodies meet.

use super::backend::gone;
use super::contents::World;
use super::keys::ColliderId;
use crate::collider::Collider;
use crate::{Error, Result};

impl World {
    /// A collider that all avatars and bodies meet. Its motion is the host's: write its `frame` between steps.
    ///
    /// # Errors
    /// A collider that is not sound, or fixed to a frame.
    pub fn add_collider(&mut self, collider: Collider) -> Result<ColliderId> {
        collider.validate().map_err(|e| e.within("collider"))?;
        if collider.body.is_some() {
            let problem = "is fixed to a frame of an avatar; add a rigid body instead";
            return Err(Error::invalid("collider.body", problem));
        }
        Ok(self.colliders.insert(collider))
    }

    /// A collider.
    ///
    /// # Errors
    /// A key of none.
    pub fn collider_mut(&mut self, collider: ColliderId) -> Result<&mut Collider> {
        self.colliders
            .get_mut(collider)
            .ok_or_else(|| gone("collider"))
    }

    /// The ground, at height zero: a half-space below the world's up, with friction.
    ///
    /// # Errors
    /// None: it is sound.
    pub fn add_ground(&mut self) -> Result<ColliderId> {
        let mut ground = Collider::ground(self.up);
        ground.friction = 0.5;
        self.add_collider(ground)
    }

    /// Takes a collider out.
    ///
    /// # Errors
    /// A key of none.
    pub fn remove_collider(&mut self, collider: ColliderId) -> Result<Collider> {
        self.colliders
            .remove(collider)
            .ok_or_else(|| gone("collider"))
    }
}
