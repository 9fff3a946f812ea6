//! Two free bodies that collide.

use super::{CONVERGED, blocks, simulation, support};
use pollster::block_on;
use std::sync::Arc;
use supple::Result;
use supple::collider::{Collider, Shape};
use supple::glam::{DMat3, DVec3};
use supple::internal::math::Random;
use supple::model::{Avatar, BoneMass, Frame, InertialTarget, State};
use supple::potential::{CpuPotential, Evaluation, Potential, StepStart, TissueFactors};

/// Two blocks, the second of which carries a ball that the first falls on.
fn pair(friction: f64) -> (Avatar, State, Collider) {
    let avatar = blocks(2);
    let mut state = avatar.rest_state();
    let random = &mut Random::new(5);
    state.frames[0].rotation = random.rotation(0.2);
    state.frames[0].position = DVec3::new(0.004, 0.003, 0.0416);
    state.frames[1].rotation = random.rotation(1.0);
    let ball = Frame {
        rotation: DMat3::IDENTITY,
        position: DVec3::new(-0.008, 0.005, 0.0),
    };
    let ball = Collider {
        friction,
        stiffness: Some(1e7),
        body: Some(1),
        ..Collider::new(Shape::Sphere { radius: 0.03 }, ball)
    };
    (avatar, state, ball)
}

/// Σ over the mass of x × w, with x = R y + c and w likewise of `rates` (rotation, translation).
fn cross_moment(mass: &BoneMass, frame: &Frame, rates: (DMat3, DVec3)) -> DVec3 {
    let columns = |m: DMat3, v: DVec3| [m.x_axis, m.y_axis, m.z_axis, v];
    let (a, b) = (
        columns(frame.rotation, frame.position),
        columns(rates.0, rates.1),
    );
    let s = &mass.second_moment;
    let pairs = (0..16).map(|k| s[k / 4][k % 4] * a[k / 4].cross(b[k % 4]));
    pairs.sum()
}

/// What one body gives the other gets: Σ m (vⁿ⁺¹ − vⁿ) = 0, and Σ m xⁿ⁺¹ × (vⁿ⁺¹ − vⁿ) = 0, which is how
/// backward Euler keeps angular momentum.
#[test]
fn two_free_bodies_that_collide_keep_their_momentum() -> Result<()> {
    for friction in [0.0, 0.6] {
        let (avatar, state, ball) = pair(friction);
        let mut simulation = simulation(&avatar, CONVERGED)?;
        let instance = &mut simulation.instances_mut()[0];
        instance.gravity = DVec3::ZERO;
        instance.colliders.push(ball);
        instance.set_state(state);
        let approach = Frame::moved(
            &instance.state.frames[0],
            DVec3::new(-2e-3, 1e-3, 5e-3),
            DVec3::new(0.02, -0.03, 0.05),
        );
        let mut previous = instance.state.clone();
        previous.frames[0] = approach;
        (instance.history).set_previous(&previous, &instance.state, 0.01);
        let (mut exchanged, mut turned, mut touched, mut slid) = (0.0, 0.0, 0, 0.0);
        for step in 0..30 {
            let [old, now] = [0, 1].map(|_| simulation.instances()[0].clone());
            let report = simulation.step_blocking()?.instances.remove(0);
            let new = &simulation.instances()[0].state;
            touched += report.contacts;
            slid = f64::max(slid, report.energies.friction.abs());
            let changes = (0..2).map(|j| {
                let (a, b, c) = (
                    &old.history.previous().frames[j],
                    &now.state.frames[j],
                    &new.frames[j],
                );
                // Of the first step the one before was an instant.
                let before = 0.01 / now.history.last_step();
                let rotation = (c.rotation - b.rotation) - (b.rotation - a.rotation) * before;
                let position = (c.position - b.position) - (b.position - a.position) * before;
                let (mass, _) = avatar.bone_masses[j].moments();
                let torque = cross_moment(&avatar.bone_masses[j], c, (rotation, position));
                (mass * position, torque)
            });
            let changes: Vec<_> = changes.collect();
            let (force, torque) = (changes[0].0 + changes[1].0, changes[0].1 + changes[1].1);
            exchanged = f64::max(exchanged, changes[0].0.length());
            turned = f64::max(turned, changes[0].1.length());
            assert!(
                force.length() < 1e-8 * exchanged.max(1e-4),
                "{step}: {force}"
            );
            assert!(
                torque.length() < 1e-8 * turned.max(1e-5),
                "{step}: {torque}"
            );
        }
        assert!(
            touched > 0 && exchanged > 1e-5 && turned > 1e-8,
            "{touched} {exchanged} {turned}"
        );
        assert_eq!(slid > 0.0, friction > 0.0);
    }
    Ok(())
}

/// A collider touches no vertex of the frame that carries it, and only frames without tissue carry.
#[test]
fn nothing_touches_what_its_own_frame_carries() -> Result<()> {
    let (avatar, mut state, ball) = pair(0.0);
    state.frames[0].position.z = 0.02;
    let mut potential = CpuPotential::new(Arc::new(avatar.clone()), 1)?;
    let contacts = |potential: &mut CpuPotential, ball: Collider| -> Result<usize> {
        let colliders = [ball];
        let start = StepStart {
            time_step: 0.01,
            inertia: InertialTarget::backward_euler(&state, 0.01),
            current: &state,
            colliders: &colliders,
            tissue_gravity: DVec3::ZERO,
            slip_speed: 1e-3,
            geometric_contact: false,
            factors: TissueFactors::default(),
            pose_offsets: &[],
            prescribed: &[],
        };
        let mut out = [Evaluation::default()];
        block_on(potential.begin_step(&[start], &[true]))?;
        block_on(potential.evaluate(&[state.clone()], &[true], &mut out))?;
        Ok(out[0].contacts)
    };
    // The ball reaches vertices of both blocks, and is carried by one of them.
    let kinematic = Collider {
        body: None,
        ..ball.clone()
    };
    let (of_other, of_all) = (
        contacts(&mut potential, ball.clone())?,
        contacts(&mut potential, kinematic)?,
    );
    assert!(
        (1..=25).contains(&of_other) && of_all > 25,
        "{of_other} of {of_all}"
    );
    let limb = support::full_space_limb(&support::SMALL, 1, true);
    let mut soft = simulation(&limb, CONVERGED)?;
    soft.instances_mut()[0].colliders.push(Collider {
        body: Some(0),
        ..ball
    });
    let error = soft.step_blocking().unwrap_err().to_string();
    assert!(error.contains("].body"), "{error}");
    Ok(())
}
