//! What a hand and a body must be.

mod body;
mod hand;
mod offsets;
mod surface;
