//! Stiffening by an exponential: moduli at rest, closed forms, the limit, and how far a run moves a breast.

use super::largest;
use super::laws::{samples, stiffness};
use crate::material::{
    DEFAULT_BOUNCE, FungNeoHookean, Hyperelastic, Material, StableNeoHookean, damping_time,
};
use crate::math::Random;
use approx::assert_relative_eq;
use glam::{DMat3, DVec3};

fn tissue(stiffening: f64, stiffening_limit: f64) -> FungNeoHookean {
    FungNeoHookean {
        youngs_modulus: 3e4,
        poissons_ratio: 0.45,
        stiffening,
        stiffening_limit,
    }
}

/// F of a shear of the x direction along z.
fn sheared(gamma: f64) -> DMat3 {
    DMat3::IDENTITY + DMat3::from_cols(DVec3::ZERO, DVec3::ZERO, DVec3::X * gamma)
}

#[test]
fn small_strains_see_the_ground_and_no_stiffening_is_the_stable_neo_hookean_law() {
    let random = &mut Random::new(31);
    let stable = StableNeoHookean {
        youngs_modulus: 3e4,
        poissons_ratio: 0.45,
    };
    for b in [0.0, 0.5, 3.0, 100.0] {
        assert_eq!(
            tissue(b, 4.0).tangent(DMat3::IDENTITY),
            stable.tangent(DMat3::IDENTITY)
        );
    }
    let none = tissue(0.0, 4.0);
    for f in samples(random) {
        let change = random.matrix(0.3);
        let scale = stiffness(&Material::StableNeoHookean(stable), f);
        let close = |a: f64, b: f64| assert_relative_eq!(a, b, epsilon = 1e-14 * scale);
        close(none.energy_density(f), stable.energy_density(f));
        close(
            none.energy_difference(f, change),
            stable.energy_difference(f, change),
        );
        assert_eq!(none.pk1_stress(f), stable.pk1_stress(f));
        assert_eq!(none.tangent(f), stable.tangent(f));
        assert_eq!(none.projected_tangent(f), stable.projected_tangent(f));
    }
}

/// In simple shear J = 1 and Q = γ²: τ = μ γ e^(b γ²), and its slope is μ (1 + 2 b γ²) e^(b γ²).
#[test]
fn shear_follows_the_closed_form() {
    let model = tissue(1.5, 30.0);
    let (mu, _) = model.lame();
    for gamma in [-1.2, -0.3, 1e-3, 0.5, 1.0, 2.0f64] {
        let e = (1.5 * gamma * gamma).exp();
        let f = sheared(gamma);
        let stress = model.pk1_stress(f).z_axis.x;
        assert_relative_eq!(stress, mu * gamma * e, max_relative = 1e-12);
        let slope = model.tangent(f)[6][6];
        let expected = mu * (1.0 + 3.0 * gamma * gamma) * e;
        let (_, lambda) = model.lame();
        // cof F has an entry there too: none, J does not see this shear.
        assert_relative_eq!(slope, expected, epsilon = 1e-12 * (lambda + expected));
        assert_relative_eq!(
            model.energy_density(f),
            0.5 * mu / 1.5 * (e - 1.0),
            epsilon = 1e-13 * mu * e
        );
    }
}

/// Q is 0 for rotations and positive for all else, so that nothing is ever softer than at rest.
#[test]
fn it_only_ever_stiffens() {
    let random = &mut Random::new(32);
    let (soft, stiff) = (tissue(0.0, 4.0), tissue(1.0, 4.0));
    for f in samples(random) {
        assert!(stiff.energy_density(f) > soft.energy_density(f));
        let r = random.rotation(3.0);
        assert!(stiff.energy_density(r).abs() < 1e-14 * 3e4);
    }
    for size in [0.1, 0.5, 0.9, 1.1, 2.0] {
        let f = DMat3::from_diagonal(DVec3::splat(size));
        assert!(stiff.energy_density(f) > soft.energy_density(f));
    }
}

#[test]
fn past_the_limit_all_goes_on_smoothly_and_stays_finite() {
    let model = tissue(2.0, 1.5);
    let at = (1.5f64 / 2.0).sqrt();
    let (below, above) = (sheared(at - 1e-9), sheared(at + 1e-9));
    let jump = |a: f64, b: f64| (a - b).abs() / b.abs();
    assert!(jump(model.energy_density(below), model.energy_density(above)) < 1e-7);
    let (p, q) = (model.pk1_stress(below), model.pk1_stress(above));
    assert!(jump(p.z_axis.x, q.z_axis.x) < 1e-7);
    let (c, d) = (model.tangent(below), model.tangent(above));
    assert!(jump(c[6][6], d[6][6]) < 1e-7);
    // Differences across it, from either side.
    let (far, near) = (sheared(1.6), sheared(0.3));
    let whole = model.energy_density(far) - model.energy_density(near);
    for difference in [
        model.energy_difference(near, far - near),
        -model.energy_difference(far, near - far),
    ] {
        assert_relative_eq!(difference, whole, max_relative = 1e-13);
    }
    let (mu, _) = model.lame();
    let z = 2.0 * 1.6 * 1.6 - 1.5;
    let g = 1.5f64.exp() * (1.0 + z + 0.5 * z * z) - 1.0;
    assert_relative_eq!(
        model.energy_density(far),
        0.5 * mu / 2.0 * g,
        max_relative = 1e-13
    );
    for b in [1.0, 1e3] {
        let steep = tissue(b, 30.0);
        for size in [-50.0, 0.0, 50.0] {
            let f = DMat3::from_diagonal(DVec3::new(1.0, size, 3.0));
            assert!(steep.energy_density(f).is_finite());
            assert!(largest(steep.pk1_stress(f)).is_finite());
            assert!(
                steep
                    .projected_tangent(f)
                    .iter()
                    .flatten()
                    .all(|c| c.is_finite())
            );
        }
    }
}

/// G of shear waves in fat that is pressed to a stretch λ goes with λ^−2.4 (MR elastography, 2023, J Mech Behav Biomed Mater). Along
/// axis i a wave sees λ_i² μ g′ of incompressible tissue with sides 1/√λ; the mean over the three axes is compared.
#[test]
fn pressed_tissue_stiffens_about_as_fat_does() {
    let model = FungNeoHookean::from_shear_modulus(750.0, 0.499);
    for stretch in [0.5, 0.6, 0.7, 0.8f64] {
        let side = stretch.sqrt().recip();
        let f = DMat3::from_diagonal(DVec3::new(stretch, side, side));
        let c = model.tangent(f);
        // ∂P_zx/∂F_zx of x displaced along y and z, and of y along x.
        let waves = [
            c[3][3] * side * side,
            c[6][6] * side * side,
            c[1][1] * stretch * stretch,
        ];
        let mean = waves.iter().sum::<f64>() / 3.0 / 750.0;
        let fat = stretch.powf(-2.4);
        assert!(
            mean > 0.6 * fat && mean < 1.1 * fat,
            "{stretch}: {mean} of {fat}"
        );
    }
}

/// Peak-to-peak displacement, m, against its base of the tip of a shear beam as deep and as soft as a large breast (a
/// paraboloid 70 mm deep, G 0.3 kPa, so 3 Hz; damped as by default), whose base moves by `amplitude` at `frequency`.
fn breast_motion(stiffening: f64, amplitude: f64, frequency: f64) -> f64 {
    const ELEMENTS: usize = 8;
    let tissue = FungNeoHookean {
        stiffening,
        ..FungNeoHookean::from_shear_modulus(300.0, 0.4)
    };
    let (depth, density) = (0.07, 1000.0);
    let length = depth / ELEMENTS as f64;
    // The cross-section falls linearly from the base to the tip.
    let area = |e: usize| 1.0 - (e as f64 + 0.5) / ELEMENTS as f64;
    let mass: Vec<f64> = (0..ELEMENTS)
        .map(|e| {
            let next = if e + 1 < ELEMENTS { area(e + 1) } else { 0.0 };
            0.5 * density * length * (area(e) + next)
        })
        .collect();
    let beta = damping_time(DEFAULT_BOUNCE, 3.0);
    let omega = std::f64::consts::TAU * frequency;
    let (mut u, mut v) = ([0.0; ELEMENTS], [0.0; ELEMENTS]);
    let (step, duration) = (2e-4, 6.0);
    let (mut low, mut high) = (0.0f64, 0.0f64);
    for k in 0..(duration / step) as usize {
        let time = k as f64 * step;
        let mut force = [0.0; ELEMENTS + 1];
        for e in 0..ELEMENTS {
            let below = |x: &[f64; ELEMENTS]| if e > 0 { x[e - 1] } else { 0.0 };
            let f = sheared((u[e] - below(&u)) / length);
            let rate = (v[e] - below(&v)) / length;
            let stress = tissue.pk1_stress(f).z_axis.x + beta * tissue.tangent(f)[6][6] * rate;
            force[e] = area(e) * stress;
        }
        let base = time.min(1.0) * amplitude * omega * omega * (omega * time).sin();
        for e in 0..ELEMENTS {
            v[e] += step * ((force[e + 1] - force[e]) / mass[e] + base);
            u[e] += step * v[e];
        }
        if time > duration - 2.0 / frequency {
            (low, high) = (low.min(u[ELEMENTS - 1]), high.max(u[ELEMENTS - 1]));
        }
    }
    high - low
}

/// Measured without support: 42 ± 10 mm walking and 152 ± 42 mm running (Scurr, White and Hedger 2011); the bounds that this crate
/// sets itself are 60 to 110 mm in a run of ±45 mm at 2.7 Hz and 12 to 30 mm in a walk.
#[test]
fn a_run_does_not_move_a_breast_absurdly_and_a_walk_hardly_feels_the_stiffening() {
    let run = |b| breast_motion(b, 0.045, 2.7);
    let walk = |b| breast_motion(b, 0.0175, 1.9);
    let b = FungNeoHookean::STIFFENING;
    assert!(run(0.0) > 0.27, "{}", run(0.0));
    assert!(run(b) > 0.1 && run(b) < 0.115, "{}", run(b));
    assert!(walk(b) > 0.9 * walk(0.0), "{} of {}", walk(b), walk(0.0));
}

#[test]
fn unusable_stiffening_is_refused_by_name_and_has_defaults() {
    for (broken, field) in [
        (tissue(-0.1, 4.0), "material.stiffening"),
        (tissue(f64::INFINITY, 4.0), "material.stiffening"),
        (tissue(f64::NAN, 4.0), "material.stiffening"),
        (tissue(1.0, 0.0), "material.stiffening_limit"),
        (tissue(1.0, 30.1), "material.stiffening_limit"),
        (tissue(1.0, f64::NAN), "material.stiffening_limit"),
        (
            FungNeoHookean {
                youngs_modulus: 0.0,
                ..tissue(1.0, 4.0)
            },
            "material.youngs_modulus",
        ),
    ] {
        let message = Material::FungNeoHookean(broken)
            .validate()
            .unwrap_err()
            .to_string();
        assert!(message.contains(&format!("{field}:")), "{message}");
    }
    let text = "fung_neo_hookean = { youngs_modulus = 2100.0, poissons_ratio = 0.4 }";
    let read: Material = toml::from_str(text).unwrap();
    let expected = FungNeoHookean::from_shear_modulus(750.0, 0.4);
    assert_eq!(read, Material::FungNeoHookean(expected));
}
