//! A frame that takes several steps: where everything that the host drives is in between.

use super::contents::World;
use crate::model::Frame;
use crate::sim::DrivenFrame;

/// What is driven, and what it was before; kept from frame to frame.
#[derive(Default)]
pub(super) struct WorldFrame {
    /// Of all characters of all batches, in order.
    characters: Vec<DrivenFrame>,
    /// Previous and present places of the colliders, in order.
    colliders: Vec<[Frame; 2]>,
}

impl World {
    /// Takes down where everything is and where it goes.
    pub(super) fn begin_frame(&mut self) {
        let frame = &mut self.frame;
        let mut count = 0;
        for character in self.batches.iter().flat_map(|b| &b.characters) {
            match frame.characters.get_mut(count) {
                Some(memory) => memory.begin(&character.instance),
                None => (frame.characters).push(DrivenFrame::new(&character.instance)),
            }
            count += 1;
        }
        frame.characters.truncate(count);
        frame.colliders.clear();
        let colliders = self.colliders.values();
        (frame.colliders).extend(colliders.map(|c| [c.previous, c.frame]));
    }

    /// Puts what is driven where it is at the end of a `part` of the frame.
    pub(super) fn drive_frame(&mut self, part: f64) {
        let characters = self.batches.iter_mut().flat_map(|b| &mut b.characters);
        for (memory, character) in self.frame.characters.iter().zip(characters) {
            memory.drive(&mut character.instance, part);
        }
        for ([start, end], collider) in self.frame.colliders.iter().zip(self.colliders.values_mut())
        {
            collider.frame = start.between(end, part);
        }
    }

    /// Makes everything what it was.
    pub(super) fn undo_frame(&mut self) {
        let batches = self.batches.iter_mut();
        let characters = batches.flat_map(|b| b.characters.iter_mut().map(|c| (c, &b.avatar)));
        for (memory, (character, avatar)) in self.frame.characters.iter().zip(characters) {
            memory.undo(&mut character.instance);
            // Room for more bodies may have been made in the meantime.
            character.set_avatar(avatar);
        }
        for ([start, end], collider) in self.frame.colliders.iter().zip(self.colliders.values_mut())
        {
            (collider.previous, collider.frame) = (*start, *end);
        }
    }
}
