//! The nearest of many points.

use glam::DVec3;
use rstar::RTree;
use rstar::primitives::GeomWithData;

/// The nearest of many points, found through a tree of boxes (an R*-tree).
pub struct NearestPoint<'a> {
    points: &'a [DVec3],
    tree: RTree<GeomWithData<[f64; 3], u32>>,
}

impl<'a> NearestPoint<'a> {
    /// Sorts `points` into boxes; what is not finite is near to nothing.
    pub fn new(points: &'a [DVec3]) -> Self {
        let numbered = points.iter().zip(0..).filter(|(p, _)| p.is_finite());
        let boxes = numbered.map(|(p, i)| GeomWithData::new(p.to_array(), i));
        Self {
            points,
            tree: RTree::bulk_load(boxes.collect()),
        }
    }

    /// Distance from `p` to the nearest point, m; ∞ where there is none.
    pub fn distance(&self, p: DVec3) -> f64 {
        self.nearest(p)
            .map_or(f64::INFINITY, |(_, distance)| distance)
    }

    /// Index of the point nearest to `p` (the lowest of equals) and its distance, m.
    pub fn nearest(&self, p: DVec3) -> Option<(u32, f64)> {
        if !p.is_finite() {
            return None;
        }
        let nearest = self.tree.nearest_neighbors(&p.to_array());
        let index = nearest.iter().map(|n| n.data).min()?;
        Some((index, self.points[index as usize].distance(p)))
    }

    /// [`NearestPoint::nearest`] where that is no farther than `most`, m. What is far from all points costs nothing.
    pub fn nearest_within(&self, p: DVec3, most: f64) -> Option<(u32, f64)> {
        let outside = self.tree.root().envelope().distance_2(&p.to_array());
        // An empty tree's box is at no distance. What rounding makes of the borders is decided below.
        if outside.is_nan() || outside > most * most * (1.0 + 1e-12) {
            return None;
        }
        self.nearest(p).filter(|(_, distance)| *distance <= most)
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
            // Each twice, so that there are equals.
            let points: Vec<DVec3> = (0..count).map(|_| random.vector(1.0)).collect();
            let points = points.repeat(2);
            let search = NearestPoint::new(&points);
            for _ in 0..200 {
                let p = random.vector(2.0);
                let squares = points.iter().map(|q| q.distance_squared(p));
                let expected = squares.fold(f64::INFINITY, f64::min).sqrt();
                let (index, distance) = search.nearest(p).unwrap();
                let first = points.iter().position(|q| q.distance(p) == expected);
                assert_eq!((Some(index as usize), distance), (first, expected));
                let within = |most| search.nearest_within(p, most);
                assert_eq!(within(expected), Some((index, distance)));
                assert_eq!(within(0.999 * expected), None);
            }
            assert_eq!(search.nearest(DVec3::NAN), None);
        }
        assert_eq!(
            NearestPoint::new(&[]).nearest_within(DVec3::ZERO, 1.0),
            None
        );
        assert_eq!(NearestPoint::new(&[]).distance(DVec3::ZERO), f64::INFINITY);
    }
}
