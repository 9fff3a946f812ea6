//! Pose blend shapes as a step reads them: four points at a time, whose sums stay in registers, with only the
//! columns that move one of the four. On most bodies a joint's correctives are local: of the sample body's 207
//! columns a point has 8 that are not zero, and its four have 19.

use crate::math::Rows;
use crate::model::PoseBlend;
use glam::DVec3;

/// Points of a group.
pub const GROUP: usize = 4;

/// A feature, and its column at the points of a group.
type GroupColumn = (u32, [[f32; 3]; GROUP]);

/// The columns of a set of points, group by group.
#[derive(Clone, Debug, Default)]
pub struct PoseColumns(Rows<GroupColumn>);

impl PoseColumns {
    /// The columns of `points` points.
    pub fn new(blend: &PoseBlend, points: usize) -> Self {
        let group = |first: usize| {
            let count = GROUP.min(points - first);
            (0..blend.features).filter_map(move |k| {
                let column = &blend.columns[k * points + first..][..count];
                let mut padded = [[0.0; 3]; GROUP];
                padded[..count].copy_from_slice(column);
                (padded != [[0.0; 3]; GROUP]).then_some((k as u32, padded))
            })
        };
        Self((0..points).step_by(GROUP).map(group).collect())
    }

    /// What [`pose_blend()`](super::pose_blend::pose_blend) says of the points `first..first + out.len()`, to the bit; `first` is
    /// a multiple of [`GROUP`].
    pub fn blend(&self, position: &[DVec3], feature: &[f64], first: usize, out: &mut [DVec3]) {
        out.copy_from_slice(&position[first..first + out.len()]);
        for (group, out) in (first / GROUP..).zip(out.chunks_mut(GROUP)) {
            let out: &mut [f64] = bytemuck::cast_slice_mut(out);
            let mut sums = [0.0; 3 * GROUP];
            sums[..out.len()].copy_from_slice(out);
            for (k, column) in self.0.row(group) {
                let value = feature[*k as usize];
                for (sum, &x) in sums.iter_mut().zip(column.as_flattened()) {
                    *sum += value * f64::from(x);
                }
            }
            out.copy_from_slice(&sums[..out.len()]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Random;
    use crate::potential::cpu::pose_blend::pose_blend;

    #[test]
    fn groups_of_columns_give_the_bits_of_whole_columns() {
        let random = &mut Random::new(17);
        // The last group is short; some columns are zero in some groups, the first joint's everywhere at rest.
        for (points, features) in [(8, 18), (23, 27), (3, 9), (6, 0)] {
            let mut blend = PoseBlend {
                features,
                columns: vec![[0.0; 3]; features * points],
            };
            for (at, column) in blend.columns.iter_mut().enumerate() {
                if !(at / points + at % points / GROUP).is_multiple_of(3) {
                    *column = random.vector(1e-2).as_vec3().to_array();
                }
            }
            let position: Vec<DVec3> = (0..points).map(|_| random.vector(1.0)).collect();
            let mut feature: Vec<f64> = (0..features).map(|_| random.uniform(-1.0, 1.0)).collect();
            feature.iter_mut().take(9).for_each(|x| *x = 0.0);
            let (mut wanted, mut found) = (vec![DVec3::NAN; points], vec![DVec3::NAN; points]);
            pose_blend(&position, &blend, &feature, 0, &mut wanted);
            let columns = PoseColumns::new(&blend, points);
            columns.blend(&position, &feature, 0, &mut found);
            assert_eq!(found, wanted);
            assert!(features < 10 || wanted != position);
            let tail = points.min(GROUP);
            columns.blend(&position, &feature, tail, &mut found[tail..]);
            assert_eq!(found, wanted);
        }
    }
}
