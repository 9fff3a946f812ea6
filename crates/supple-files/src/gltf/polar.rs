//! The rotation in a matrix: its polar factor.

use glam::{DMat3, DVec3};

/// A matrix whose scale, ∛|det|, is below this part of its size flattens space: it has no rotation of its own.
const LEAST_SCALE: f64 = 1e-3;

/// More steps than any matrix above that needs.
const MOST_STEPS: usize = 24;

/// The orthogonal Q of M = Q H with H symmetric and positive: of all rotations the nearest to M, with a mirror where M has
/// one. Nothing where M flattens space, or is not finite.
pub(super) fn polar_factor(m: DMat3) -> Option<DMat3> {
    let (scale, size) = (scale(m), norm(m) / 3f64.sqrt());
    // Comparisons with NaN are false.
    if !(scale > LEAST_SCALE * size && scale.is_normal() && size.is_finite()) {
        return None;
    }
    let mut q = m * (1.0 / scale);
    for _ in 0..MOST_STEPS {
        // Newton's iteration, Q ← (γ Q + Q⁻ᵀ/γ)/2, its γ as of Higham (1986): it squares what is left each time.
        let dual = q.inverse().transpose();
        let gamma = (norm(dual) / norm(q)).sqrt();
        let next = (q * gamma + dual * (1.0 / gamma)) * 0.5;
        let step = norm(next - q);
        q = next;
        if step < 1e-9 {
            return Some(q);
        }
    }
    None
}

/// ∛|det M|: the scale of a matrix that scales alike along its axes.
pub(super) fn scale(m: DMat3) -> f64 {
    m.determinant().abs().cbrt()
}

/// How far M is from a rotation with one scale, relative to that: 0.01 where one axis is longer by 1 %.
pub(super) fn stretch(m: DMat3) -> Option<f64> {
    let h = polar_factor(m)?.transpose() * m * (1.0 / scale(m)) - DMat3::IDENTITY;
    let largest = |v: DVec3| v.abs().max_element();
    Some(largest(DVec3::new(
        largest(h.x_axis),
        largest(h.y_axis),
        largest(h.z_axis),
    )))
}

/// Frobenius' norm.
fn norm(m: DMat3) -> f64 {
    (m.x_axis.length_squared() + m.y_axis.length_squared() + m.z_axis.length_squared()).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DQuat;

    fn turn() -> DMat3 {
        DMat3::from_quat(DQuat::from_euler(glam::EulerRot::XYZ, 0.4, -1.1, 2.0))
    }

    #[test]
    fn the_rotation_of_a_stretched_turned_matrix_is_found() {
        let (q, axes) = (turn(), DMat3::from_rotation_y(0.7));
        let stretches = [
            DVec3::ONE,
            DVec3::new(1.006, 0.988, 1.006),
            DVec3::new(3.0, 0.5, 40.0),
            DVec3::new(1.0, 1.0, 1e-6),
        ];
        for stretch in stretches {
            let h = axes * DMat3::from_diagonal(stretch) * axes.transpose();
            for size in [1.0, 1e-40, -1e-6, 1e40] {
                let found = polar_factor(q * h * size).unwrap();
                let expected = q * f64::signum(size);
                assert!(
                    found.abs_diff_eq(expected, 1e-9),
                    "{stretch} {size}: {found}"
                );
            }
        }
    }

    #[test]
    fn what_flattens_space_has_none() {
        for flat in [
            DVec3::ZERO,
            DVec3::new(1.0, 1.0, 0.0),
            DVec3::new(1.0, 1e-5, 1e-5),
        ] {
            assert_eq!(
                polar_factor(turn() * DMat3::from_diagonal(flat)),
                None,
                "{flat}"
            );
        }
        assert_eq!(polar_factor(DMat3::IDENTITY * f64::NAN), None);
        assert_eq!(polar_factor(DMat3::IDENTITY * f64::INFINITY), None);
    }

    #[test]
    fn stretches_are_relative_to_the_scale() {
        let found = stretch(turn() * DMat3::from_diagonal(DVec3::new(0.01, 0.01, 0.0103))).unwrap();
        assert!((found - 0.02).abs() < 5e-4, "{found}");
        assert!(stretch(turn() * 7.0).unwrap() < 1e-12);
    }
}
