//! The nearest of many points.

use glam::DVec3;
use std::collections::HashMap;

/// The nearest of many points, found through cells.
pub struct NearestPoint<'a> {
    points: &'a [DVec3],
    low: DVec3,
    cell: f64,
    most: i64,
    cells: HashMap<[i64; 3], Vec<u32>>,
}

impl<'a> NearestPoint<'a> {
    /// Sorts `points` into cells.
    pub fn new(points: &'a [DVec3]) -> Self {
        let (low, high) = (points.iter())
            .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| {
                (low.min(*p), high.max(*p))
            });
        let extent = (high - low).max_element().max(1e-9);
        // Points lie on surfaces: so many cells along an edge leave a few points in a cell.
        let cell = extent / (points.len() as f64).sqrt().clamp(1.0, 256.0);
        let mut search = Self {
            points,
            low,
            cell,
            most: (extent / cell) as i64 + 1,
            cells: HashMap::new(),
        };
        for (i, &p) in points.iter().enumerate() {
            let key = search.key(p);
            search.cells.entry(key).or_default().push(i as u32);
        }
        search
    }

    fn key(&self, p: DVec3) -> [i64; 3] {
        ((p - self.low) / self.cell)
            .to_array()
            .map(|x| x.floor() as i64)
    }

    /// Distance from `p` to the nearest point, m; ∞ where there is none.
    pub fn distance(&self, p: DVec3) -> f64 {
        self.nearest(p)
            .map_or(f64::INFINITY, |(_, distance)| distance)
    }

    /// Index of the point nearest to `p` (the lowest of equals) and its distance, m.
    pub fn nearest(&self, p: DVec3) -> Option<(u32, f64)> {
        if self.points.is_empty() {
            return None;
        }
        let centre = self.key(p.clamp(self.low, self.low + self.cell * self.most as f64));
        let mut nearest = (f64::INFINITY, 0);
        for ring in 0..=self.most + 1 {
            // What is farther than this ring of cells can be no nearer.
            let reach = (ring - 1).max(0) as f64 * self.cell;
            if nearest.0 < reach * reach {
                break;
            }
            let mut look = |key: [i64; 3]| {
                for &i in self.cells.get(&key).into_iter().flatten() {
                    let square = self.points[i as usize].distance_squared(p);
                    if square < nearest.0 || square == nearest.0 && i < nearest.1 {
                        nearest = (square, i);
                    }
                }
            };
            for x in -ring..=ring {
                for y in -ring..=ring {
                    let rim = x.abs() == ring || y.abs() == ring;
                    let step = if rim || ring == 0 { 1 } else { 2 * ring };
                    let mut z = -ring;
                    while z <= ring {
                        look([centre[0] + x, centre[1] + y, centre[2] + z]);
                        z += step;
                    }
                }
            }
        }
        Some((nearest.1, nearest.0.sqrt()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use supple::internal::math::Random;

    #[test]
    fn the_nearest_point_is_that_of_a_full_search() {
        let mut random = Random::new(5);
        for count in [1usize, 7, 900] {
            let points: Vec<DVec3> = (0..count).map(|_| random.vector(1.0)).collect();
            let search = NearestPoint::new(&points);
            for _ in 0..200 {
                let p = random.vector(2.0);
                let squares = points.iter().map(|q| q.distance_squared(p));
                let expected = squares.fold(f64::INFINITY, f64::min).sqrt();
                assert_eq!(search.distance(p), expected);
            }
        }
        assert_eq!(NearestPoint::new(&[]).distance(DVec3::ZERO), f64::INFINITY);
    }
}
