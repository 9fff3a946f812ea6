//! Rigid bodies of a world.

use super::backend::gone;
use super::batch::Batch;
use super::character::{Character, rigid};
use super::contents::{Body, World};
use super::keys::BodyId;
use crate::model::{Frame, RigidBody};
use crate::sim::InstanceReport;
use crate::{Error, Result};
use glam::DVec3;

impl World {
    /// A rigid body, which falls, rests on colliders, is pushed by all avatars that touch it and pushes back.
    ///
    /// # Errors
    /// A body that is not sound.
    pub fn add_body(&mut self, body: RigidBody) -> Result<BodyId> {
        let (batch, evaluator) =
            Batch::of_body(&mut self.opened, &body, self.settings, self.gravity)?;
        let asset = self.push(batch, evaluator);
        Ok(self.bodies.insert(Body {
            collider: body.collider(0),
            rigid: body,
            asset,
        }))
    }

    /// Takes a body out.
    ///
    /// # Errors
    /// A key of none.
    pub fn remove_body(&mut self, body: BodyId) -> Result<()> {
        let removed = self.bodies.remove(body).ok_or_else(|| gone("body"))?;
        self.remove_asset(removed.asset);
        Ok(())
    }

    /// Where a body is.
    ///
    /// # Errors
    /// A key of none.
    pub fn body_frame(&self, body: BodyId) -> Result<Frame> {
        Ok(self.body(body)?.instance.state.frames[0])
    }

    /// Where a body was before the last step, and where it is.
    ///
    /// # Errors
    /// A key of none.
    pub fn body_motion(&self, body: BodyId) -> Result<(Frame, Frame)> {
        let instance = &self.body(body)?.instance;
        Ok((
            instance.history.previous().frames[0],
            instance.state.frames[0],
        ))
    }

    /// What the last step said of a body. Its contact force is what colliders and avatars exert on it; that of avatars on
    /// the GPU is one step late, as their reports are, and that of avatars without driven bones is left out where
    /// [`Settings::report_at_end`](crate::sim::Settings::report_at_end) has been switched off.
    ///
    /// # Errors
    /// A key of none.
    pub fn body_report(&self, body: BodyId) -> Result<&InstanceReport> {
        Ok(&self.body(body)?.report)
    }

    /// Puts a body at `frame`, with the velocity of its origin (m/s) and an angular velocity (rad/s).
    ///
    /// # Errors
    /// A key of none, a frame that is not rigid, or velocities that are not finite.
    pub fn set_body_motion(
        &mut self,
        body: BodyId,
        frame: &Frame,
        velocity: DVec3,
        angular_velocity: DVec3,
    ) -> Result<()> {
        rigid("frame", frame)?;
        if !(velocity.is_finite() && angular_velocity.is_finite()) {
            return Err(Error::invalid("velocity", "is not finite"));
        }
        let asset = self.bodies.get(body).ok_or_else(|| gone("body"))?.asset;
        let instance = &mut self.batches[asset].characters[0].instance;
        instance.history.rest(&instance.state);
        instance.set_motion(0, *frame, velocity, angular_velocity);
        Ok(())
    }

    fn body(&self, body: BodyId) -> Result<&Character> {
        let asset = self.bodies.get(body).ok_or_else(|| gone("body"))?.asset;
        Ok(&self.batches[asset].characters[0])
    }
}
