//! Rigid motion given by keys.

use glam::{DMat3, DVec3};
use serde::{Deserialize, Serialize};
use supple::internal::math::{rotation_exp, rotation_log};
use supple::model::Frame;
use supple::{Error, Result};

/// A rigid motion: a track for each axis and one for the rotation, each a list of keys `[time, value…]`
/// (s; m or degrees). Before its first and after its last key a track stands still; between two keys it
/// goes from one to the other by u² (3 − 2u). An empty track is 0.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Motion {
    /// `[s, m]`.
    pub x: Vec<[f64; 2]>,
    /// `[s, m]`.
    pub y: Vec<[f64; 2]>,
    /// `[s, m]`.
    pub z: Vec<[f64; 2]>,
    /// `[s, x, y, z]`: rotation vectors, degrees; between two keys it turns about one axis.
    pub rotation_degrees: Vec<[f64; 4]>,
}

impl Motion {
    /// Where it is at `time`.
    pub fn at(&self, time: f64) -> Frame {
        let axis = |track: &[[f64; 2]]| match around(track, time) {
            None => 0.0,
            Some((a, b, u)) => a[1] + (b[1] - a[1]) * u,
        };
        let vector = |k: &[f64; 4]| DVec3::new(k[1], k[2], k[3]) * std::f64::consts::PI / 180.0;
        let rotation = match around(&self.rotation_degrees, time) {
            None => DMat3::IDENTITY,
            Some((a, b, u)) => {
                let (a, b) = (rotation_exp(vector(a)), rotation_exp(vector(b)));
                rotation_exp(u * rotation_log(b * a.transpose())) * a
            }
        };
        Frame {
            rotation,
            position: DVec3::new(axis(&self.x), axis(&self.y), axis(&self.z)),
        }
    }

    /// Checks that the keys' times rise; `field` names the motion in errors.
    pub(super) fn validate(&self, field: &str) -> Result<()> {
        let tracks = [
            ("x", times(&self.x)),
            ("y", times(&self.y)),
            ("z", times(&self.z)),
            ("rotation_degrees", times(&self.rotation_degrees)),
        ];
        let falling = |t: &Vec<f64>| t.windows(2).any(|pair| pair[0] >= pair[1]);
        match tracks.iter().find(|(_, times)| falling(times)) {
            None => Ok(()),
            Some((name, _)) => Err(Error::invalid(
                format!("{field}.{name}"),
                "the keys' times must rise",
            )),
        }
    }
}

/// The times of a track's keys.
fn times<const N: usize>(track: &[[f64; N]]) -> Vec<f64> {
    track.iter().map(|key| key[0]).collect()
}

/// The keys around `time` and how far it is from the first to the second, smoothed: u² (3 − 2u).
fn around<const N: usize>(track: &[[f64; N]], time: f64) -> Option<(&[f64; N], &[f64; N], f64)> {
    let after = track.partition_point(|k| k[0] <= time);
    let (first, last) = (track.first()?, track.last()?);
    match after {
        0 => Some((first, first, 0.0)),
        n if n == track.len() => Some((last, last, 0.0)),
        n => {
            let (a, b) = (&track[n - 1], &track[n]);
            let u = (time - a[0]) / (b[0] - a[0]);
            Some((a, b, u * u * (3.0 - 2.0 * u)))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    /// The bone press as its benchmark states it.
    #[test]
    fn the_bone_press_is_expressed_exactly() {
        let smooth = |u: f64| {
            let u = u.clamp(0.0, 1.0);
            u * u * (3.0 - 2.0 * u)
        };
        let motion = Motion {
            x: vec![[1.0, 0.100], [1.5, 0.140]],
            z: vec![[0.25, 0.075], [0.75, 0.058], [1.5, 0.058], [1.7, 0.098]],
            ..Motion::default()
        };
        for step in 0..=250 {
            let t = 0.01 * f64::from(step);
            let z = 0.075 - 0.017 * smooth((t - 0.25) / 0.5) + 0.04 * smooth((t - 1.5) / 0.2);
            let x = 0.100 + 0.040 * smooth((t - 1.0) / 0.5);
            let expected = DVec3::new(x, 0.0, z);
            assert!(
                (motion.at(t).position - expected).length() < 1e-15,
                "t = {t}"
            );
        }
    }

    #[test]
    fn rotations_turn_about_one_axis() {
        let motion = Motion {
            rotation_degrees: vec![[0.0, 0.0, 0.0, 10.0], [2.0, 0.0, 0.0, 70.0]],
            ..Motion::default()
        };
        let angle = |t: f64| rotation_log(motion.at(t).rotation).z.to_degrees();
        assert_relative_eq!(angle(-1.0), 10.0, epsilon = 1e-9);
        assert_relative_eq!(angle(1.0), 40.0, epsilon = 1e-9);
        assert_relative_eq!(angle(9.0), 70.0, epsilon = 1e-9);
        assert_eq!(Motion::default().at(1.0), Frame::IDENTITY);
    }
}
