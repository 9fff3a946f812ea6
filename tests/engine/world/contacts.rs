//! What presses where: forces and pressures of the skin's vertices.

use super::limb;
use supple::collider::{Collider, Shape};
use supple::glam::DVec3;
use supple::model::{Avatar, Frame};
use supple::sim::Settings;
use supple::world::{Backend, ColliderId, InstanceId};
use supple::{Result, World};

/// Of the ball, m: it meets many vertices.
const RADIUS: f64 = 0.5;

/// A rough ball drawn along a limb that it is pressed into, and one that is held there.
pub fn pressed(backend: Backend) -> Result<(World, InstanceId, ColliderId)> {
    let mut world = World::new(backend)?.with_settings(Settings {
        report_at_end: true,
        ..Settings::default()
    })?;
    let avatar = world.add_avatar(limb(5, 8))?;
    let key = world.add_instance(avatar)?;
    world.instance_mut(key)?.teleport_to(&Frame::IDENTITY)?;
    world.instance_mut(key)?.follow_frames(&[Frame::IDENTITY])?;
    let ball = Collider {
        friction: 0.4,
        ..Collider::new(Shape::Sphere { radius: RADIUS }, at(0.12))
    };
    let ball = world.add_collider(ball)?;
    for step in 0..10 {
        world.collider_mut(ball)?.frame = at(0.12 + 1e-4 * f64::from(step));
        world.step_blocking(0.01)?;
    }
    Ok((world, key, ball))
}

fn at(x: f64) -> Frame {
    Frame {
        position: DVec3::new(x, -0.034 - RADIUS, 0.0),
        ..Frame::IDENTITY
    }
}

/// Forces add up to the report's within `sum_bound` of their lengths' sum, pressures are k δ within `depth_bound`, m, and
/// nothing is where nothing touches.
pub fn check(
    (mut world, key, ball): (World, InstanceId, ColliderId),
    sum_bound: f64,
    depth_bound: f64,
) -> Result<()> {
    let (mut forces, mut pressures) = (Vec::new(), Vec::new());
    world.read_contacts_blocking(key, &mut forces, &mut pressures)?;
    let (mut skin, mut normals) = (Vec::new(), Vec::new());
    world.read_skin_blocking(key, &mut skin, &mut normals)?;
    let areas = (world.instance(key)?.avatar() as &Avatar)
        .skin
        .measure
        .clone();
    assert_eq!((forces.len(), pressures.len()), (areas.len(), areas.len()));
    let ball = world.collider_mut(ball)?.clone();
    // The limb's nodes say nothing of their own.
    let stiffness = Collider::STIFFEST;
    let (mut sum, mut lengths, mut touching, mut sideways) = (DVec3::ZERO, 0.0, 0, 0.0f64);
    for v in 0..areas.len() {
        let found = ball.signed_distance(&ball.frame, skin[v]);
        let depth = ball.margin - found.distance;
        let want = stiffness * depth.max(0.0);
        let error = (pressures[v] - want).abs() / stiffness;
        assert!(error <= depth_bound, "vertex {v}: {error:e} m");
        assert!(pressures[v] >= 0.0);
        assert_eq!(pressures[v] == 0.0, forces[v] == DVec3::ZERO);
        if pressures[v] > 0.0 {
            touching += 1;
            let push = forces[v].dot(found.normal) / areas[v];
            // Friction is along the surface where the step began, 0.1 mm of 500 mm away.
            let error = (push - want).abs() / stiffness;
            assert!(
                error <= 2.0 * depth_bound + 0.001 * depth,
                "vertex {v}: {error:e} m"
            );
            sideways += (forces[v] - push * areas[v] * found.normal).length();
        }
        sum += forces[v];
        lengths += forces[v].length();
    }
    if world.backend() != "cpu" {
        // There a report is of where the step before ended.
        world.step_blocking(0.01)?;
    }
    let report = world.instance(key)?.report();
    assert_eq!(report.contacts, touching);
    assert!(0 < touching && touching < areas.len());
    assert!(sideways > 0.01 * lengths, "{sideways} of {lengths} N");
    let error = (sum - report.contact_force).length();
    assert!(error <= sum_bound * lengths, "{error:e} of {lengths} N");
    // Where it was put it touches nothing yet, and who sleeps takes no part.
    let calm = |world: &mut World| -> Result<bool> {
        let (mut forces, mut pressures) = (Vec::new(), Vec::new());
        world.read_contacts_blocking(key, &mut forces, &mut pressures)?;
        assert_eq!((forces.len(), pressures.len()), (areas.len(), areas.len()));
        Ok(forces.iter().all(|f| *f == DVec3::ZERO) && pressures.iter().all(|p| *p == 0.0))
    };
    assert!(!calm(&mut world)?);
    world.instance_mut(key)?.reset();
    assert!(calm(&mut world)?);
    world.step_blocking(0.01)?;
    assert!(!calm(&mut world)?);
    world.instance_mut(key)?.sleep();
    world.step_blocking(0.01)?;
    assert!(calm(&mut world)?);
    world.remove_instance(key)?;
    let error = world.read_contacts_blocking(key, &mut forces, &mut pressures);
    assert!(error.unwrap_err().to_string().contains("instance"));
    Ok(())
}

#[test]
fn forces_on_vertices_add_up_to_the_report() -> Result<()> {
    // A vertex is some 0.2 m from the world's origin.
    check(pressed(Backend::Cpu)?, 1e-9, 4.0 * f64::EPSILON)
}

/// A bone that stands as it is bound shows the tissue's displacement as it is.
#[test]
fn the_tissue_is_off_the_skinned_shape_by_what_is_drawn_beside_it() -> Result<()> {
    let (mut world, key, _) = pressed(Backend::Cpu)?;
    let (mut skin, mut normals) = (Vec::new(), Vec::new());
    world.read_skin_blocking(key, &mut skin, &mut normals)?;
    let character = world.instance(key)?;
    let rest = &character.avatar().skin.position;
    let displacement = character.displacement();
    let drawn = skin.iter().zip(rest).map(|(x, rest)| *x - *rest);
    let apart = displacement.iter().zip(drawn).map(|(u, d)| u.distance(d));
    assert!(apart.fold(0.0, f64::max) < 1e-12);
    let largest = displacement.iter().map(|u| u.length()).fold(0.0, f64::max);
    assert!(largest > 1e-4, "{largest} m");
    Ok(())
}
