//! Frames of unlike lengths, and what jumps in them.

use super::simulation;
use crate::support;
use supple::Result;
use supple::collider::{Collider, Shape};
use supple::glam::DVec3;
use supple::internal::cpu::min_det_f;
use supple::internal::math::Random;
use supple::model::{Frame, RigidBody};
use supple::sim::Settings;

/// A box dropped 5 mm onto the floor comes to rest within half a second and never gains energy, also where single short
/// frames stand between others.
#[test]
fn a_dropped_box_rests_whatever_the_frames() -> Result<()> {
    let half = 0.02;
    let shape = Shape::Box {
        half_extents: [half; 3],
    };
    let start = 0.005 + half;
    let at = Frame {
        position: DVec3::new(0.0, 1.0, start),
        ..Frame::IDENTITY
    };
    let body = RigidBody::new("box", shape, 800.0)?.at(at);
    let limb = support::full_space_limb(&support::SMALL, 1, true);
    let avatar = limb.with_bodies(vec![body])?;
    for long in [1.0 / 60.0, 1.0 / 30.0] {
        for short in [0.5e-3, 1e-3, 2e-3, long] {
            let mut simulation = simulation(&avatar, Settings::default());
            let instance = &mut simulation.instances_mut()[0];
            let frame = instance.state.frames[0];
            instance.pins.push(supple::sim::Pin { bone: 0, frame });
            instance
                .colliders
                .push(Collider::new(Shape::HalfSpace, Frame::IDENTITY));
            let (mut time, mut k, mut highest) = (0.0, 0, 0.0f64);
            let mut heights = Vec::new();
            while time < 0.8 {
                let time_step = if k % 5 == 4 { short } else { long };
                simulation.set_settings(Settings {
                    time_step,
                    ..Settings::default()
                })?;
                let before = simulation.instances()[0].state.frames[1].position.z;
                simulation.step_blocking()?;
                let z = simulation.instances()[0].state.frames[1].position.z;
                let speed = (z - before) / time_step;
                highest = highest.max(9.81 * z + 0.5 * speed * speed);
                time += time_step;
                k += 1;
                if time > 0.5 {
                    heights.push(z);
                }
            }
            println!(
                "{long} and {short} s: up to {:.2} of its energy",
                highest / (9.81 * start)
            );
            assert!(
                highest <= 9.81 * start * 1.0001,
                "{long}, {short}: {highest}"
            );
            let still = heights.iter().all(|z| (z - half).abs() < 1e-4);
            assert!(still, "{long}, {short}: {heights:?}");
        }
    }
    Ok(())
}

/// What a share of 1 takes away: a root that is shaken at random and put 5 m elsewhere moves no tissue. Without a share the
/// default's largest acceleration keeps such a jump from doing harm.
#[test]
fn a_root_that_jumps_does_no_harm() -> Result<()> {
    let avatar = support::full_space_limb(&support::SMALL, 1, true);
    for (share, bound) in [(1.0, 1e-6), (0.0, 0.03)] {
        let mut simulation = simulation(&avatar, Settings::default());
        let instance = &mut simulation.instances_mut()[0];
        instance.gravity = DVec3::ZERO;
        instance.inertia_share = share;
        let start = instance.state.frames[0];
        instance.pins.push(supple::sim::Pin {
            bone: 0,
            frame: start,
        });
        let random = &mut Random::new(4);
        let mut place = start;
        let (mut farthest, mut smallest) = (0.0f64, f64::MAX);
        for step in 0..120 {
            // Shaken only where nothing of that may be felt.
            if share == 1.0 {
                place = place.moved(random.vector(0.02), random.vector(0.1));
            }
            if step == 60 {
                place.position += DVec3::new(3.0, 0.0, 4.0);
            }
            simulation.instances_mut()[0].pins[0].frame = place;
            simulation.step_blocking()?;
            let state = &simulation.instances()[0].state;
            let longest = state.handles.iter().map(|h| h.length());
            farthest = farthest.max(longest.fold(0.0, f64::max));
            smallest = smallest.min(min_det_f(&avatar, state));
        }
        println!("share {share}: {farthest:e} m, det F {smallest}");
        assert!(farthest < bound, "share {share}: {farthest:e} m");
        assert!(smallest > 0.3, "share {share}: det F {smallest}");
        assert!(share == 1.0 || farthest > 1e-4, "it is not felt at all");
    }
    Ok(())
}
