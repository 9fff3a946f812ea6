//! Whole steps: what must hold in time.

mod adversarial;
mod batch;
mod bodies;
mod bone_press;
mod contact_pairs;
mod dynamics;
pub mod fine;
mod imports;
mod linear_solver;
mod motion;
mod newton;
mod springs;
mod statics;
mod step_potential;
