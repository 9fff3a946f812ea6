//! Points in blocks that lie close together, for searches that pass over whole blocks.

use glam::DVec3;

/// Points sorted into blocks of at most [`Blocks::SIZE`].
pub(crate) struct Blocks {
    blocks: Vec<Block>,
    order: Vec<u32>,
}

/// Some points and the box around them.
pub(crate) struct Block {
    low: DVec3,
    high: DVec3,
    members: std::ops::Range<usize>,
}

impl Block {
    /// Squared distance from `p` to the box, m²; 0 inside. No member is nearer.
    pub fn distance_squared(&self, p: DVec3) -> f64 {
        p.distance_squared(p.clamp(self.low, self.high))
    }
}

impl Blocks {
    /// Points of a block at most.
    pub const SIZE: usize = 32;

    /// Halves finite `points` across the longest side of their box until blocks are small.
    pub fn new(points: &[DVec3]) -> Self {
        let mut out = Self {
            blocks: Vec::with_capacity(2 * points.len() / Self::SIZE + 1),
            order: (0..points.len() as u32).collect(),
        };
        out.split(points, 0..points.len());
        out
    }

    fn split(&mut self, points: &[DVec3], members: std::ops::Range<usize>) {
        let own = &mut self.order[members.clone()];
        let places = || own.iter().map(|&i| points[i as usize]);
        let low = places().fold(DVec3::INFINITY, DVec3::min);
        let high = places().fold(DVec3::NEG_INFINITY, DVec3::max);
        if own.len() <= Self::SIZE {
            self.blocks.push(Block { low, high, members });
            return;
        }
        let axis = (high - low).max_position();
        let middle = own.len() / 2;
        own.select_nth_unstable_by(middle, |&a, &b| {
            let at = |i: u32| points[i as usize][axis];
            at(a).total_cmp(&at(b)).then(a.cmp(&b))
        });
        let middle = members.start + middle;
        self.split(points, members.start..middle);
        self.split(points, middle..members.end);
    }

    /// Each block with the points in it.
    pub fn iter(&self) -> impl Iterator<Item = (&Block, &[u32])> {
        let members = |b: &Block| &self.order[b.members.clone()];
        self.blocks.iter().map(move |b| (b, members(b)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use supple::internal::math::Random;

    #[test]
    fn every_point_is_in_one_block_and_no_nearer_than_its_box() {
        let mut random = Random::new(9);
        let points: Vec<DVec3> = (0..1000).map(|_| random.vector(1.0)).collect();
        let blocks = Blocks::new(&points);
        let mut seen = vec![0; points.len()];
        for _ in 0..20 {
            let p = random.vector(2.0);
            for (block, members) in blocks.iter() {
                assert!((1..=Blocks::SIZE).contains(&members.len()));
                for &i in members {
                    seen[i as usize] += 1;
                    let distance = points[i as usize].distance_squared(p);
                    assert!(distance >= block.distance_squared(p));
                }
            }
        }
        assert!(seen.iter().all(|n| *n == 20));
        assert!(blocks.iter().count() < 1000 / Blocks::SIZE * 3);
    }
}
