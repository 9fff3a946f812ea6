//! Farthest-point sampling.

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
    let squared: Vec<f64> = weights.iter().map(|w| w * w).collect();
    let nearest = |p: DVec3| {
        let squares = taken.iter().map(|t| t.distance_squared(p));
        squares.fold(f64::INFINITY, f64::min)
    };
    let mut squares: Vec<f64> = candidates.iter().map(|&p| nearest(p)).collect();
    let mut chosen = Vec::new();
    let mean = candidates.iter().sum::<DVec3>() / candidates.len() as f64;
    let weighted = |square: f64, w: f64| if w > 0.0 { w * square } else { 0.0 };
    let mut next = if taken.is_empty() {
        let from_mean = candidates.iter().zip(&squared);
        farthest(from_mean.map(|(p, &w)| weighted(p.distance_squared(mean), w)))
    } else {
        farthest(squares.iter().zip(&squared).map(|(s, &w)| weighted(*s, w)))
    };
    loop {
        let distance = weighted(squares[next], squared[next]);
        let enough = match density {
            Density::Count(count) => chosen.len() >= count,
            Density::Spacing(spacing) => distance <= spacing * spacing,
        };
        if enough || distance == 0.0 {
            return chosen;
        }
        chosen.push(next as u32);
        let point = candidates[next];
        for (square, p) in squares.iter_mut().zip(candidates) {
            *square = square.min(p.distance_squared(point));
        }
        next = farthest(squares.iter().zip(&squared).map(|(s, &w)| weighted(*s, w)));
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
