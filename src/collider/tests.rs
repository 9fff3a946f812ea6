//! What every shape must satisfy.

use super::*;
use crate::math::Random;

/// One of each shape whose distance is exact.
fn exact() -> impl Iterator<Item = Shape> {
    let sampled = |s: &Shape| matches!(s, Shape::Mesh(_));
    Shape::examples().into_iter().filter(move |s| !sampled(s))
}

/// Points about a shape, away from it, on it and inside.
fn samples(random: &mut Random) -> Vec<DVec3> {
    (0..400).map(|_| random.vector(0.08)).collect()
}

#[test]
fn normal_is_the_unit_gradient_of_the_distance_and_curvature_that_of_the_normal() {
    let mut random = Random::new(1);
    let step = 1e-6;
    for shape in Shape::examples() {
        let mut smooth = 0;
        for p in samples(&mut random) {
            let here = shape.signed_distance(p);
            // Interpolated distances rise as fast as the exact ones but for their error, and are flat on a medial plane.
            let sampled = matches!(shape, Shape::Mesh(_));
            let slack = if sampled { 1.0 } else { 1e-14 };
            assert!((here.normal.length() - 1.0).abs() < slack, "{shape:?} {p}");
            let sides = DVec3::AXES.map(|e| {
                [-step, step].map(|s| {
                    let there = shape.signed_distance(p + s * e);
                    // |d(x) − d(y)| ≤ |x − y| everywhere.
                    assert!((there.distance - here.distance).abs() <= step * (1.0 + 1e-9 + slack));
                    there
                })
            });
            // Skip the creases: where a face changes within the stencil.
            if sides
                .iter()
                .flatten()
                .any(|s| s.normal.distance(here.normal) > 1e-2)
            {
                continue;
            }
            smooth += 1;
            let gradient =
                DVec3::from_array(sides.map(|[a, b]| (b.distance - a.distance) / (2.0 * step)));
            assert!(
                gradient.distance(here.normal) < 1e-4,
                "{shape:?} {p}: {gradient}"
            );
            assert!((gradient.length() - 1.0).abs() < 1e-4 + slack);
            let turning = DMat3::from_cols_array_2d(
                &sides.map(|[a, b]| ((b.normal - a.normal) / (2.0 * step)).to_array()),
            );
            let error = (turning - shape.curvature(p)).to_cols_array();
            // Rounding of n over the step, plus the third derivative ~ 1/d².
            let tolerance = 1e-4 * (1.0 + 1.0 / here.distance.abs().max(1e-4));
            assert!(
                error.iter().all(|e| e.abs() < tolerance),
                "{shape:?} {p}: {error:?}"
            );
        }
        assert!(smooth > 300, "{shape:?}: only {smooth} smooth samples");
    }
}

#[test]
fn a_point_at_known_distance_along_the_normal_has_that_distance() {
    let mut random = Random::new(2);
    for shape in exact() {
        for p in samples(&mut random) {
            let SignedDistance { distance, normal } = shape.signed_distance(p);
            if distance < 0.0 {
                continue;
            }
            let foot = p - distance * normal;
            assert!(
                shape.signed_distance(foot).distance.abs() < 1e-15,
                "{shape:?} {p}"
            );
            let away = foot + 0.0123 * normal;
            assert!((shape.signed_distance(away).distance - 0.0123).abs() < 1e-15);
        }
    }
}

#[test]
fn inside_points_reach_the_surface_in_their_depth() {
    let mut random = Random::new(3);
    for shape in exact() {
        let mut inside = 0;
        for _ in 0..2000 {
            let p = random.vector(0.012);
            let SignedDistance { distance, normal } = shape.signed_distance(p);
            if distance >= 0.0 {
                continue;
            }
            inside += 1;
            let surface = shape.signed_distance(p - distance * normal);
            assert!(
                surface.distance.abs() < 1e-15,
                "{shape:?} {p}: {}",
                surface.distance
            );
        }
        assert!(inside > 200, "{shape:?}: {inside}");
    }
}

#[test]
fn axes_centres_edges_and_corners_have_a_unit_normal() {
    let tiny = f64::MIN_POSITIVE / 8.0;
    let coordinates = [
        0.0, -0.0, tiny, -tiny, 1e-200, 0.008, -0.01, 0.02, 0.03, 0.05, -0.05,
    ];
    for shape in exact() {
        for x in coordinates {
            for y in coordinates {
                for z in coordinates {
                    let p = DVec3::new(x, y, z);
                    let SignedDistance { distance, normal } = shape.signed_distance(p);
                    assert!(
                        distance.is_finite() && (normal.length() - 1.0).abs() < 1e-14,
                        "{shape:?} {p}"
                    );
                    assert!(!shape.curvature(p).is_nan(), "{shape:?} {p}");
                }
            }
        }
    }
}

#[test]
fn a_collider_measures_in_its_own_frame() {
    let mut random = Random::new(4);
    for shape in Shape::examples() {
        let frame = Frame {
            rotation: random.rotation(2.0),
            position: random.vector(1.0),
        };
        let collider = Collider::new(shape.clone(), frame);
        collider.validate().unwrap();
        let local = random.vector(0.05);
        let world = collider.signed_distance(&frame, frame.transform(local));
        let own = shape.signed_distance(local);
        assert!((world.distance - own.distance).abs() < 1e-15);
        assert!(world.normal.distance(frame.rotation * own.normal) < 1e-12);
        let shifted = collider.relative_to(frame.position);
        let relative = shifted.signed_distance(&shifted.frame, frame.rotation * local);
        assert!((relative.distance - own.distance).abs() < 1e-15);
    }
}

#[test]
fn unusable_colliders_are_refused_by_name() {
    let good = Collider::new(Shape::Sphere { radius: 0.1 }, Frame::IDENTITY);
    let sheared = Frame {
        rotation: DMat3::from_diagonal(DVec3::new(1.0, 1.0, 2.0)),
        position: DVec3::ZERO,
    };
    for (bad, field) in [
        (
            Collider {
                shape: Shape::Sphere { radius: -1.0 },
                ..good.clone()
            },
            "shape.radius",
        ),
        (
            Collider {
                stiffness: Some(f64::NAN),
                ..good.clone()
            },
            "stiffness",
        ),
        (
            Collider {
                margin: -1.0,
                ..good.clone()
            },
            "margin",
        ),
        (
            Collider {
                friction: 10.5,
                ..good.clone()
            },
            "friction",
        ),
        (
            Collider {
                frame: sheared,
                ..good.clone()
            },
            "frame",
        ),
    ] {
        let message = bad.validate().unwrap_err().to_string();
        assert!(message.starts_with(field), "{message}");
    }
    good.validate().unwrap();
}

#[test]
fn examples_are_listed_by_index() {
    for (k, shape) in Shape::examples().into_iter().enumerate() {
        assert_eq!(shape.index() as usize, k);
        shape.validate().unwrap();
    }
}
