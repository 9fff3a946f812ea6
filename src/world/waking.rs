//! Which fine handles are awake in a frame of a world (method §10).

use super::contents::World;
use super::meetings::{MARGIN, travel};
use super::near::ball;
use crate::Result;
use crate::collider::Collider;
use crate::model::Frame;
use crate::potential::Potential;

impl World {
    /// Wakes the fine handles near what may touch the characters in this frame.
    pub(super) fn wake_fine_handles(&mut self) {
        let mut near = std::mem::take(&mut self.near);
        let budget = self.settings.fine_handles;
        for asset in 0..self.batches.len() {
            if self.evaluators.get_mut(asset).on_cpu().is_none() {
                continue;
            }
            for place in 0..self.batches[asset].characters.len() {
                let batch = &self.batches[asset];
                if !(batch.used[place] && batch.characters[place].awake) {
                    continue;
                }
                self.find_near(asset, place, &mut near);
                let batch = &mut self.batches[asset];
                if let Some(waking) = &batch.physics.waking {
                    let instance = &mut batch.characters[place].instance;
                    waking.update(instance, &near, budget);
                }
            }
        }
        self.near = near;
    }

    /// Lists the colliders and bodies that may come within reach of an instance's fine handles, where they are in the world.
    fn find_near(&self, asset: usize, place: usize, near: &mut Vec<Collider>) {
        near.clear();
        let batch = &self.batches[asset];
        let Some(waking) = &batch.physics.waking else {
            return;
        };
        let (parents, instance) = (
            &batch.avatar.skeleton.parents,
            &batch.characters[place].instance,
        );
        let margin = MARGIN + waking.reach() + travel(batch, place);
        let meets = |collider: &Collider, swept: f64| {
            let ball = ball(collider, &collider.frame);
            let meets = |ball| (batch.bounds).meets(parents, instance, ball, margin + swept);
            ball.is_none_or(meets)
        };
        for collider in self.colliders.values() {
            let swept = collider.frame.position.distance(collider.previous.position);
            if meets(collider, swept) {
                near.push(collider.clone());
            }
        }
        for body in self.bodies.values() {
            let moving = &self.batches[body.asset].characters[0].instance;
            let [now, before] = [&moving.state, moving.history.previous()].map(|s| s.frames[0]);
            // As far again as in the last step, whose length may have been another.
            let rate = self.settings.time_step / moving.history.last_step();
            let ahead = (now.position - before.position) * rate;
            let end = Frame {
                position: now.position + ahead,
                ..now
            };
            let collider = Collider {
                frame: end.compose(&body.collider.frame),
                previous: now.compose(&body.collider.frame),
                body: None,
                ..body.collider.clone()
            };
            if meets(&collider, ahead.length()) {
                near.push(collider);
            }
        }
    }

    /// Tells the evaluators which fine handles are awake.
    pub(super) fn tell_awake(&mut self) -> Result<()> {
        for (asset, batch) in self.batches.iter().enumerate() {
            if batch.physics.waking.is_none() {
                continue;
            }
            let Some(potential) = self.evaluators.get_mut(asset).on_cpu() else {
                continue;
            };
            for (place, character) in batch.characters.iter().enumerate() {
                Potential::wake(potential, place, &character.instance.awake)?;
            }
        }
        Ok(())
    }
}
