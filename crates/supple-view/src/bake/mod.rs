//! From a file to a character on its stage, beside the interface.

mod character;
mod request;

pub use character::Character;
pub use request::{Request, is_motion};

use crate::app::Options;
use crate::platform::{Clock, beside};
use crate::stage::Stage;
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use supple::world::Backend;
use supple::{Error, Result};

/// What the work beside the interface says.
enum Message {
    /// It is at this phase of [`supple_bake::PHASES`].
    Phase(usize),
    Done(Result<Box<Stage>>),
}

/// A character on its way.
pub struct Loading {
    /// What it is called meanwhile.
    pub name: String,
    /// The phase of [`supple_bake::PHASES`] that it is at; none before the bake.
    pub phase: Option<usize>,
    since: Clock,
    receiver: Receiver<Message>,
}

impl Loading {
    /// Begins, as the `options` say; the world is made on `backend`.
    pub fn start(request: Request, options: &Options, backend: Backend) -> Self {
        let (cache, fine) = (options.cache.clone(), options.fine_handles);
        let (sender, receiver) = channel();
        let name = request.name();
        beside(async move {
            // Nobody hears it where another file was dropped meanwhile.
            let mut progress = |phase| drop(sender.send(Message::Phase(phase)));
            let done = match Character::load(&request, fine, cache.as_deref(), &mut progress) {
                Ok(character) => Stage::new(Box::new(character), backend).await.map(Box::new),
                Err(e) => Err(e),
            };
            drop(sender.send(Message::Done(done)));
        });
        Self {
            name,
            phase: None,
            since: Clock::start(),
            receiver,
        }
    }

    /// How long it has taken so far, s.
    pub fn seconds(&self) -> f64 {
        self.since.seconds()
    }

    /// The character on its stage, or what went wrong, once it is there.
    pub fn poll(&mut self) -> Option<Result<Box<Stage>>> {
        loop {
            match self.receiver.try_recv() {
                Ok(Message::Phase(phase)) => self.phase = Some(phase),
                Ok(Message::Done(done)) => return Some(done),
                Err(TryRecvError::Empty) => return None,
                Err(TryRecvError::Disconnected) => {
                    let problem =
                        "its bake ended without a word: that is a mistake of this program";
                    return Some(Err(Error::invalid(self.name.clone(), problem)));
                }
            }
        }
    }
}
