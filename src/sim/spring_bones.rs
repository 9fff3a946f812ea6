//! The dynamics of spring bones (method §6), as published in VRMC_springBone-1.0 (VRM consortium), "SpringBone Algorithm".
//!
//! A joint at c with its rest rotation R in the world (its parent's times that at rest) has a tail x at distance ℓ. A step of
//! the published length h₀ = 1/60 s is, with drag force d, stiffness s, gravity g and the rest direction e,
//!
//! ```text
//! x' = x + (x − x₋) (1 − d) + h₀ s R e + h₀ g,   then   x' ← c + ℓ (x' − c)/|x' − c|,
//! ```
//!
//! then collisions; the joint turns by the shortest way from R e to x' − c. Written out for other lengths the published formula
//! depends on the frame rate: drag counts frames. Here a step is cut into substeps of h ≤ h₀, and with v = (x − x₋)/h the velocity
//! goes as k such steps of h₀ would have it, k = h/h₀ a fraction:
//!
//! ```text
//! v' = (1 − d)ᵏ v + (1 − (1 − d)ᵏ)/d (s R e + g),   x' = x + h v',
//! ```
//!
//! which at h = h₀ is the published one. Tails are seen from the chain's center where it has one. The velocity of a tail is
//! kept where a state has all its velocities, in qⁿ⁻¹: its bone's frame there has the tail where it would have come from.
//!
//! A collision pushes the tail out along the normal n of the nearest surface, here along its sphere about c: to the
//! nearest direction in which n · (x' − p) is the hit radius, p being the surface's point. Where no direction has that (the
//! joint lies too deep in the collider), it is the published one: moved along n, then back to its distance.

use super::carried::CarriedBone;
use super::instance::Instance;
use crate::collider::Collider;
use crate::model::{Frame, SpringBones, SpringJoint, State};
use glam::{DMat3, DVec3};

/// h₀, s: the frame that the published formula counts in.
const PUBLISHED_STEP: f64 = 1.0 / 60.0;

/// A tail that is off its rest by less than this part of its length is at rest.
const REST: f64 = 1e-12;

/// Passes over a tail's colliders: to be out of one may be to be in another.
const PASSES: usize = 4;

/// A tail and its velocity, in the space of its chain.
#[derive(Clone, Copy, Debug)]
struct Tail {
    position: DVec3,
    velocity: DVec3,
}

/// A ball swept along a line, in the world.
#[derive(Clone, Copy, Debug)]
struct Swept {
    ends: [DVec3; 2],
    radius: f64,
}

/// The memory of an instance's spring bones in a step.
#[derive(Debug, Default)]
pub(super) struct Swing {
    /// Of each carried bone; of those that do not swing, nothing.
    tails: Vec<Option<Tail>>,
    /// Frames at the end of a substep.
    frames: Vec<Frame>,
    colliders: Vec<Swept>,
    solids: Vec<Collider>,
}

impl Swing {
    /// Moves the `carried` bones of `instance` through a step of `time_step`, after which all others are where `state` has
    /// them.
    pub fn step(
        &mut self,
        springs: &SpringBones,
        carried: &[CarriedBone],
        instance: &Instance,
        time_step: f64,
        state: &mut State,
    ) {
        self.start(springs, carried, instance);
        let substeps = substeps(time_step);
        let h = time_step / substeps as f64;
        let before = &instance.state.frames;
        self.frames.clone_from(&state.frames);
        for k in 1..=substeps {
            let part = k as f64 / substeps as f64;
            if k < substeps {
                let pairs = before.iter().zip(&state.frames);
                self.frames.clear();
                self.frames.extend(pairs.map(|(a, b)| a.between(b, part)));
            } else {
                self.frames.clone_from(&state.frames);
            }
            self.place_colliders(springs, instance, part);
            self.substep(springs, carried, instance, h);
        }
        std::mem::swap(&mut self.frames, &mut state.frames);
    }

    /// Tails and velocities as qⁿ and qⁿ⁻¹ have them.
    fn start(&mut self, springs: &SpringBones, carried: &[CarriedBone], instance: &Instance) {
        let history = &instance.history;
        let (now, before) = (&instance.state.frames, &history.previous().frames);
        self.tails.clear();
        self.tails.extend(carried.iter().map(|of| {
            let joint = &springs.joints[of.spring?];
            let [position, last] =
                [now, before].map(|frames| frames[of.bone].transform(joint.tail));
            let space = space(springs, joint, now);
            Some(Tail {
                position: space.inverse_transform(position),
                velocity: space.rotation.transpose() * ((position - last) / history.last_step()),
            })
        }));
    }

    /// Where colliders are `part` of the way through the step. Those on spring bones of a higher number are where these were
    /// predicted.
    fn place_colliders(&mut self, springs: &SpringBones, instance: &Instance, part: f64) {
        let frames = &self.frames;
        self.colliders.clear();
        self.colliders.extend(springs.colliders.iter().map(|c| {
            let place = |p: DVec3| frames[c.bone as usize].transform(p);
            Swept {
                ends: [c.offset, c.tail.unwrap_or(c.offset)].map(place),
                radius: c.radius,
            }
        }));
        self.solids.clone_from(&instance.colliders);
        for solid in &mut self.solids {
            let end = solid.world_frame(frames);
            solid.frame = match solid.body {
                None => solid.previous.between(&end, part),
                Some(_) => end,
            };
            solid.body = None;
        }
    }

    /// Moves the carried bones on, parents first; all others stand in `self.frames`.
    fn substep(
        &mut self,
        springs: &SpringBones,
        carried: &[CarriedBone],
        instance: &Instance,
        h: f64,
    ) {
        for (of, tail) in carried.iter().zip(&mut self.tails) {
            let rest = of.carried_by(&self.frames[of.parent]);
            let (Some(joint), Some(tail)) = (of.spring.map(|s| &springs.joints[s]), tail) else {
                self.frames[of.bone] = rest;
                continue;
            };
            let space = space(springs, joint, &self.frames);
            let head = rest.position;
            let length = joint.tail.length();
            let at_rest = rest.rotation * (joint.tail / length);
            let free = {
                let (keep, gain) = gains(joint.drag_force, h);
                let pull = joint.stiffness * at_rest + instance.file_axes * joint.gravity;
                let velocity = keep * (space.rotation * tail.velocity) + gain * pull;
                space.transform(tail.position) + h * velocity
            };
            let mut direction = direction(free - head).unwrap_or(at_rest);
            let chain = &springs.chains[joint.chain as usize];
            for _ in 0..PASSES {
                let mut pushed = false;
                let mut meet = |distance: f64, normal: DVec3| {
                    if distance < joint.hit_radius {
                        let depth = joint.hit_radius - distance;
                        direction = push_out(direction, normal, depth / length);
                        pushed = true;
                    }
                    head + length * direction
                };
                let mut place = meet(f64::INFINITY, DVec3::ZERO);
                for &c in &chain.colliders {
                    let (distance, normal) = self.colliders[c as usize].distance(place);
                    place = meet(distance, normal);
                }
                for solid in &self.solids {
                    let found = solid.signed_distance(&solid.frame, place);
                    place = meet(found.distance, found.normal);
                }
                if !pushed {
                    break;
                }
            }
            let mut end = head + length * direction;
            let rest_tail = head + length * at_rest;
            self.frames[of.bone] = if end.distance(rest_tail) <= REST * length {
                end = rest_tail;
                rest
            } else {
                let turned = Frame {
                    rotation: shortest_turn(at_rest, direction) * rest.rotation,
                    position: head,
                };
                turned.moved(DVec3::ZERO, DVec3::ZERO)
            };
            let end = space.inverse_transform(end);
            *tail = Tail {
                position: end,
                velocity: (end - tail.position) / h,
            };
        }
    }

    /// Gives the frames of spring bones in qⁿ⁻¹, `previous`, the velocities that their tails have in `state`, where a step
    /// of `time_step` has led there.
    pub fn keep_velocities(
        &self,
        springs: &SpringBones,
        carried: &[CarriedBone],
        time_step: f64,
        state: &State,
        previous: &mut State,
    ) {
        for (of, tail) in carried.iter().zip(&self.tails) {
            let (Some(spring), Some(tail)) = (of.spring, tail) else {
                continue;
            };
            let space = space(springs, &springs.joints[spring], &state.frames);
            let frame = state.frames[of.bone];
            previous.frames[of.bone] = Frame {
                position: frame.position - time_step * (space.rotation * tail.velocity),
                ..frame
            };
        }
    }
}

impl Swept {
    /// Distance of `p` from the surface, m, and the outward normal at its nearest point.
    fn distance(&self, p: DVec3) -> (f64, DVec3) {
        let [a, b] = self.ends;
        let axis = b - a;
        let along = (p - a).dot(axis) / axis.length_squared().max(f64::MIN_POSITIVE);
        let offset = p - (a + along.clamp(0.0, 1.0) * axis);
        let normal = direction(offset).unwrap_or(DVec3::Y);
        (offset.length() - self.radius, normal)
    }
}

/// The space in which the inertia of a joint's chain is felt.
fn space(springs: &SpringBones, joint: &SpringJoint, frames: &[Frame]) -> Frame {
    let center = springs.chains[joint.chain as usize].center;
    center.map_or(Frame::IDENTITY, |center| frames[center as usize])
}

/// The least number of substeps that are no longer than h₀, but for rounding.
fn substeps(time_step: f64) -> usize {
    (time_step / PUBLISHED_STEP - 1e-9).ceil().max(1.0) as usize
}

/// (1 − d)ᵏ and (1 − (1 − d)ᵏ)/d with k = h/h₀; at k = 1 exactly 1 − d and 1.
fn gains(drag: f64, h: f64) -> (f64, f64) {
    let k = h / PUBLISHED_STEP;
    if (k - 1.0).abs() < 1e-9 {
        return (1.0 - drag, 1.0);
    }
    let exponent = k * (-drag).ln_1p();
    let gain = if drag > 0.0 {
        -exponent.exp_m1() / drag
    } else {
        k
    };
    (exponent.exp(), gain)
}

/// The unit vector along `v`, without overflow; none where v = 0 or is not finite.
fn direction(v: DVec3) -> Option<DVec3> {
    let size = v.abs().max_element();
    (size > 0.0 && v.is_finite()).then(|| (v / size).normalize())
}

/// A unit vector across `v`.
fn across(v: DVec3) -> DVec3 {
    v.any_orthonormal_vector()
}

/// The unit vector nearest to `u` that is `depth` further along the unit vector `n`: n · u' = n · u + depth; where there is
/// none, that along u + depth n.
fn push_out(u: DVec3, n: DVec3, depth: f64) -> DVec3 {
    let along = n.dot(u) + depth;
    if along >= 1.0 {
        return direction(u + depth * n).unwrap_or(n);
    }
    let side = direction(u - n.dot(u) * n).unwrap_or_else(|| across(n));
    along * n + (1.0 - along * along).max(0.0).sqrt() * side
}

/// The rotation that takes the unit vector `a` to `b` by the shortest way (Möller and Hughes, Efficiently building a matrix
/// to rotate one vector to another, 1999): with k = a × b and c = a · b, R = I + \[k\] + \[k\]²/(1 + c).
fn shortest_turn(a: DVec3, b: DVec3) -> DMat3 {
    let (k, c) = (a.cross(b), a.dot(b));
    if c < -1.0 + 1e-8 {
        // Half a turn about any axis across.
        let p = across(a);
        return 2.0 * DMat3::from_cols(p * p.x, p * p.y, p * p.z) - DMat3::IDENTITY;
    }
    let cross = DMat3::from_cols(
        DVec3::new(0.0, k.z, -k.y),
        DVec3::new(-k.z, 0.0, k.x),
        DVec3::new(k.y, -k.x, 0.0),
    );
    DMat3::IDENTITY + cross + cross * cross * (1.0 + c).recip()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Random;
    use crate::math::rotation_log;

    #[test]
    fn the_shortest_turn_takes_one_to_the_other() {
        let random = &mut Random::new(3);
        let mut unit = || direction(random.vector(1.0)).unwrap();
        for _ in 0..200 {
            let (a, b) = (unit(), unit());
            for b in [b, a, -a, direction(-a + 1e-9 * b).unwrap()] {
                let turn = shortest_turn(a, b);
                let whole = turn.transpose() * turn;
                assert!(whole.abs_diff_eq(DMat3::IDENTITY, 1e-6), "{whole}");
                assert!((turn * a).distance(b) < 2e-4, "{a} {b}");
                assert!(turn.determinant() > 0.0);
            }
            let angle = a.angle_between(b);
            assert!((rotation_log(shortest_turn(a, b)).length() - angle).abs() < 1e-9);
        }
    }

    #[test]
    fn a_push_is_to_the_nearest_direction_that_is_out() {
        let random = &mut Random::new(4);
        for _ in 0..500 {
            let [u, n, other] = [0; 3].map(|_| direction(random.vector(1.0)).unwrap());
            let depth = random.uniform(0.0, 0.5);
            let pushed = push_out(u, n, depth);
            assert!((pushed.length() - 1.0).abs() < 1e-12);
            let least = n.dot(u) + depth;
            if least < 1.0 {
                assert!(n.dot(pushed) > least - 1e-12);
                if n.dot(other) >= least {
                    assert!(other.dot(u) <= pushed.dot(u) + 1e-9);
                }
            }
        }
        assert_eq!(push_out(DVec3::X, DVec3::X, 0.1), DVec3::X);
    }

    #[test]
    fn fractions_of_a_published_step_make_the_whole() {
        for drag in [0.0, 1e-9, 0.4, 1.0] {
            let (mut velocity, pull) = (2.0, 0.3);
            for _ in 0..4 {
                let (keep, gain) = gains(drag, PUBLISHED_STEP / 4.0);
                velocity = keep * velocity + gain * pull;
            }
            let (keep, gain) = gains(drag, PUBLISHED_STEP);
            assert_eq!((keep, gain), (1.0 - drag, 1.0));
            assert!(
                (velocity - (keep * 2.0 + gain * pull)).abs() < 1e-9,
                "{drag}"
            );
        }
        let counts = [1e-3, 1.0 / 120.0, 1.0 / 60.0, 0.02, 1.0 / 30.0, 0.14].map(substeps);
        assert_eq!(counts, [1, 1, 1, 2, 2, 9]);
    }
}
