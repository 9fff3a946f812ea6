//! The active contacts as a list in fixed order (vertex-major, collider-minor), and those of a step's
//! start that rub.

use super::contact::{Candidate, ContactRow};
use super::friction::Lagged;
use crate::collider::Collider;
use crate::model::Frame;
use glam::DVec3;

/// Lists the candidates that touch, `capacity` at most, and returns how many there are. `candidates` holds
/// one for each (vertex, collider), vertex-major; `areas` is that of each vertex, m².
pub fn compact(
    candidates: &[Candidate],
    areas: &[f64],
    colliders: &[Collider],
    capacity: usize,
    out: &mut Vec<ContactRow>,
) -> usize {
    out.clear();
    let mut active = 0;
    for_each(
        candidates,
        areas,
        colliders,
        |vertex, k, candidate, area| {
            active += 1;
            if active <= capacity {
                let (collider, vertex) = (&colliders[k], vertex as u32);
                let stiffness = collider.stiffness * area;
                out.push(ContactRow::normal(candidate, stiffness, vertex, collider));
            }
        },
    );
    active
}

/// Lists the candidates of qⁿ against the colliders of tⁿ that have friction, with λ = k a δ. `frames` are
/// those that the colliders are fixed to, at tⁿ; `point` gives a vertex's place, m.
pub fn lag(
    candidates: &[Candidate],
    areas: &[f64],
    colliders: &[Collider],
    frames: &[Frame],
    point: impl Fn(usize) -> DVec3,
    out: &mut Vec<Lagged>,
) {
    out.clear();
    for_each(
        candidates,
        areas,
        colliders,
        |vertex, k, candidate, area| {
            let (collider, frame) = (&colliders[k], &frames[k]);
            if collider.friction > 0.0 {
                out.push(Lagged {
                    vertex: vertex as u32,
                    collider: k as u32,
                    carrier: collider.carrier,
                    anchor: frame.inverse_transform(point(vertex)),
                    normal: frame.rotation.transpose() * candidate.normal,
                    limit: collider.friction * (collider.stiffness * area * candidate.depth),
                });
            }
        },
    );
}

/// Calls `f(vertex, collider, candidate, area)` for what touches.
fn for_each(
    candidates: &[Candidate],
    areas: &[f64],
    colliders: &[Collider],
    mut f: impl FnMut(usize, usize, &Candidate, f64),
) {
    let rows = candidates.chunks_exact(colliders.len().max(1)).zip(areas);
    for (vertex, (row, &area)) in rows.enumerate() {
        for (k, candidate) in row.iter().enumerate() {
            if candidate.depth > 0.0 {
                f(vertex, k, candidate, area);
            }
        }
    }
}
