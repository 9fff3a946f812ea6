//! Animated properties between their keys (glTF 2.0, §3.11 and appendix C).

use super::container::File;
use super::document::{Channel, Sampler};
use glam::{DVec3, DVec4};
use supple::Result;

/// What an animation moves of a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Property {
    Translation,
    Rotation,
    Scale,
}

/// What lies between keys.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Interpolation {
    Step,
    Linear,
    CubicSpline,
}

/// A property of a node over time.
#[derive(Debug)]
pub(super) struct Track {
    pub node: usize,
    pub property: Property,
    interpolation: Interpolation,
    /// Rising, s.
    pub times: Vec<f64>,
    /// For each key its value; of cubic splines tangent in, value and tangent out. Three or four numbers.
    values: Vec<DVec4>,
}

impl Track {
    /// The track of a channel; nothing where it moves no node, or morph weights.
    pub fn read(
        file: &File,
        field: &str,
        channel: &Channel,
        samplers: &[Sampler],
    ) -> Result<Option<Self>> {
        let broken = |problem: &str| file.broken(field, problem);
        let property = match channel.target.path.as_str() {
            "translation" => Property::Translation,
            "rotation" => Property::Rotation,
            "scale" => Property::Scale,
            _ => return Ok(None),
        };
        let Some(node) = channel.target.node else {
            return Ok(None);
        };
        let found = file.document.nodes.get(node);
        let found = found.ok_or_else(|| broken("its node is not there"))?;
        if found.matrix.is_some() {
            return Err(broken("animates a node that has a matrix"));
        }
        let sampler = samplers.get(channel.sampler);
        let sampler = sampler.ok_or_else(|| broken("its sampler is not there"))?;
        let interpolation = match sampler.interpolation.as_deref() {
            None | Some("LINEAR") => Interpolation::Linear,
            Some("STEP") => Interpolation::Step,
            Some("CUBICSPLINE") => Interpolation::CubicSpline,
            Some(_) => return Err(broken("its interpolation is none of glTF's")),
        };
        let times: Vec<f64> = file.vectors::<1>(sampler.input)?.as_flattened().to_vec();
        if times.is_empty() || !times.is_sorted_by(|a, b| a < b) {
            return Err(broken("its key times do not rise"));
        }
        let values: Vec<DVec4> = if property == Property::Rotation {
            let all = file.vectors::<4>(sampler.output)?;
            all.into_iter().map(DVec4::from_array).collect()
        } else {
            let all = file.vectors::<3>(sampler.output)?;
            all.iter()
                .map(|[x, y, z]| DVec4::new(*x, *y, *z, 0.0))
                .collect()
        };
        let each = if interpolation == Interpolation::CubicSpline {
            3
        } else {
            1
        };
        if values.len() != each * times.len() {
            return Err(broken("has another number of values than its keys need"));
        }
        let track = Self {
            node,
            property,
            interpolation,
            times,
            values,
        };
        let zero = |k: usize| track.key(k).length() < 1e-6;
        if property == Property::Rotation && (0..track.times.len()).any(zero) {
            return Err(broken("a rotation is no unit quaternion"));
        }
        Ok(Some(track))
    }

    /// Value at key `k`.
    fn key(&self, k: usize) -> DVec4 {
        match self.interpolation {
            Interpolation::CubicSpline => self.values[3 * k + 1],
            _ => self.values[k],
        }
    }

    /// The least and the greatest number of any key.
    pub fn range(&self) -> (f64, f64) {
        let keys = (0..self.times.len()).map(|k| self.key(k).truncate());
        keys.fold(
            (f64::INFINITY, f64::NEG_INFINITY),
            |(least, greatest), v| (least.min(v.min_element()), greatest.max(v.max_element())),
        )
    }

    /// How far a number of any key is from that of `value`, at most.
    pub fn farthest_from(&self, value: DVec3) -> f64 {
        let keys = (0..self.times.len()).map(|k| self.key(k).truncate());
        keys.map(|v| (v - value).abs().max_element())
            .fold(0.0, f64::max)
    }

    /// Value at `time`, s; quaternions have unit length. It stands still before the first key and after
    /// the last.
    pub fn sample(&self, time: f64) -> DVec4 {
        let after = self.times.partition_point(|t| *t <= time);
        let value = match after.checked_sub(1) {
            None => self.key(0),
            Some(k) if after == self.times.len() => self.key(k),
            Some(k) => self.between(k, time),
        };
        match self.property {
            Property::Rotation => value.normalize_or(DVec4::W),
            _ => value,
        }
    }

    fn between(&self, k: usize, time: f64) -> DVec4 {
        let (start, end) = (self.times[k], self.times[k + 1]);
        let length = end - start;
        let u = (time - start) / length;
        let (a, b) = (self.key(k), self.key(k + 1));
        match self.interpolation {
            Interpolation::Step => a,
            Interpolation::Linear if self.property == Property::Rotation => {
                slerp(a.normalize(), b.normalize(), u)
            }
            Interpolation::Linear => a.lerp(b, u),
            // v(u) = (2u³ − 3u² + 1) v_k + T (u³ − 2u² + u) out_k + (3u² − 2u³) v_{k+1} + T (u³ − u²) in_{k+1}
            Interpolation::CubicSpline => {
                let (u2, u3) = (u * u, u * u * u);
                let (out, into) = (self.values[3 * k + 2], self.values[3 * k + 3]);
                (2.0 * u3 - 3.0 * u2 + 1.0) * a
                    + length * (u3 - 2.0 * u2 + u) * out
                    + (3.0 * u2 - 2.0 * u3) * b
                    + length * (u3 - u2) * into
            }
        }
    }
}

/// The shorter arc between unit quaternions; exact where glam's becomes a chord.
fn slerp(a: DVec4, b: DVec4, u: f64) -> DVec4 {
    let b = if a.dot(b) < 0.0 { -b } else { b };
    let angle = 2.0 * (a - b).length().atan2((a + b).length());
    if angle < 1e-9 {
        return a.lerp(b, u);
    }
    (((1.0 - u) * angle).sin() * a + (u * angle).sin() * b) / angle.sin()
}
