//! What a hand does: it grabs flesh or bone, presses things in, throws balls.

mod balls;
mod grab;
mod pick;
mod probe;

pub use balls::Balls;
pub use grab::Grab;
pub use pick::{Hit, pick};
pub use probe::{Probe, Tool};
