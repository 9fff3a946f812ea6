//! Colours in linear RGB, and the colour map of scalar fields.

use std::sync::LazyLock;

pub use supple_files::{Colour, from_srgb};

/// The sRGB bytes of a linear colour, clamped to 0..1.
pub(crate) fn to_srgb(colour: Colour) -> [u8; 3] {
    colour.map(|c| {
        let c = c.clamp(0.0, 1.0);
        let encoded = if c <= 0.003_130_8 {
            12.92 * c
        } else {
            1.055 * c.powf(1.0 / 2.4) - 0.055
        };
        (255.0 * encoded).round() as u8
    })
}

/// `a (1 − t) + b t`.
pub(crate) fn mix(a: Colour, b: Colour, t: f32) -> Colour {
    std::array::from_fn(|k| a[k] + (b[k] - a[k]) * t)
}

/// The colour of `t` in 0..1 (clamped), from cream (nothing) through orange and crimson to dark violet.
///
/// A cubic Bézier curve in OKLab (Ottosson 2020) whose lightness falls linearly, walked at constant
/// speed, so that equal steps of `t` look equally large.
pub fn colour_map(t: f64) -> Colour {
    static CURVE: LazyLock<Vec<Colour>> = LazyLock::new(|| {
        evenly([
            [0.930, 0.008, 0.028],
            [0.727, 0.105, 0.225],
            [0.523, 0.330, 0.030],
            [0.320, 0.075, -0.125],
        ])
    });
    at(&CURVE, t)
}

/// The colour of `t` in −1..1 (clamped), from blue through cream (0) to red; made as [`colour_map`] is, both sides
/// darkening alike.
pub fn diverging_map(t: f64) -> Colour {
    static BELOW: LazyLock<Vec<Colour>> = LazyLock::new(|| {
        evenly([
            [0.930, 0.008, 0.028],
            [0.740, -0.090, -0.060],
            [0.550, -0.070, -0.190],
            [0.360, 0.010, -0.150],
        ])
    });
    static ABOVE: LazyLock<Vec<Colour>> = LazyLock::new(|| {
        evenly([
            [0.930, 0.008, 0.028],
            [0.740, 0.120, 0.110],
            [0.550, 0.210, 0.120],
            [0.360, 0.150, 0.050],
        ])
    });
    match t < 0.0 {
        true => at(&BELOW, -t),
        false => at(&ABOVE, t),
    }
}

/// Steps of a table of colours.
const STEPS: usize = 256;

/// A cubic Bézier curve's `[L, a, b]` control points as [`STEPS`] + 1 colours at equal distances along it.
fn evenly(control: [[f64; 3]; 4]) -> Vec<Colour> {
    const FINE: usize = 16 * STEPS;
    let at = |t: f64| -> [f64; 3] {
        let s = 1.0 - t;
        let weights = [s * s * s, 3.0 * s * s * t, 3.0 * s * t * t, t * t * t];
        std::array::from_fn(|k| (0..4).map(|c| weights[c] * control[c][k]).sum())
    };
    let points: Vec<_> = (0..=FINE).map(|i| at(i as f64 / FINE as f64)).collect();
    let mut length = vec![0.0];
    for pair in points.windows(2) {
        let step: f64 = (0..3).map(|k| (pair[1][k] - pair[0][k]).powi(2)).sum();
        length.push(length[length.len() - 1] + step.sqrt());
    }
    let place = |i: usize| {
        let wanted = length[FINE] * i as f64 / STEPS as f64;
        oklab_to_rgb(points[length.partition_point(|&l| l < wanted).min(FINE)])
    };
    (0..=STEPS).map(place).collect()
}

/// The colour at `t` in 0..1 (clamped; NaN is 0) of a table.
fn at(table: &[Colour], t: f64) -> Colour {
    let t = if t.is_nan() { 0.0 } else { t.clamp(0.0, 1.0) };
    let place = t * STEPS as f64;
    let below = (place as usize).min(STEPS - 1);
    mix(
        table[below],
        table[below + 1],
        (place - below as f64) as f32,
    )
}

/// The `k`th of any number of colours that are told apart: hues of OKLCh a golden angle apart, light and dark by
/// turns.
pub fn category_colour(k: usize) -> Colour {
    const LIGHTNESS: [f64; 3] = [0.72, 0.56, 0.84];
    let hue = k as f64 * std::f64::consts::PI * (3.0 - 5f64.sqrt());
    let (sin, cos) = (hue + 0.5).sin_cos();
    oklab_to_rgb([LIGHTNESS[k % 3], 0.13 * cos, 0.13 * sin])
}

/// Linear RGB of OKLab (Björn Ottosson, "A perceptual color space for image processing", 2020).
fn oklab_to_rgb([l, a, b]: [f64; 3]) -> Colour {
    let long = (l + 0.396_337_777_4 * a + 0.215_803_757_3 * b).powi(3);
    let medium = (l - 0.105_561_345_8 * a - 0.063_854_172_8 * b).powi(3);
    let short = (l - 0.089_484_177_5 * a - 1.291_485_548_0 * b).powi(3);
    [
        4.076_741_662_1 * long - 3.307_711_591_3 * medium + 0.230_969_929_2 * short,
        -1.268_438_004_6 * long + 2.609_757_401_1 * medium - 0.341_319_396_5 * short,
        -0.004_196_086_3 * long - 0.703_418_614_7 * medium + 1.707_614_701_0 * short,
    ]
    .map(|c: f64| c.clamp(0.0, 1.0) as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn srgb_bytes_survive_the_round_trip() {
        for byte in 0..=255u32 {
            assert_eq!(to_srgb(from_srgb(byte * 0x010101)), [byte as u8; 3]);
        }
    }

    #[test]
    fn categories_differ_from_their_neighbours() {
        for a in 0..60usize {
            for b in a + 1..(a + 6).min(60) {
                let [a, b] = [a, b].map(|k| to_srgb(category_colour(k)));
                let apart: i32 = (0..3)
                    .map(|c| (i32::from(a[c]) - i32::from(b[c])).abs())
                    .sum();
                assert!(apart > 40, "{a:?} {b:?}");
            }
        }
    }

    #[test]
    fn the_map_darkens_all_the_way() {
        let luminance = |t: f64| {
            let [r, g, b] = colour_map(t);
            0.2126 * r + 0.7152 * g + 0.0722 * b
        };
        for i in 0..64 {
            let t = f64::from(i) / 64.0;
            assert!(luminance(t) > luminance(t + 1.0 / 64.0), "at {t}");
        }
        for i in 0..64 {
            let t = f64::from(i) / 64.0;
            for side in [-1.0, 1.0] {
                let [r, g, b] = diverging_map(side * t);
                let [s, h, c] = diverging_map(side * (t + 1.0 / 64.0));
                let falls = 0.2126 * (r - s) + 0.7152 * (g - h) + 0.0722 * (b - c);
                assert!(falls > 0.0, "diverging at {}", side * t);
            }
        }
        assert_eq!(colour_map(-1.0), colour_map(0.0));
        assert_eq!(colour_map(f64::NAN), colour_map(0.0));
    }
}
