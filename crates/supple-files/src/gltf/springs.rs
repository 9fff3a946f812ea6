//! A file's spring bones on the bones of its rig.

use super::nodes::Nodes;
use super::polar::scale;
use super::rig::Rig;
use super::told_springs::{ToldCollider, ToldSprings, ToldTail};
use glam::DVec3;
use supple::model::{SpringBones, SpringChain, SpringCollider, SpringJoint};

/// A tail that is nearer to its joint than this says no direction, m.
const LEAST_LENGTH: f64 = 1e-6;

/// The spring bones, and what is to be known of them, a sentence each.
pub(super) fn spring_bones(
    told: &ToldSprings,
    nodes: &Nodes,
    rig: &Rig,
) -> (SpringBones, Vec<String>) {
    let mut out = SpringBones::default();
    let mut missing = told.missing;
    // The new number of each collider.
    let number: Vec<Option<u32>> = (told.colliders.iter())
        .map(|told| {
            let Some(collider) = told.and_then(|told| on_bone(&told, nodes, rig)) else {
                missing += 1;
                return None;
            };
            out.colliders.push(collider);
            Some(out.colliders.len() as u32 - 1)
        })
        .collect();
    let parents = &rig.skeleton.parents;
    for chain in &told.chains {
        let own = out.chains.len() as u32;
        let first = out.joints.len();
        for (joint, tail) in &chain.joints {
            let Some(bone) = rig.bone_of_node[joint.node] else {
                continue;
            };
            let Some(parent) = parents[bone as usize] else {
                continue;
            };
            let frame = &rig.rest[bone as usize];
            let world = &nodes.rest_world[joint.node];
            let tail = frame.inverse_transform(match *tail {
                ToldTail::Node(tail) => nodes.rest_world[tail].translation,
                ToldTail::Beyond(length) => {
                    let above = nodes.parents[joint.node].map(|p| nodes.rest_world[p].translation);
                    let along = world.translation - above.unwrap_or(world.translation);
                    world.translation + length * along.normalize_or_zero()
                }
            });
            let hit_radius = scale(world.matrix3) * joint.hit_radius;
            if tail.length() > LEAST_LENGTH && hit_radius.is_finite() {
                out.joints.push(SpringJoint {
                    chain: own,
                    bone,
                    tail,
                    rest_rotation: rig.rest[parent as usize].rotation.transpose() * frame.rotation,
                    stiffness: joint.stiffness,
                    drag_force: joint.drag_force,
                    gravity: joint.gravity,
                    hit_radius,
                });
            }
        }
        let Some(lowest) = out.joints[first..].iter().map(|joint| joint.bone).min() else {
            continue;
        };
        // One of the chain's own joints, or one below, has what carries the chain in its place.
        let center = chain.center.filter(|n| *n < nodes.parents.len());
        let mut center = center.and_then(|n| rig.bone_above(nodes, n));
        while let Some(bone) = center.filter(|bone| *bone >= lowest) {
            center = parents[bone as usize];
        }
        out.chains.push(SpringChain {
            name: chain.name.clone(),
            center,
            colliders: chain.colliders.iter().filter_map(|k| number[*k]).collect(),
        });
    }
    out.joints.sort_by_key(|joint| joint.bone);
    (out, notes(told, missing))
}

fn on_bone(told: &ToldCollider, nodes: &Nodes, rig: &Rig) -> Option<SpringCollider> {
    let world = nodes.rest_world.get(told.node)?;
    let bone = rig.bone_above(nodes, told.node)?;
    let frame = &rig.rest[bone as usize];
    let place = |p: DVec3| frame.inverse_transform(world.transform_point3(p));
    let collider = SpringCollider {
        bone,
        offset: place(told.offset),
        tail: told.tail.map(place),
        radius: scale(world.matrix3) * told.radius,
    };
    let finite = collider.offset.is_finite()
        && collider.tail.is_none_or(|t| t.is_finite())
        && collider.radius.is_finite();
    (finite && collider.radius >= 0.0).then_some(collider)
}

fn notes(told: &ToldSprings, missing: usize) -> Vec<String> {
    let mut notes = Vec::new();
    if let Some((name, problem)) = told.broken.first() {
        let count = told.broken.len();
        let more = match count {
            1 => String::new(),
            n => format!(" ({n} in all)"),
        };
        notes.push(format!(
            "the spring chain {name:?} {problem}: left out{more}"
        ));
    }
    if told.clamped > 0 {
        let count = told.clamped;
        notes.push(format!(
            "{count} spring chains have a drag force outside 0 to 1: it is cut to that"
        ));
    }
    if missing > 0 {
        notes.push(format!(
            "{missing} colliders of spring bones name no bone, or are no sphere and no capsule: left out"
        ));
    }
    notes
}
