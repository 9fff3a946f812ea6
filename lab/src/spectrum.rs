//! Which waves a record is made of.

use glam::{DMat3, DVec3};
use std::f64::consts::TAU;

/// A value at a place or a time, and how much it counts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Sample {
    pub at: f64,
    pub value: f64,
    pub weight: f64,
}

/// Amplitude of the wave of each of `frequencies` (waves a unit of [`Sample::at`]) in a record that need not be even:
///
/// a(f) = 2 |Σ w h (v − p) exp(−2πi f t)| / Σ w h
///
/// with p the parabola that fits v best (bends and drifts are no waves) and Hann's window h over the record.
pub(super) fn spectrum(
    samples: &[Sample],
    frequencies: impl IntoIterator<Item = f64>,
) -> Vec<(f64, f64)> {
    let ends = (samples.iter()).fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), s| {
        (low.min(s.at), high.max(s.at))
    });
    let length = (ends.1 - ends.0).max(f64::MIN_POSITIVE);
    let powers = |at: f64| {
        let u = 2.0 * (at - ends.0) / length - 1.0;
        DVec3::new(1.0, u, u * u)
    };
    let (mut normal, mut right) = (DMat3::ZERO, DVec3::ZERO);
    for s in samples {
        let p = powers(s.at);
        normal += s.weight * DMat3::from_cols(p.x * p, p.y * p, p.z * p);
        right += s.weight * s.value * p;
    }
    let parabola = match normal.determinant().abs() > 0.0 {
        true => normal.inverse() * right,
        false => DVec3::ZERO,
    };
    let windowed: Vec<(f64, f64, f64)> = samples
        .iter()
        .map(|s| {
            let hann = 0.5 - 0.5 * (TAU * (s.at - ends.0) / length).cos();
            let weight = s.weight * hann;
            (
                s.at,
                weight * (s.value - parabola.dot(powers(s.at))),
                weight,
            )
        })
        .collect();
    let total: f64 = windowed
        .iter()
        .map(|s| s.2)
        .sum::<f64>()
        .max(f64::MIN_POSITIVE);
    let amplitude = |f: f64| {
        let (sin, cos) = windowed.iter().fold((0.0, 0.0), |(sin, cos), (at, v, _)| {
            let (s, c) = (TAU * f * at).sin_cos();
            (sin + v * s, cos + v * c)
        });
        (f, 2.0 * sin.hypot(cos) / total)
    };
    frequencies.into_iter().map(amplitude).collect()
}

/// The wave of the largest amplitude: its frequency and amplitude; NaN of none.
pub(super) fn peak(spectrum: &[(f64, f64)]) -> (f64, f64) {
    let largest = spectrum.iter().copied().max_by(|a, b| a.1.total_cmp(&b.1));
    largest.unwrap_or((f64::NAN, f64::NAN))
}

/// `count` + 1 numbers from `low` to `high`.
pub(super) fn between(low: f64, high: f64, count: usize) -> impl Iterator<Item = f64> {
    (0..=count).map(move |k| low + (high - low) * k as f64 / count as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use supple::internal::math::Random;

    #[test]
    fn a_wave_on_a_bend_is_found_in_an_uneven_record() {
        let mut random = Random::new(5);
        let samples: Vec<Sample> = (0..400)
            .map(|_| {
                let at = random.uniform(0.0, 1.0);
                let wave = 0.3 * (TAU * 7.0 * at + 0.4).sin();
                Sample {
                    at,
                    value: wave + 2.0 - 5.0 * at + 4.0 * at * at,
                    weight: random.uniform(0.5, 1.5),
                }
            })
            .collect();
        let (frequency, amplitude) = peak(&spectrum(&samples, between(2.0, 20.0, 360)));
        // Half a main lobe of Hann's window is two waves a record; noise of 400 samples is a twentieth.
        assert!((frequency - 7.0).abs() < 0.2, "{frequency}");
        assert!((amplitude / 0.3 - 1.0).abs() < 0.1, "{amplitude}");
        assert!(peak(&[]).0.is_nan());
    }
}
