//! Handles of a body with two like halves: in pairs, or on the plane between them.

use super::sampling::{Density, Far};
use crate::math::NearestPoint;
use glam::DVec3;

/// A mirrored place is as far from the skin as this at most, relative to the extent across the plane.
const TOLERANCE: f64 = 0.02;

/// The part of the places that have a mirrored one.
const MIRRORED: f64 = 0.95;

/// The plane that mirrors a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Mirror {
    /// The axis across it.
    axis: usize,
    /// Where it meets that axis, m.
    at: f64,
}

impl Mirror {
    /// The plane across x, y or z through the middle of `places` in which they mirror one another best, if they do.
    pub fn of(places: &[DVec3]) -> Option<Self> {
        let search = NearestPoint::new(places);
        let low = places.iter().copied().reduce(DVec3::min)?;
        let high = places.iter().copied().reduce(DVec3::max)?;
        let found = (0..3).filter_map(|axis| {
            let mirror = Self {
                axis,
                at: 0.5 * (low + high)[axis],
            };
            let reach = TOLERANCE * (high - low)[axis];
            let has_twin = |p: &&DVec3| search.distance(mirror.image(**p)) <= reach;
            let twins = places.iter().filter(has_twin).count();
            let share = twins as f64 / places.len() as f64;
            (share >= MIRRORED).then_some((share, mirror))
        });
        // The first of equals.
        let best = found.reduce(|best, m| if m.0 > best.0 { m } else { best });
        best.map(|(_, mirror)| mirror)
    }

    /// The mirrored place.
    pub fn image(&self, mut p: DVec3) -> DVec3 {
        p[self.axis] = 2.0 * self.at - p[self.axis];
        p
    }

    /// Distance from the plane, m.
    fn distance(&self, p: DVec3) -> f64 {
        (p[self.axis] - self.at).abs()
    }

    /// The place of the plane that is closest to `p`.
    fn foot(&self, mut p: DVec3) -> DVec3 {
        p[self.axis] = self.at;
        p
    }
}

/// [`super::weighted_farthest_points`] with each point's mirrored one; what would stand closer to its mirrored one than
/// to any other point goes to the plane between them.
pub(crate) fn mirrored_farthest_points(
    mirror: Mirror,
    candidates: &[DVec3],
    weights: &[f64],
    taken: &[DVec3],
    density: Density,
) -> Vec<u32> {
    // What has no weight is never chosen, as a mirrored point neither.
    let usable: Vec<u32> = (0..candidates.len() as u32)
        .filter(|&i| weights[i as usize] > 0.0)
        .collect();
    let places: Vec<DVec3> = usable.iter().map(|&i| candidates[i as usize]).collect();
    let search = NearestPoint::new(&places);
    let nearest = |p: DVec3| search.nearest(p).map(|(i, _)| usable[i as usize]);
    // What is its own mirrored place.
    let middles: Vec<u32> = (usable.iter().copied())
        .filter(|&i| nearest(mirror.image(candidates[i as usize])) == Some(i))
        .collect();
    let middle_places: Vec<DVec3> = middles.iter().map(|&i| candidates[i as usize]).collect();
    let middle_search = NearestPoint::new(&middle_places);
    let mut far = Far::new(candidates, weights, taken);
    let mut chosen: Vec<u32> = Vec::new();
    let mut next = far.first(taken);
    loop {
        let (place, distance) = (candidates[next], far.weighted(next));
        let left = match density {
            Density::Count(count) => count.saturating_sub(chosen.len()),
            Density::Spacing(spacing) if distance <= spacing * spacing => 0,
            Density::Spacing(_) => usize::MAX,
        };
        if left == 0 || distance == 0.0 {
            return chosen;
        }
        let gap = far.squares[next].sqrt();
        let apart = 2.0 * mirror.distance(place);
        let middle = (apart < gap)
            .then(|| middle_search.nearest(mirror.foot(place)))
            .flatten()
            .map(|(m, _)| middles[m as usize])
            .filter(|&m| candidates[m as usize].distance(place) < gap)
            // Not beside another handle, unless the pair would stand closer still.
            .filter(|&m| 2.0 * apart < gap || 2.0 * far.squares[m as usize].sqrt() >= gap);
        let wanted = match middle {
            Some(_) => [middle, None],
            // One alone would leave the halves unlike.
            None if left == 1 => return chosen,
            None => [Some(next as u32), nearest(mirror.image(place))],
        };
        let before = chosen.len();
        for i in wanted.into_iter().flatten() {
            if !chosen.contains(&i) {
                far.take(candidates[i as usize]);
                chosen.push(i);
            }
        }
        if chosen.len() == before {
            // Only rounding can bring this about: the middle is nearer to the place than any handle.
            return chosen;
        }
        next = far.farthest();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use supple::internal::math::Random;

    /// A random cloud 1 m by 2 m by 0.4 m, its mirrored one across x = 0.3, and what lies on that plane.
    fn cloud() -> Vec<DVec3> {
        let mut random = Random::new(6);
        let mut half: Vec<DVec3> = Vec::new();
        while half.len() < 1500 {
            let p = random.vector(1.0) * DVec3::new(0.5, 1.0, 0.2);
            half.extend((p.x > 0.0).then_some(p + DVec3::X * 0.3));
        }
        let mirrored = half.iter().map(|p| DVec3::new(0.6 - p.x, p.y, p.z));
        let middle: Vec<DVec3> = (0..300)
            .map(|_| random.vector(1.0) * DVec3::new(0.0, 1.0, 0.2) + DVec3::X * 0.3)
            .collect();
        // Other orders must give the same halves.
        mirrored.chain(middle).chain(half.iter().copied()).collect()
    }

    #[test]
    fn the_plane_is_found_where_there_is_one() {
        let mut places = cloud();
        let mirror = Mirror::of(&places).unwrap();
        assert!(mirror.axis == 0 && (mirror.at - 0.3).abs() < 1e-12);
        for p in &mut places[..900] {
            p.y += 0.5 * (p.x * 9.0).sin();
        }
        assert_eq!(Mirror::of(&places), None);
        assert_eq!(Mirror::of(&[]), None);
    }

    #[test]
    fn points_come_in_pairs_or_lie_on_the_plane() {
        let places = cloud();
        let mirror = Mirror::of(&places).unwrap();
        // Denser upwards, and nothing at the bottom.
        let weights: Vec<f64> = places.iter().map(|p| (0.7 + p.y).max(0.0)).collect();
        for count in [1, 2, 7, 40, 81] {
            let density = Density::Count(count);
            let chosen = mirrored_farthest_points(mirror, &places, &weights, &[], density);
            // The last place is left where only a pair would do.
            assert!((count - 1..=count).contains(&chosen.len()), "{count}");
            let chosen: Vec<DVec3> = chosen.iter().map(|&i| places[i as usize]).collect();
            let side = |sign: f64| chosen.iter().filter(|p| sign * (p.x - 0.3) > 1e-9).count();
            assert_eq!(side(1.0), side(-1.0));
            for (i, p) in chosen.iter().enumerate() {
                assert!(p.y > -0.7);
                let twin = mirror.image(*p);
                assert!(chosen.iter().any(|q| q.distance(twin) < 1e-12), "{p}");
                let others = chosen.iter().enumerate().filter(|(k, _)| *k != i);
                let gap = others.map(|(_, q)| q.distance(*p)).fold(9.0, f64::min);
                // 3,300 places of a box of 1 m by 2 m by 0.4 m: spread, not heaped.
                assert!(count < 81 || gap > 0.04, "{gap} at {p}");
            }
        }
        let spacing = Density::Spacing(0.1);
        let even = vec![1.0; places.len()];
        let chosen = mirrored_farthest_points(mirror, &places, &even, &[], spacing);
        for p in &places {
            let near = chosen.iter().map(|&i| places[i as usize].distance(*p));
            assert!(near.fold(9.0, f64::min) <= 0.1);
        }
    }
}
