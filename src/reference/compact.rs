//! The active contacts as a list in fixed order: vertex-major, collider-minor.

use super::contact::{Candidate, Contact, ContactSide};
use crate::collider::Collider;

/// Lists the candidates that touch, `capacity` at most, and returns how many there are. `candidates` holds
/// one for each (vertex, collider), vertex-major; `areas` is that of each vertex, m².
pub fn compact(
    candidates: &[Candidate],
    areas: &[f64],
    colliders: &[Collider],
    capacity: usize,
    out: &mut Vec<Contact>,
) -> usize {
    out.clear();
    let mut active = 0;
    let rows = candidates.chunks_exact(colliders.len().max(1)).zip(areas);
    for (vertex, (row, &area)) in rows.enumerate() {
        for (index, (candidate, collider)) in row.iter().zip(colliders).enumerate() {
            if candidate.depth <= 0.0 {
                continue;
            }
            active += 1;
            if active > capacity {
                continue;
            }
            let (vertex, collider_index) = (vertex as u32, index as u32);
            out.push(Contact {
                sides: [
                    ContactSide::Skin { vertex },
                    ContactSide::Collider {
                        collider: collider_index,
                    },
                ],
                normal: candidate.normal,
                depth: candidate.depth,
                stiffness: collider.stiffness * area,
            });
        }
    }
    active
}
