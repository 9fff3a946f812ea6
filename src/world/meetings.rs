//! Who may touch what in a step.

use super::backend::Room;
use super::batch::Batch;
use super::contents::{Body, World};
use super::keys::BodyId;
use super::near::ball;
use crate::Result;
use crate::collider::{Collider, Shape};
use crate::model::Frame;
use crate::sim::{Link, Stepper};
use slotmap::SlotMap;

/// Always added to what moves in a step, m: nothing that is nearer is overlooked.
pub(super) const MARGIN: f64 = 0.01;

/// An avatar that may touch a body.
#[derive(Clone, Copy, Debug)]
struct Meeting {
    /// The avatar's instance.
    asset: usize,
    place: usize,
    body: BodyId,
    /// Which of the avatar's body slots stands for it.
    slot: usize,
}

/// Memory of the meetings of a step.
#[derive(Default)]
pub(super) struct Meetings {
    list: Vec<Meeting>,
    pub links: Vec<Link>,
}

impl Meetings {
    /// Adds what avatars exert on each body to the body's report, where it is known.
    pub fn report_pushes(
        &self,
        stepper: &Stepper,
        bodies: &SlotMap<BodyId, Body>,
        batches: &mut [Batch],
    ) {
        for (meeting, link) in self.list.iter().zip(&self.links) {
            if let Some(force) = stepper.push(link) {
                let body = &mut batches[bodies[meeting.body].asset].characters[0];
                body.report.contact_force += force;
            }
        }
    }
}

/// How far an instance may move in a step, m.
pub(super) fn travel(batch: &Batch, place: usize) -> f64 {
    let instance = &batch.characters[place].instance;
    let apart = |a: &Frame, b: &Frame| a.position.distance(b.position);
    let frames = instance
        .state
        .frames
        .iter()
        .zip(&instance.history.previous().frames);
    let last = frames.take(batch.avatar.bones()).map(|(a, b)| apart(a, b));
    let pins = instance.pins.iter();
    let driven = pins.map(|pin| apart(&pin.frame, &instance.state.frames[pin.bone]));
    // What is far from a joint moves further than the joint.
    2.0 * last.chain(driven).fold(0.0, f64::max)
}

impl World {
    /// Finds what every instance may touch in a step, makes room for it, and gives it to the instances.
    pub(super) fn meet(&mut self) -> Result<()> {
        for (key, collider) in &self.colliders {
            let named = |e: crate::Error| e.within(&format!("colliders[{key:?}]"));
            collider.validate().map_err(named)?;
        }
        let mut meetings = std::mem::take(&mut self.meetings);
        let fall = self.gravity().length() * self.time_step().powi(2);
        self.find_colliders(fall);
        meetings.list.clear();
        self.find_bodies(fall, &mut meetings.list);
        let room = self.make_room_for(&meetings.list);
        if room.is_ok() {
            self.hand_out_bodies(&meetings.list);
        }
        self.meetings = meetings;
        room
    }

    /// Gives each instance the colliders that it may touch.
    fn find_colliders(&mut self, fall: f64) {
        for batch in &mut self.batches {
            for place in 0..batch.characters.len() {
                let margin = MARGIN + fall + travel(batch, place);
                let instance = &mut batch.characters[place].instance;
                instance.colliders.clear();
                if !instance.active {
                    continue;
                }
                let (bounds, parents) = (&batch.bounds, &batch.avatar.skeleton.parents);
                for collider in self.colliders.values() {
                    let moved = collider.frame.position.distance(collider.previous.position);
                    let margin = margin + 2.0 * moved;
                    let near = ball(collider, &collider.frame)
                        .is_none_or(|ball| bounds.meets(parents, instance, ball, margin));
                    if near {
                        instance.colliders.push(collider.clone());
                    }
                }
            }
        }
    }

    /// Lists which instance may touch which body.
    fn find_bodies(&self, fall: f64, meetings: &mut Vec<Meeting>) {
        let avatars = self.batches.iter().enumerate().filter(|(_, b)| !b.is_body);
        for (asset, batch) in avatars {
            let parents = &batch.avatar.skeleton.parents;
            for place in 0..batch.characters.len() {
                let instance = &batch.characters[place].instance;
                if !instance.active {
                    continue;
                }
                let margin = MARGIN + fall + travel(batch, place);
                let mut slot = 0;
                for (body, found) in &self.bodies {
                    let of_body = &self.batches[found.asset];
                    let frame = &of_body.characters[0].instance.state.frames[0];
                    let margin = margin + travel(of_body, 0);
                    let ball = ball(&found.collider, frame);
                    let near = |ball| batch.bounds.meets(parents, instance, ball, margin);
                    if ball.is_none_or(near) {
                        meetings.push(Meeting {
                            asset,
                            place,
                            body,
                            slot,
                        });
                        slot += 1;
                    }
                }
            }
        }
    }

    /// Makes room for what has been found.
    fn make_room_for(&mut self, meetings: &[Meeting]) -> Result<()> {
        let is_mesh = |shape: &Shape| matches!(shape, Shape::Mesh(_));
        let meshes = (self
            .colliders
            .values()
            .filter(|c| is_mesh(&c.shape))
            .count())
            + (self
                .bodies
                .values()
                .filter(|b| is_mesh(&b.rigid.shape))
                .count());
        let mut rest = meetings;
        for asset in 0..self.batches.len() {
            let mine = rest.partition_point(|m| m.asset == asset);
            let (of_asset, others) = rest.split_at(mine);
            rest = others;
            let body_slots = of_asset.iter().map(|m| m.slot + 1).max().unwrap_or(0);
            let instances = self.batches[asset].characters.iter();
            let colliders = instances.map(|c| c.instance.colliders.len()).max();
            let (batch, budget) = (&self.batches[asset], self.settings.fine_handles);
            let wanted = Room {
                instances: 0,
                body_slots,
                colliders: colliders.unwrap_or(0) + body_slots,
                meshes,
                fine_slots: self.opened.fine_slots(batch.base(), budget),
            };
            self.make_room(asset, wanted)?;
        }
        Ok(())
    }

    /// Gives each instance the colliders of the bodies that it may touch, and their places.
    fn hand_out_bodies(&mut self, meetings: &[Meeting]) {
        for meeting in meetings {
            let found = &self.bodies[meeting.body];
            let of_body = &self.batches[found.asset].characters[0].instance;
            let state = of_body.state.frames[0];
            let batch = &mut self.batches[meeting.asset];
            let frame = batch.avatar.bones() + meeting.slot;
            let instance = &mut batch.characters[meeting.place].instance;
            instance.state.frames[frame] = state;
            instance.colliders.push(Collider {
                body: Some(frame as u32),
                ..found.collider.clone()
            });
        }
    }

    /// Lists the links of a step's members, once they are numbered.
    pub(super) fn list_links(&mut self) {
        let (bodies, batches) = (&self.bodies, &self.batches);
        let link = |meeting: &Meeting| {
            let batch = &batches[meeting.asset];
            Link {
                member: batch.first + meeting.place,
                frame: batch.avatar.bones() + meeting.slot,
                body: batches[bodies[meeting.body].asset].first,
            }
        };
        let meetings = &mut self.meetings;
        meetings.links.clear();
        meetings.links.extend(meetings.list.iter().map(link));
    }
}
