//! Seeded random numbers for generated models and tests: the same everywhere, for ever.

use glam::{DMat3, DVec3};

use super::rotation_exp;

/// SplitMix64 (Steele, Lea and Flood 2014).
#[derive(Clone, Debug)]
pub struct Random(u64);

impl Random {
    /// The sequence of `seed`.
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// The next 64 bits.
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Uniform in \[low, high).
    pub fn uniform(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * (self.bits() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Uniform in 0..count; `count` must not be 0.
    pub fn index(&mut self, count: usize) -> usize {
        (self.bits() % count as u64) as usize
    }

    /// `wanted` different numbers below `count` (all of them where there are fewer), rising.
    pub fn subset(&mut self, count: usize, wanted: usize) -> Vec<usize> {
        let wanted = wanted.min(count);
        let mut chosen = std::collections::BTreeSet::new();
        while chosen.len() < wanted {
            chosen.insert(self.index(count));
        }
        chosen.into_iter().collect()
    }

    /// Each component uniform in \[−size, size).
    pub fn vector(&mut self, size: f64) -> DVec3 {
        DVec3::from_array(std::array::from_fn(|_| self.uniform(-size, size)))
    }

    /// Each entry uniform in \[−size, size).
    pub fn matrix(&mut self, size: f64) -> DMat3 {
        DMat3::from_cols(self.vector(size), self.vector(size), self.vector(size))
    }

    /// A rotation whose vector has components in \[−angle, angle) rad.
    pub fn rotation(&mut self, angle: f64) -> DMat3 {
        rotation_exp(self.vector(angle))
    }
}
