//! What every material must satisfy, and what each is known to give.

mod fung_neo_hookean;
mod laws;
mod orthotropic;
mod stable_neo_hookean;

use glam::DMat3;

pub fn largest(m: DMat3) -> f64 {
    m.to_cols_array()
        .iter()
        .fold(0.0, |a, x| f64::max(a, x.abs()))
}
