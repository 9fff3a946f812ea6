//! Motions: what files say, and what an avatar makes of it.

mod formats;
mod recorded;
mod retarget;
