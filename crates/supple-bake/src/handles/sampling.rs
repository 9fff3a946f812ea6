//! Farthest-point sampling.

use crate::math::Blocks;
use glam::DVec3;

/// When to stop sampling.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Density {
    /// After this many.
    Count(usize),
    /// When no candidate is farther than this from a chosen point, m.
    Spacing(f64),
}

/// Indices of candidates, each the one farthest from all chosen before and from `taken`; ties go
/// to the lower index. With nothing taken the first is the one farthest from the candidates' mean,
/// so that the order of candidates does not matter.
///
/// Coincident candidates are chosen once.
pub fn farthest_points(candidates: &[DVec3], taken: &[DVec3], density: Density) -> Vec<u32> {
    let even = vec![1.0; candidates.len()];
    weighted_farthest_points(candidates, &even, taken, density)
}

/// [`farthest_points`] where the distance of candidate i counts `weights[i]` times, so that the spacing around it
/// is in proportion to 1/weight. One of weight 0 is never chosen.
pub fn weighted_farthest_points(
    candidates: &[DVec3],
    weights: &[f64],
    taken: &[DVec3],
    density: Density,
) -> Vec<u32> {
    if candidates.is_empty() {
        return Vec::new();
    }
    let mut far = Far::new(candidates, weights, taken);
    let mut chosen = Vec::new();
    let mut next = far.first(taken);
    loop {
        let distance = far.weighted(next);
        let enough = match density {
            Density::Count(count) => chosen.len() >= count,
            Density::Spacing(spacing) => distance <= spacing * spacing,
        };
        if enough || distance == 0.0 {
            return chosen;
        }
        chosen.push(next as u32);
        far.take(candidates[next]);
        next = far.farthest();
    }
}

/// A squared distance, weighted.
fn weighted(square: f64, weight: f64) -> f64 {
    if weight > 0.0 {
        weight * weight * square
    } else {
        0.0
    }
}

/// How far candidates are from what is taken, block by block.
pub(super) struct Far<'a> {
    candidates: &'a [DVec3],
    weights: &'a [f64],
    blocks: Blocks,
    /// Squared distance of each candidate, m².
    pub squares: Vec<f64>,
    most: Vec<Most>,
}

/// What is greatest in a block.
#[derive(Clone, Copy)]
struct Most {
    /// Squared distance.
    square: f64,
    /// Weighted squared distance, and the first candidate that has it.
    weighted: f64,
    candidate: u32,
}

impl Most {
    fn of(members: &[u32], squares: &[f64], weights: &[f64]) -> Self {
        let mut most = Self {
            square: 0.0,
            weighted: f64::NEG_INFINITY,
            candidate: members[0],
        };
        for &i in members {
            let square = squares[i as usize];
            most.square = most.square.max(square);
            let weighted = weighted(square, weights[i as usize]);
            if most.is_behind(weighted, i) {
                (most.weighted, most.candidate) = (weighted, i);
            }
        }
        most
    }

    /// Whether candidate `i` comes first; of equals the lower index does.
    fn is_behind(&self, weighted: f64, i: u32) -> bool {
        weighted > self.weighted || weighted == self.weighted && i < self.candidate
    }
}

impl<'a> Far<'a> {
    /// Of `candidates`, of which there is one, from `taken`.
    pub fn new(candidates: &'a [DVec3], weights: &'a [f64], taken: &[DVec3]) -> Self {
        let nearest = |p: &DVec3| {
            let squares = taken.iter().map(|t| t.distance_squared(*p));
            squares.fold(f64::INFINITY, f64::min)
        };
        let squares: Vec<f64> = candidates.iter().map(nearest).collect();
        let blocks = Blocks::new(candidates);
        let most = |(_, members): (_, &[u32])| Most::of(members, &squares, weights);
        Self {
            most: blocks.iter().map(most).collect(),
            candidates,
            weights,
            blocks,
            squares,
        }
    }

    /// Takes `point`. A block whose box is farther from it than its candidates are from others stays as it is.
    pub fn take(&mut self, point: DVec3) {
        for ((block, members), most) in self.blocks.iter().zip(&mut self.most) {
            if block.distance_squared(point) >= most.square {
                continue;
            }
            for &i in members {
                let square = &mut self.squares[i as usize];
                *square = square.min(self.candidates[i as usize].distance_squared(point));
            }
            *most = Most::of(members, &self.squares, self.weights);
        }
    }

    /// Where to begin: with nothing taken, at the candidate farthest from the mean of all.
    pub fn first(&self, taken: &[DVec3]) -> usize {
        if !taken.is_empty() {
            return self.farthest();
        }
        let mean = self.candidates.iter().sum::<DVec3>() / self.candidates.len() as f64;
        let from_mean = self.candidates.iter().zip(self.weights);
        farthest(from_mean.map(|(p, &w)| weighted(p.distance_squared(mean), w)))
    }

    /// Weighted squared distance of a candidate, m².
    pub fn weighted(&self, candidate: usize) -> f64 {
        weighted(self.squares[candidate], self.weights[candidate])
    }

    /// The candidate of greatest weighted distance, the first of equals.
    pub fn farthest(&self) -> usize {
        let first = self.most.iter().copied().reduce(|best, m| {
            if best.is_behind(m.weighted, m.candidate) {
                m
            } else {
                best
            }
        });
        first.map_or(0, |m| m.candidate as usize)
    }
}

/// Index of the largest value, the first of equals.
fn farthest(values: impl Iterator<Item = f64>) -> usize {
    let mut best = (0, f64::NEG_INFINITY);
    for (i, value) in values.enumerate() {
        if value > best.1 {
            best = (i, value);
        }
    }
    best.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use supple::internal::math::Random;

    #[test]
    fn samples_are_spread_and_cover() {
        let mut random = Random::new(1);
        let candidates: Vec<DVec3> = (0..2000).map(|_| random.vector(1.0)).collect();
        let chosen = farthest_points(&candidates, &[], Density::Count(50));
        let chosen: Vec<DVec3> = chosen.iter().map(|&i| candidates[i as usize]).collect();
        let gap = |p: DVec3, least: f64| {
            let distances = chosen.iter().map(|q| q.distance(p));
            distances
                .filter(|&d| d >= least)
                .fold(f64::INFINITY, f64::min)
        };
        let packing = chosen
            .iter()
            .map(|&p| gap(p, 1e-300))
            .fold(f64::INFINITY, f64::min);
        let covering = candidates.iter().map(|&p| gap(p, 0.0)).fold(0.0, f64::max);
        // The greedy choice's own property: nothing is left farther away than the closest pair.
        assert!(
            chosen.len() == 50 && covering <= packing,
            "{covering} {packing}"
        );
    }

    #[test]
    fn the_choice_is_that_of_a_full_search() {
        let mut random = Random::new(2);
        // Each twice, so that there are equals; some of no weight.
        let candidates: Vec<DVec3> = (0..400).map(|_| random.vector(1.0)).collect();
        let candidates = candidates.repeat(2);
        let weights: Vec<f64> = (0..800)
            .map(|_| random.uniform(-0.2, 1.0).max(0.0))
            .collect();
        let mut taken = vec![DVec3::splat(0.3), DVec3::X];
        let chosen = weighted_farthest_points(&candidates, &weights, &taken, Density::Count(90));
        for i in chosen {
            let distance = |(p, w): (&DVec3, &f64)| {
                let squares = taken.iter().map(|t| t.distance_squared(*p));
                weighted(squares.fold(f64::INFINITY, f64::min), *w)
            };
            assert_eq!(
                i as usize,
                farthest(candidates.iter().zip(&weights).map(distance))
            );
            taken.push(candidates[i as usize]);
        }
        assert_eq!(taken.len(), 92);
    }

    #[test]
    fn spacing_and_taken_points_are_respected() {
        let candidates: Vec<DVec3> = (0..11).map(|i| DVec3::X * f64::from(i)).collect();
        let chosen = farthest_points(&candidates, &[DVec3::ZERO], Density::Spacing(1.5));
        assert_eq!(chosen[..2], [10, 5]);
        assert!(!chosen.contains(&0) && chosen.len() == 4, "{chosen:?}");
        let twice = [DVec3::ZERO, DVec3::ZERO, DVec3::X];
        assert_eq!(farthest_points(&twice, &[], Density::Count(9)).len(), 2);
    }

    #[test]
    fn spacing_follows_the_weights() {
        // A line whose right half counts twice: half the spacing there, and none where the weight is 0.
        let line: Vec<DVec3> = (0..3000)
            .map(|i| DVec3::X * f64::from(i) / 1000.0)
            .collect();
        let weights: Vec<f64> = line.iter().map(|p| p.x.floor()).collect();
        let chosen = weighted_farthest_points(&line, &weights, &[], Density::Spacing(0.1));
        let within = |low: f64, high: f64| {
            let places = chosen.iter().map(|&i| line[i as usize].x);
            places.filter(|x| (low..high).contains(x)).count() as f64
        };
        assert_eq!(within(0.0, 1.0), 0.0);
        let ratio = within(2.0, 3.0) / within(1.0, 2.0);
        assert!((1.5..3.0).contains(&ratio), "{ratio}");
        assert!(within(1.0, 2.0) >= 4.0);
    }
}
