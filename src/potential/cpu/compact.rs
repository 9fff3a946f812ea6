//! The active contacts as a list in fixed order (vertex-major, collider-minor), and those of a step's
//! start that rub.

use super::contact::{Candidate, ContactRow};
use super::friction::Lagged;
use crate::collider::Collider;
use crate::model::Frame;
use glam::DVec3;

/// Lists the candidates that touch, and returns how many there are. `candidates` holds
/// one for each (vertex, collider), vertex-major; `stiffness` is k a of such a pair, N/m.
pub fn compact(
    candidates: &[Candidate],
    stiffness: impl Fn(usize, usize) -> f64,
    colliders: &[Collider],
    out: &mut Vec<ContactRow>,
) -> usize {
    out.clear();
    for_each(candidates, colliders.len(), |v, k, candidate| {
        let stiffness = stiffness(v, k);
        out.push(ContactRow::normal(
            candidate,
            stiffness,
            v as u32,
            &colliders[k],
        ));
    });
    out.len()
}

/// Lists the candidates of qⁿ against the colliders of tⁿ that have friction. They push with λ = k a δ |∇d|,
/// as ∇d between samples of a distance is no unit vector; where it vanishes nothing has_friction. `stiffness` is k a of a
/// vertex and a collider, N/m; `frames` are those that the colliders are fixed to, at tⁿ; `point` gives a vertex's place, m.
pub fn lag(
    candidates: &[Candidate],
    stiffness: impl Fn(usize, usize) -> f64,
    colliders: &[Collider],
    frames: &[Frame],
    point: impl Fn(usize) -> DVec3,
    out: &mut Vec<Lagged>,
) {
    out.clear();
    for_each(candidates, colliders.len(), |vertex, k, candidate| {
        let (collider, frame) = (&colliders[k], &frames[k]);
        if collider.friction > 0.0 {
            let (slope, normal) = length_and_direction(candidate.normal);
            let force = stiffness(vertex, k) * candidate.depth * slope;
            out.push(Lagged {
                vertex: vertex as u32,
                collider: k as u32,
                body: collider.body,
                anchor: frame.inverse_transform(point(vertex)),
                normal: frame.rotation.transpose() * normal,
                limit: collider.friction * force,
            });
        }
    });
}

/// |∇d|, and n along it; z where there is none.
fn length_and_direction(gradient: DVec3) -> (f64, DVec3) {
    let length = gradient.length();
    if length > 1e-18 {
        return (length, gradient / length);
    }
    (0.0, DVec3::Z)
}

/// Calls `f(vertex, collider, candidate)` for what touches one of so many `colliders`.
fn for_each(
    candidates: &[Candidate],
    colliders: usize,
    mut f: impl FnMut(usize, usize, &Candidate),
) {
    for (vertex, row) in candidates.chunks_exact(colliders.max(1)).enumerate() {
        for (k, candidate) in row.iter().enumerate() {
            if candidate.depth > 0.0 {
                f(vertex, k, candidate);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::collider::Shape;

    /// λ is what the push is, ½ k a δ² differentiated, however long ∇d; the plane is across ∇d.
    #[test]
    fn friction_takes_the_push_and_its_direction_from_a_gradient_of_any_length() {
        let rough = Collider {
            friction: 0.5,
            ..Collider::new(Shape::HalfSpace, Frame::IDENTITY)
        };
        let (stiffness, direction) = (200.0, DVec3::new(0.6, 0.0, 0.8));
        for slope in [1.0, 0.4, 1e-9, 0.0] {
            let candidate = Candidate {
                depth: 1e-3,
                normal: slope * direction,
            };
            let mut lagged = Vec::new();
            let (colliders, frames) = (std::slice::from_ref(&rough), &[Frame::IDENTITY]);
            let point = |_| DVec3::ZERO;
            let of_pair = |_, _| stiffness;
            lag(&[candidate], of_pair, colliders, frames, point, &mut lagged);
            let push = ContactRow::normal(&candidate, stiffness, 0, &rough);
            let force = (push.force * push.direction).length();
            assert!((lagged[0].limit - 0.5 * force).abs() <= 1e-15 * force);
            assert!((lagged[0].normal.length() - 1.0).abs() < 1e-15);
            assert!(slope == 0.0 || lagged[0].normal.distance(direction) < 1e-15);
        }
    }
}
