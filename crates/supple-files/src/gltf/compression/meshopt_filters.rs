//! Meshopt's filters, which undo what made attributes easier to compress (KHR_meshopt_compression, appendix B).

use super::Problem;
use std::f32::consts::FRAC_1_SQRT_2;

/// Filters elements of `stride` bytes in place. Numbers out of their range become some number.
pub(super) fn apply(filter: &str, bytes: &mut [u8], stride: usize) -> Result<(), Problem> {
    let four = |short: bool| if short { 8 } else { 4 };
    match (filter, stride) {
        ("NONE", _) => {}
        ("OCTAHEDRAL", 4 | 8) => each(bytes, stride == four(true), octahedral),
        ("QUATERNION", 8) => each(bytes, true, |v, _| quaternion(v)),
        ("COLOR", 4 | 8) => each(bytes, stride == four(true), colour),
        ("EXPONENTIAL", _) => {
            for word in bytes.as_chunks_mut::<4>().0 {
                *word = exponential(i32::from_le_bytes(*word)).to_le_bytes();
            }
        }
        _ => return Err(format!("filter {filter} of elements of {stride} bytes")),
    }
    Ok(())
}

/// Applies a filter of four numbers, signed ones of 8 or 16 bits; `top` is the largest of these.
fn each(bytes: &mut [u8], short: bool, filter: impl Fn([i32; 4], i32) -> [i32; 4]) {
    if short {
        for element in bytes.as_chunks_mut::<8>().0 {
            let at = |k: usize| i32::from(i16::from_le_bytes([element[2 * k], element[2 * k + 1]]));
            let filtered = filter([0, 1, 2, 3].map(at), i32::from(i16::MAX));
            for (pair, v) in element.chunks_exact_mut(2).zip(filtered) {
                pair.copy_from_slice(&(v as i16).to_le_bytes());
            }
        }
    } else {
        for element in bytes.as_chunks_mut::<4>().0 {
            let filtered = filter(element.map(|b| i32::from(b as i8)), i32::from(i8::MAX));
            *element = filtered.map(|v| v as u8);
        }
    }
}

/// A unit vector from its place on an octahedron, in units of the third number.
fn octahedral([x, y, one, rest]: [i32; 4], top: i32) -> [i32; 4] {
    let one_over = 1.0 / one as f32;
    let (x, y) = (x as f32 * one_over, y as f32 * one_over);
    let z = 1.0 - x.abs() - y.abs();
    // The lower half is folded outward.
    let fold = z.min(0.0);
    let (x, y) = (x - fold.copysign(x), y - fold.copysign(y));
    let scale = top as f32 / (x * x + y * y + z * z).sqrt();
    let [x, y, z] = [x, y, z].map(|c| (c * scale).round() as i32);
    [x, y, z, rest]
}

/// A unit quaternion of positive largest component, from the three others and that one's number.
fn quaternion([x, y, z, one]: [i32; 4]) -> [i32; 4] {
    const TOP: f32 = 32767.0;
    let largest = (one & 3) as usize;
    let unit = FRAC_1_SQRT_2 / (one | 3) as f32;
    let [x, y, z] = [x, y, z].map(|c| c as f32 * unit);
    let w = (1.0 - x * x - y * y - z * z).max(0.0).sqrt();
    let mut out = [0; 4];
    for (k, c) in [w, x, y, z].into_iter().enumerate() {
        out[(largest + k) % 4] = (c * TOP).round() as i32;
    }
    out
}

/// 2ᵉ m, with e in the highest 8 bits and m in the others.
fn exponential(v: i32) -> f32 {
    let (exponent, mantissa) = (v >> 24, v << 8 >> 8);
    // 2ᵉ has no digits but its exponent's.
    let power = f32::from_bits(((exponent.clamp(-126, 127) + 127) as u32) << 23);
    power * mantissa as f32
}

/// Red, green, blue and opacity from luminance, two differences of colours, and opacity below the bit that says how many
/// bits each has.
fn colour(v: [i32; 4], top: i32) -> [i32; 4] {
    // Luminance and opacity have no sign.
    let all = 2 * top + 1;
    let [y, co, cg, a] = [v[0] & all, v[1], v[2], v[3] & all];
    let bits = 32 - a.leading_zeros();
    let full = (1i32 << bits) - 1;
    let a = a & (full >> 1);
    let a = a << 1 | a & 1;
    let scale = all as f32 / full.max(1) as f32;
    [y + co - cg, y + cg, y - co - cg, a].map(|c| (c as f32 * scale).round() as i32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f32::consts::SQRT_2;
    use supple::internal::math::Random;

    fn shorts(values: [i16; 4]) -> Vec<u8> {
        values.iter().flat_map(|v| v.to_le_bytes()).collect()
    }

    fn filtered(filter: &str, mut bytes: Vec<u8>) -> Vec<u8> {
        let stride = bytes.len();
        apply(filter, &mut bytes, stride).unwrap();
        bytes
    }

    fn filtered_shorts(filter: &str, values: [i16; 4]) -> [i16; 4] {
        let bytes = filtered(filter, shorts(values));
        std::array::from_fn(|k| i16::from_le_bytes([bytes[2 * k], bytes[2 * k + 1]]))
    }

    /// Unit vectors by an octahedron of as many bits as there may be, folded as the specification has it.
    #[test]
    fn vectors_by_an_octahedron() {
        let mut random = Random::new(5);
        for bits in [4, 8, 12, 16] {
            let one = (1 << (bits - 1)) - 1;
            for _ in 0..200 {
                let v = random.vector(1.0).normalize().as_vec3();
                let p = v / (v.x.abs() + v.y.abs() + v.z.abs());
                let (x, y) = match v.z < 0.0 {
                    false => (p.x, p.y),
                    true => (
                        (1.0 - p.y.abs()).copysign(p.x),
                        (1.0 - p.x.abs()).copysign(p.y),
                    ),
                };
                let [x, y] = [x, y].map(|c| (c * one as f32).round() as i16);
                // Half a step of an octahedron is at most √3/2 · √2 of one on the sphere, 2 at its corners.
                let most = 2.0 / one as f32 + 2.0 / 127.0;
                let [a, b, c, rest] = filtered_shorts("OCTAHEDRAL", [x, y, one as i16, -7]);
                let found = glam::Vec3::new(a as f32, b as f32, c as f32) / 32767.0;
                assert!(
                    found.distance(v) < most - 2.0 / 127.0 + 1e-4,
                    "{bits}: {found} {v}"
                );
                assert_eq!(rest, -7);
                if bits <= 8 {
                    let bytes = filtered("OCTAHEDRAL", vec![x as u8, y as u8, one as u8, 9]);
                    let [a, b, c] = [0, 1, 2].map(|k| f32::from(bytes[k] as i8) / 127.0);
                    assert!(glam::Vec3::new(a, b, c).distance(v) < most);
                    assert_eq!(bytes[3], 9);
                }
            }
        }
    }

    #[test]
    fn quaternions_without_their_largest() {
        let mut random = Random::new(6);
        for bits in [6, 12, 16] {
            let one = (1i32 << (bits - 1)) - 1;
            for _ in 0..200 {
                let q = random.vector(1.0).extend(random.vector(1.0).x).normalize();
                let q = q.as_vec4().to_array();
                let largest = (0..4)
                    .max_by(|a, b| q[*a].abs().total_cmp(&q[*b].abs()))
                    .unwrap();
                let q = q.map(|c| c * q[largest].signum());
                let part = |k: usize| (q[(largest + k) % 4] * SQRT_2 * one as f32).round() as i16;
                let coded = [
                    part(1),
                    part(2),
                    part(3),
                    (one & !3) as i16 | largest as i16,
                ];
                let found = filtered_shorts("QUATERNION", coded).map(|c| f32::from(c) / 32767.0);
                // Half a step of each of three, and what that makes of the largest, which is 1/2 at least.
                let step = 0.5 / (SQRT_2 * one as f32);
                for (k, (a, b)) in found.iter().zip(q).enumerate() {
                    let most = if k == largest { 6.0 * step } else { step };
                    assert!((a - b).abs() < most + 5e-5, "{bits}: {found:?} {q:?}");
                }
            }
        }
    }

    #[test]
    fn floats_by_mantissa_and_exponent() {
        for (exponent, mantissa, value) in [
            (0, 5, 5.0),
            (-3, -9, -1.125),
            (100, 1, 1.2676506e30),
            (-100, 0x7f_ffff, 8388607.0 * 7.888609e-31),
            (-24, -0x80_0000, -0.5),
        ] {
            let coded = ((exponent as u32) << 24 | (mantissa as u32 & 0xff_ffff)).to_le_bytes();
            let found = filtered("EXPONENTIAL", coded.to_vec());
            assert_eq!(f32::from_le_bytes(found.try_into().unwrap()), value);
        }
    }

    /// Colours of K bits, by the inverse of the specification's formulas.
    #[test]
    fn colours_by_luminance() {
        for bits in [5, 8] {
            let full = (1i32 << bits) - 1;
            for (r, g, b, a) in [
                (0, 0, 0, 0),
                (full, full, full, full),
                (full, 0, 3, 2),
                (1, full, 7, 9),
            ] {
                // y + co − cg, y + cg, y − co − cg, of numbers for which halves are whole.
                let (r, b) = (r & !1, b & !1);
                let co = (r - b) / 2;
                let g = (g & !1) | (((r + b) / 2) & 1);
                let cg = (g - (r + b) / 2) / 2;
                let y = g - cg;
                let coded = [y, co, cg, 1 << (bits - 1) | a >> 1];
                let found = filtered("COLOR", coded.map(|v| v as u8).to_vec());
                let scale = 255.0 / full as f32;
                let wide = |v: i32| (v as f32 * scale).round() as u8;
                let a = (a >> 1) << 1 | (a >> 1 & 1);
                assert_eq!(found, [r, g, b, a].map(wide), "{bits}: {r} {g} {b} {a}");
            }
        }
    }

    #[test]
    fn anything_is_filtered_to_something() {
        let mut random = Random::new(7);
        for filter in ["OCTAHEDRAL", "QUATERNION", "COLOR", "EXPONENTIAL"] {
            for _ in 0..2000 {
                let bytes = (0..8).map(|_| random.index(256) as u8).collect();
                assert_eq!(filtered(filter, bytes).len(), 8);
            }
        }
        assert!(apply("OCTAHEDRAL", &mut [0; 12], 12).is_err());
        assert!(apply("QUATERNION", &mut [0; 4], 4).is_err());
    }
}
