//! Motions: what files say, and what an avatar makes of it.

mod amass;
mod formats;
mod recorded;
mod retarget;
mod roots;
mod zero_pose;
