//! The modal basis: the tissue's lowest vibrations about fixed bones.
//!
//! ```text
//! K v = ω² M v,    vᵢᵀ M vⱼ = 0 for i ≠ j
//! ```
//!
//! K and M are those of [`super::rest_stiffness`] and [`super::lumped_mass`]. The lowest pairs are the largest
//! of M^½ K⁻¹ M^½ (shift–invert at 0), found by block Lanczos. A mode is a field of vectors with one
//! amplitude; three modes make a block, N = \[v₁ v₂ v₃\], so a handle's φ is three amplitudes. Modes are scaled to a
//! largest displacement of 1: amplitudes are in metres, as Newton's tolerance wants them.

use super::Subspace;
use super::linear_elasticity::{free_columns, lumped_mass, rest_stiffness};
use crate::math::{SparseFactor, largest_eigenpairs};
use glam::{DMat3, DVec3};
use std::f64::consts::TAU;
use supple::model::Avatar;
use supple::{Error, Result};

/// Residual of an eigenpair of M^½ K⁻¹ M^½, relative to its largest eigenvalue.
const TOLERANCE: f64 = 1e-9;

/// The lowest modes of an avatar's tissue, and the space that they span.
#[derive(Clone, Debug)]
pub struct Modes {
    /// ω/2π of each mode, Hz, rising.
    pub frequencies: Vec<f64>,
    /// The space: modes 3h, 3h + 1 and 3h + 2 are the columns of handle h's blocks.
    pub space: Subspace,
}

/// The `count` lowest modes of `avatar`'s tissue with its bones fixed; the same bits every time.
///
/// # Errors
/// [`Error::Invalid`] where `count` is not a positive multiple of 3, or not below a third of the free nodes' DoFs;
/// [`Error::Solve`] where tissue hangs on no bone, so that K is singular, or Lanczos does not converge.
pub fn modal(avatar: &Avatar, count: usize) -> Result<Modes> {
    if count == 0 || !count.is_multiple_of(3) {
        let problem = format!("{count}: modes come three to a block, so take a multiple of 3");
        return Err(Error::invalid("count", problem));
    }
    let mass = lumped_mass(avatar);
    if count > mass.len() {
        let problem = format!("{count} modes of {} free nodes", mass.len());
        return Err(Error::invalid("count", problem));
    }
    let roots: Vec<f64> = mass.iter().flat_map(|m| [m.sqrt(); 3]).collect();
    let factor = SparseFactor::new(&rest_stiffness(avatar), "modal analysis")?;
    let apply = |x: &[f64], y: &mut [f64]| {
        let n = roots.len();
        let load = |j: usize, b: &mut [f64]| {
            let x = x[j * n..].iter().zip(&roots);
            b.iter_mut().zip(x).for_each(|(b, (x, r))| *b = x * r);
        };
        let solved = factor.solve_each(x.len() / n, load, |_, solved| solved.to_vec());
        for (y, solved) in y.chunks_exact_mut(n).zip(solved) {
            let solved = solved.iter().zip(&roots);
            y.iter_mut().zip(solved).for_each(|(y, (s, r))| *y = s * r);
        }
    };
    let pairs = largest_eigenpairs(roots.len(), count, TOLERANCE, "modal analysis", &apply)?;

    let (columns, free) = free_columns(&avatar.layer);
    let modes: Vec<Vec<DVec3>> = { pairs.iter() }
        .map(|(_, y)| scaled_mode(y, &roots))
        .collect();
    debug_assert!(modes.iter().all(|m| m.len() == free));
    let block = |h: usize, c: u32| {
        let [x, y, z] = [0, 1, 2].map(|k| modes[3 * h + k][c as usize]);
        (h as u32, DMat3::from_cols(x, y, z))
    };
    let nodes = columns.iter().map(|column| {
        let blocks = column.map(|c| (0..count / 3).map(move |h| (h, c)));
        blocks.into_iter().flatten().map(|(h, c)| block(h, c))
    });
    let centre = avatar.layer.mesh.nodes.iter().sum::<DVec3>() / columns.len() as f64;
    Ok(Modes {
        // A mode stands nowhere: its handle is put into the middle.
        space: Subspace::new(avatar, vec![centre; count / 3], nodes.collect())?,
        frequencies: pairs
            .iter()
            .map(|(theta, _)| theta.sqrt().recip() / TAU)
            .collect(),
    })
}

/// v = M^−½ y at each free node, scaled to a largest displacement of 1; its largest component is positive.
fn scaled_mode(y: &[f64], roots: &[f64]) -> Vec<DVec3> {
    let v: Vec<f64> = y.iter().zip(roots).map(|(y, r)| y / r).collect();
    let nodes: Vec<DVec3> = v.chunks_exact(3).map(DVec3::from_slice).collect();
    let largest = nodes.iter().fold(DVec3::ZERO, |largest, v| {
        if v.length_squared() > largest.length_squared() {
            *v
        } else {
            largest
        }
    });
    let sign = largest[largest.abs().max_position()].signum();
    let scale = sign / largest.length().max(f64::MIN_POSITIVE);
    nodes.iter().map(|v| *v * scale).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Limb;
    use crate::subspace::test_body::{baked, box_with_jitter, clamped_box};

    /// The modes as fields over the free nodes, of length 1 in the metric of the masses.
    fn fields(avatar: &Avatar, modes: &Modes) -> Vec<Vec<f64>> {
        let mass = lumped_mass(avatar);
        (0..modes.frequencies.len())
            .map(|k| {
                let rows = modes.space.nodes().iter().filter(|row| !row.is_empty());
                let v: Vec<f64> = rows
                    .flat_map(|row| row[k / 3].1.col(k % 3).to_array())
                    .collect();
                let length = product(&v, &v, &mass).sqrt();
                v.iter().map(|x| x / length).collect()
            })
            .collect()
    }

    /// aᵀ M b.
    fn product(a: &[f64], b: &[f64], mass: &[f64]) -> f64 {
        let terms = a.iter().zip(b).enumerate();
        terms.map(|(i, (a, b))| mass[i / 3] * a * b).sum()
    }

    /// The mode that looks most like `shape`, at the free nodes, and |cos| of the angle between them.
    fn most_like(avatar: &Avatar, modes: &Modes, shape: impl Fn(DVec3) -> DVec3) -> (usize, f64) {
        let mass = lumped_mass(avatar);
        let layer = &avatar.layer;
        let free = layer.mesh.nodes.iter().zip(&layer.bone_of_node);
        let wanted: Vec<f64> = (free.filter(|(_, bone)| bone.is_none()))
            .flat_map(|(x, _)| shape(*x).to_array())
            .collect();
        let length = product(&wanted, &wanted, &mass).sqrt();
        let overlap = |v: &Vec<f64>| (product(v, &wanted, &mass) / length).abs();
        let found = fields(avatar, modes);
        let overlaps = found.iter().map(overlap).enumerate();
        overlaps.fold((0, 0.0), |best, o| if o.1 > best.1 { o } else { best })
    }

    #[test]
    fn pairs_solve_the_eigenproblem_and_are_orthonormal_and_rise() {
        let avatar = clamped_box([5, 4, 4], 0.4);
        let modes = modal(&avatar, 30).unwrap();
        assert_eq!(modes.space.avatar().handles.len(), 10);
        assert!(modes.frequencies.is_sorted() && modes.frequencies[0] > 1.0);
        let (stiffness, mass) = (rest_stiffness(&avatar), lumped_mass(&avatar));
        let factor = SparseFactor::new(&stiffness, "test").unwrap();
        let fields = fields(&avatar, &modes);
        for (i, (v, frequency)) in fields.iter().zip(&modes.frequencies).enumerate() {
            let square = (TAU * frequency).powi(2);
            // ω² K⁻¹ M v − v in the metric of the masses: the tolerance is relative to the largest 1/ω².
            let load: Vec<f64> = v
                .iter()
                .enumerate()
                .map(|(k, v)| square * mass[k / 3] * v)
                .collect();
            let solved = factor.solve(&load);
            let rest: Vec<f64> = solved.iter().zip(v).map(|(s, v)| s - v).collect();
            let ratio = (frequency / modes.frequencies[0]).powi(2);
            let residual = product(&rest, &rest, &mass).sqrt();
            assert!(residual < 2.0 * TOLERANCE * ratio, "mode {i}: {residual:e}");
            // Rayleigh's quotient sees the square of the residual.
            let forces = stiffness.multiply(v);
            let quotient: f64 = forces.iter().zip(v).map(|(f, v)| f * v).sum();
            approx::assert_relative_eq!(quotient, square, max_relative = 1e-9);
            for (j, w) in fields.iter().enumerate().take(i) {
                // With lengths of 1 this is Gram's matrix: near the identity, so the rank is full.
                let cosine = product(v, w, &mass);
                assert!(cosine.abs() < 1e-10, "modes {i} and {j}: {cosine:e}");
            }
        }
        assert_eq!(modal(&avatar, 30).unwrap().frequencies, modes.frequencies);
    }

    #[test]
    fn a_bar_of_no_poissons_ratio_vibrates_along_as_a_string_does() {
        // u = sin(π z / 2L) e_z leaves the sides free of traction: ω = (π / 2L) √(E/ρ).
        let cells = [3, 3, 16];
        let avatar = box_with_jitter(cells, 0.0, 0.0);
        let modes = modal(&avatar, 24).unwrap();
        let length = 0.01 * cells[2] as f64;
        let shape = |x: DVec3| (x.z / length * std::f64::consts::FRAC_PI_2).sin() * DVec3::Z;
        let (mode, overlap) = most_like(&avatar, &modes, shape);
        let expected = (30e3f64 / avatar.density).sqrt() / (4.0 * length);
        let frequency = modes.frequencies[mode];
        println!("mode {mode}: {frequency} Hz for {expected} Hz, overlap {overlap}");
        // Elements of length d are off by (π d / 2L)²/24 = 4e-4 with lumped masses; the sides' uneven lumps are as small.
        assert!((frequency / expected - 1.0).abs() < 0.005 && overlap > 0.99);
        // Bending both ways is softer.
        assert!(mode >= 2, "mode {mode}");
    }

    #[test]
    fn a_limb_twists_about_its_bone_as_bessel_says() {
        let limb = Limb {
            length: 0.03,
            stations: 4,
            layers: 8,
            sectors: 40,
            ..Limb::S
        };
        let avatar = baked(&limb.body().unwrap(), 8, 0.4);
        let modes = modal(&avatar, 6).unwrap();
        let wave_number = twist_wave_number(limb.inner_radius, limb.outer_radius);
        let shear = 30e3 / (2.0 * 1.4);
        let expected = wave_number * (shear / avatar.density).sqrt() / TAU;
        let shape = |x: DVec3| {
            let radius = x.y.hypot(x.z);
            let lag = twist(wave_number, limb.inner_radius, radius).0;
            lag * DVec3::new(0.0, -x.z, x.y) / radius
        };
        let (mode, overlap) = most_like(&avatar, &modes, shape);
        let frequency = modes.frequencies[mode];
        println!("mode {mode}: {frequency} Hz for {expected} Hz, overlap {overlap}");
        // (k d)²/24 = 2e-3 of the elements' length d, and the polygon's 40 corners.
        assert!((frequency / expected - 1.0).abs() < 0.02 && overlap > 0.99);
    }

    /// (f, f') at r of u = f(r) e_θ: f'' + f'/r − f/r² + k² f = 0 with f(a) = 0 and f'(a) = 1, by the midpoint rule.
    fn twist(k: f64, a: f64, r: f64) -> (f64, f64) {
        const STEPS: usize = 400;
        let d = (r - a) / STEPS as f64;
        let slope = |r: f64, (f, s): (f64, f64)| (s, f / (r * r) - s / r - k * k * f);
        let (mut at, mut x) = ((0.0, 1.0), a);
        for _ in 0..STEPS {
            let first = slope(x, at);
            let middle = (at.0 + 0.5 * d * first.0, at.1 + 0.5 * d * first.1);
            let second = slope(x + 0.5 * d, middle);
            at = (at.0 + d * second.0, at.1 + d * second.1);
            x += d;
        }
        at
    }

    /// The smallest k with no traction at r = b: f' − f/b = 0.
    fn twist_wave_number(a: f64, b: f64) -> f64 {
        let traction = |k: f64| {
            let (f, slope) = twist(k, a, b);
            slope - f / b
        };
        let (mut low, mut high) = (0.0, 1.0);
        while traction(high) > 0.0 {
            (low, high) = (high, high + 1.0);
        }
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if traction(middle) > 0.0 {
                low = middle;
            } else {
                high = middle;
            }
        }
        low
    }

    #[test]
    fn what_cannot_be_asked_for_is_a_typed_error() {
        let avatar = clamped_box([3, 3, 2], 0.4);
        for count in [0, 4, 300] {
            let error = modal(&avatar, count).unwrap_err().to_string();
            assert!(error.contains("count"), "{error}");
        }
        let mut floating = avatar.clone();
        floating.layer.bone_of_node.fill(None);
        let error = modal(&floating, 3).unwrap_err().to_string();
        assert!(error.contains("modal analysis"), "{error}");
    }
}
