//! Which fine handles are awake: those near what touches, ahead of it.
//!
//! A handle wakes when a collider comes within reach of its support, at the end of the next frame or anywhere on its way there,
//! and near what a spring pulls at, the nearest first, up to the slots that there are. It falls asleep when nothing is within a
//! longer reach and it has come to rest: then the rest of its φ is taken back, no more than [`DRIFT`] a frame, so that nothing
//! jumps. Where all slots are taken and a handle waits that is nearer by a spacing, the one that carries least of those farther is
//! eased out in the same way. The finer cubature fades in and out, slower where the tissue is loaded: swapping the points of a
//! cell moves the balance by up to half of its displacement.

use super::instance::Instance;
use super::skin_spring::SkinSpring;
use super::waking_memory::{Near, WakingMemory};
use crate::collider::Collider;
use crate::math::Rows;
use crate::model::{Avatar, Awake, BasisEntry, FineHandles, SkinWeight, State};
use glam::DVec3;
use std::sync::Arc;

/// Within so many spacings of a collider a handle wakes: as far as its column reaches.
const REACH: f64 = 3.0;
/// It may sleep beyond so many.
const SLEEP: f64 = 4.5;
/// A frame moves no vertex by more than this when handles fall asleep or cells fade, m.
const DRIFT: f64 = 5e-5;

/// What decides, constant.
#[derive(Clone, Debug)]
pub(crate) struct Waking {
    fine: Arc<FineHandles>,
    coarse: usize,
    joints: Vec<DVec3>,
    /// Rest place of each handle, m, with the bones and coarse handles of its skin vertex.
    rest: Vec<DVec3>,
    skinning: Rows<SkinWeight>,
    basis: Rows<BasisEntry>,
    /// Coarse handles of each coarse cubature point.
    cells: Rows<BasisEntry>,
}

impl Waking {
    /// Of an avatar with slots for fine handles; `None` without.
    pub fn new(avatar: &Avatar) -> Option<Self> {
        let fine = &avatar.fine;
        if fine.slots == 0 {
            return None;
        }
        let tissue = avatar.tissue_vertices();
        let nearest = |place: &DVec3| {
            let distance = |v: &usize| avatar.skin.position[*v].distance_squared(*place);
            (0..tissue).min_by(|a, b| distance(a).total_cmp(&distance(b)))
        };
        let vertices: Vec<usize> = fine.positions.iter().filter_map(nearest).collect();
        let row = |v: &usize| avatar.skin.skinning.row(*v).iter().copied();
        let handles = |v: &usize| avatar.skin.basis.row(*v).iter().copied();
        Some(Self {
            coarse: avatar.coarse_handles(),
            joints: avatar.skeleton.joints.clone(),
            rest: fine.positions.clone(),
            skinning: vertices.iter().map(row).collect(),
            basis: vertices.iter().map(handles).collect(),
            cells: avatar.cubature.basis.clone(),
            fine: fine.clone(),
        })
    }

    /// First of the handles that stand for fine ones.
    pub fn first_slot(&self) -> usize {
        self.coarse
    }

    /// Nothing that is farther than this wakes a handle, m.
    pub fn reach(&self) -> f64 {
        REACH * self.fine.spacing
    }

    /// Wakes and lets sleep what the next frame of `instance` asks for, of which `budget` may be awake; `colliders` are those that
    /// may come near it.
    pub fn update(&self, instance: &mut Instance, colliders: &[Collider], budget: usize) {
        let Instance {
            state,
            history,
            awake,
            waking,
            skin_springs,
            ..
        } = instance;
        awake.complete(&self.fine);
        self.measure(state, colliders, skin_springs, waking);
        waking.leaving.resize(awake.handles().len(), false);
        let budget = budget.min(self.fine.slots);
        // Sorted in place: a step allocates nothing.
        (waking.near).sort_unstable_by(|a, b| {
            (a.distance.total_cmp(&b.distance)).then(a.handle.cmp(&b.handle))
        });
        self.ease_out(state, awake, waking, budget);

        // Those that are far and still, from the last slot on: the one that takes a freed slot has been looked at.
        let sleeps = SLEEP * self.fine.spacing;
        for slot in (0..awake.handles().len()).rev() {
            let at = self.coarse + slot;
            let handle = awake.handles()[slot] as usize;
            let far = waking.distances[handle] > sleeps;
            let (phi, before) = (state.handles[at], history.previous().handles[at]);
            let still = waking.leaving[slot] || phi.distance(before) < 0.2 * DRIFT;
            waking.leaving[slot] = far && still || waking.eased_out == Some(handle as u32);
            if !waking.leaving[slot] {
                continue;
            }
            let length = phi.length();
            let back = match length > DRIFT {
                true => phi * (DRIFT / length),
                false => phi,
            };
            let states = std::iter::once(&mut *state).chain(history.states_mut());
            // Shifted in all of them: no velocity comes of it.
            states.for_each(|state| state.handles[at] -= back);
            if length <= DRIFT {
                let states = std::iter::once(&mut *state).chain(history.states_mut());
                awake.sleep(self.coarse, slot, states);
                waking.leaving.swap_remove(slot);
            }
        }

        let wakes = |near: &&Near| awake.slot_of(near.handle).is_none();
        let free = budget.saturating_sub(awake.handles().len());
        let mut chosen = 0;
        for k in 0..waking.near.len() {
            let near = waking.near[k];
            if chosen < free && wakes(&&near) {
                waking.near[chosen] = near;
                chosen += 1;
            }
        }
        for k in 0..chosen {
            let handle = waking.near[k].handle;
            let states = std::iter::once(&mut *state).chain(history.states_mut());
            awake.wake(&self.fine, self.coarse, handle, states);
            waking.leaving.push(false);
        }

        let (slots, fine) = (&state.handles[self.coarse..], &*self.fine);
        let largest = slots.iter().map(|phi| phi.length()).fold(0.0, f64::max);
        awake.fade(fine, |cell| {
            let row = self.cells.row(cell as usize).iter();
            let coarse: DVec3 = row
                .map(|u| u.value * state.handles[u.handle as usize])
                .sum();
            DRIFT / (coarse.length() + largest).max(DRIFT)
        });
    }

    /// Chooses which handle makes room where more are awake than may be, or where all may and a nearer one waits: the one that
    /// carries least of those that are clearly farther. One at a time, and the same until it sleeps or is in nobody's way any more.
    fn ease_out(&self, state: &State, awake: &Awake, waking: &mut WakingMemory, budget: usize) {
        let handles = awake.handles();
        let waits = waking
            .near
            .iter()
            .find(|near| !handles.contains(&near.handle));
        let limit = match handles.len() {
            count if count > budget => f64::NEG_INFINITY,
            count if count == budget => {
                waits.map_or(f64::INFINITY, |near| near.distance + self.fine.spacing)
            }
            _ => f64::INFINITY,
        };
        let in_the_way = |handle: &u32| waking.distances[*handle as usize] > limit;
        let kept =
            (waking.eased_out).filter(|handle| handles.contains(handle) && in_the_way(handle));
        let carried = |slot: &usize| state.handles[self.coarse + slot].length_squared();
        waking.eased_out = kept.or_else(|| {
            let slots = (0..handles.len()).filter(|slot| in_the_way(&handles[*slot]));
            let least = slots.min_by(|a, b| carried(a).total_cmp(&carried(b)));
            least.map(|slot| handles[slot])
        });
    }

    /// Distance of every handle from what may touch it in the next frame, and the list of those within reach.
    fn measure(
        &self,
        state: &State,
        colliders: &[Collider],
        springs: &[SkinSpring],
        waking: &mut WakingMemory,
    ) {
        waking.near.clear();
        waking.distances.clear();
        if colliders.is_empty() && springs.is_empty() {
            waking.distances.resize(self.fine.len(), f64::INFINITY);
            return;
        }
        let reach = REACH * self.fine.spacing;
        for (handle, rest) in self.rest.iter().enumerate() {
            let basis = self.basis.row(handle).iter();
            let moved: DVec3 = basis
                .map(|u| u.value * state.handles[u.handle as usize])
                .sum();
            let skinning = self.skinning.row(handle).iter();
            let place: DVec3 = skinning
                .clone()
                .map(|w| {
                    let frame = &state.frames[w.bone as usize];
                    let arm = *rest + moved - self.joints[w.bone as usize];
                    w.weight * (frame.position + frame.rotation * arm)
                })
                .sum();
            let of = |collider: &Collider| {
                let own = |w: &SkinWeight| Some(w.bone) == collider.body;
                if skinning.clone().any(own) {
                    return f64::INFINITY;
                }
                let end = collider.world_frame(&state.frames);
                let start = collider.previous_world_frame(&state.frames);
                // Anywhere on its way: what it sweeps counts as its own.
                let swept = end.position.distance(start.position);
                let distance = collider.signed_distance(&end, place).distance;
                distance - collider.margin - swept
            };
            let pulled = springs.iter().map(|spring| spring.rest().distance(*rest));
            let distances = colliders.iter().map(of).chain(pulled);
            let distance = distances.fold(f64::INFINITY, f64::min);
            waking.distances.push(distance);
            if distance < reach {
                let handle = handle as u32;
                waking.near.push(Near { handle, distance });
            }
        }
    }
}
