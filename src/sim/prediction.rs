//! Where a step's minimisation starts.

use super::instance::Instance;
use crate::model::{InertialTarget, Skeleton, State};

/// The inertial prediction on the manifold of closed joints: rotations, handles and roots move on as inertia has them
/// ([`InertialTarget::predict`]), pinned bones are where they end, and a joint follows its parent, so that its gap stays
/// what it is.
///
/// Bones that each fly on their own open joints by ½ |ω|² h² times their length, and a pin that changes its speed by all
/// of the change: in joint springs of 1e6 N/m that is up to a joule, beside which an iteration does not see what the
/// tissue (millijoules) gains or loses.
pub(super) fn predict(
    skeleton: &Skeleton,
    instance: &Instance,
    target: &InertialTarget<'_>,
    predicted: &mut State,
) {
    predicted.clone_from(&instance.state);
    target.predict(predicted);
    pin(skeleton, instance, predicted);
}

/// The prediction of the bones, which `predicted` has, with the tissue as it is at qⁿ: what is carried along keeps its
/// momentum, and slides on where it slid, though its tissue's own swing would raise the energy.
pub(super) fn carry_on(instance: &Instance, predicted: &State, carried: &mut State) {
    carried.frames.clone_from(&predicted.frames);
    carried.handles.clone_from(&instance.state.handles);
    carried.awake.clone_from(&instance.state.awake);
}

/// qⁿ with pinned bones where they end, and what hangs on them moved along: where the minimisation starts if nothing else
/// has less energy.
pub(super) fn fall_back(skeleton: &Skeleton, instance: &Instance, fallback: &mut State) {
    fallback.clone_from(&instance.state);
    pin(skeleton, instance, fallback);
}

/// Puts pinned bones where they end, and every other joint where its parent has it.
fn pin(skeleton: &Skeleton, instance: &Instance, state: &mut State) {
    for pin in &instance.pins {
        state.frames[pin.bone] = pin.frame;
    }
    let current = &instance.state.frames;
    for (j, parent) in skeleton.parents.iter().enumerate() {
        let Some(p) = parent.map(|p| p as usize) else {
            continue;
        };
        if instance.pin_of(j).is_some() {
            continue;
        }
        let anchor = current[p].inverse_transform(current[j].position);
        state.frames[j].position = state.frames[p].transform(anchor);
    }
}

#[cfg(test)]
mod tests {
    use super::super::instance::Pin;
    use super::super::settings::Settings;
    use super::*;
    use crate::math::Random;
    use crate::model::{Frame, Integrator};
    use crate::random_avatar::random_avatar;
    use crate::skeleton::joint_gap;
    use glam::DVec3;

    /// Seven bones that tumble, their joints open by up to 0.1 mm.
    fn tumbling(seed: u64) -> (Skeleton, Instance) {
        let avatar = random_avatar(seed, 7, 3, 5, 12);
        let random = &mut Random::new(seed);
        let mut instance = Instance::new(&avatar, &Settings::default());
        for frame in &mut instance.state.frames {
            frame.position += random.vector(1e-4);
            *frame = frame.moved(random.vector(0.01), random.vector(0.1));
        }
        for handle in &mut instance.state.handles {
            *handle = random.vector(1e-3);
        }
        let rest = avatar.rest_state();
        (instance.history).set_previous(&rest, &instance.state, 0.01);
        (avatar.skeleton, instance)
    }

    /// Where each joint is, seen from its parent.
    fn anchors(skeleton: &Skeleton, state: &State) -> Vec<DVec3> {
        let joints = skeleton.parents.iter().zip(&state.frames);
        let anchor = |(parent, frame): (&Option<u32>, &Frame)| {
            parent.map(|p| state.frames[p as usize].inverse_transform(frame.position))
        };
        joints.filter_map(anchor).collect()
    }

    #[test]
    fn joints_keep_their_gaps_and_all_else_moves_on() {
        let (skeleton, instance) = tumbling(1);
        let mut predicted = instance.state.clone();
        let target = instance.history.target(Integrator::Bdf2, 0.01);
        predict(&skeleton, &instance, &target, &mut predicted);
        let mut inertial = instance.state.clone();
        target.predict(&mut inertial);
        let (before, after) = (&instance.state, &predicted);
        let anchors = [before, after].map(|state| anchors(&skeleton, state));
        for (before, after) in anchors[0].iter().zip(&anchors[1]) {
            assert!(before.distance(*after) < 1e-15, "{before} {after}");
        }
        let opened = joint_gap(&skeleton, &inertial.frames) - joint_gap(&skeleton, &before.frames);
        assert!(opened > 1e-4, "{opened} m: nothing to close");
        assert_eq!(predicted.handles, inertial.handles);
        assert_eq!(predicted.frames[0], inertial.frames[0]);
        for (a, b) in predicted.frames.iter().zip(&inertial.frames) {
            assert_eq!(a.rotation, b.rotation);
        }
    }

    #[test]
    fn a_pin_carries_what_hangs_on_it() {
        let (skeleton, mut instance) = tumbling(2);
        let bone = skeleton.parents.iter().flatten().max().copied().unwrap() as usize;
        let frame = instance.state.frames[bone].moved(DVec3::splat(0.01), DVec3::Z);
        instance.pins.push(Pin { bone, frame });
        let target = instance.history.target(Integrator::Bdf2, 0.01);
        for predicted in [true, false] {
            let mut state = instance.state.clone();
            match predicted {
                true => predict(&skeleton, &instance, &target, &mut state),
                false => fall_back(&skeleton, &instance, &mut state),
            }
            assert_eq!(state.frames[bone], frame);
            let anchors = [&instance.state, &state].map(|state| anchors(&skeleton, state));
            let moved = anchors[0].iter().zip(&anchors[1]).enumerate();
            for (k, (before, after)) in moved {
                // The joint of bone k + 1: the pinned one leaves its parent.
                let gap = before.distance(*after);
                assert!((gap < 1e-15) == (k + 1 != bone), "{gap} of bone {}", k + 1);
            }
        }
    }
}
