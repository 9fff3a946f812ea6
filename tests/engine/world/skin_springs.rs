//! Springs that pull at the skin.

use super::{converged, limb};
use supple::glam::DVec3;
use supple::model::{Frame, State};
use supple::sim::SkinSpring;
use supple::skeleton::Spring;
use supple::world::InstanceId;
use supple::{Result, World};

const STIFFNESS: f64 = 400.0;

/// A limb whose bone is where it is told to be, and its vertex that is farthest out.
fn held() -> Result<(World, InstanceId, usize)> {
    let mut world = converged()?;
    world.set_gravity(DVec3::ZERO);
    let avatar = limb(5, 8);
    let skin = &avatar.skin;
    let out = |v: &usize| skin.measure[*v] * skin.basis.row(*v).len() as f64;
    let vertex = (0..skin.len()).max_by(|a, b| out(a).total_cmp(&out(b)));
    let vertex = vertex.unwrap_or_default();
    let avatar = world.add_avatar(avatar.clone())?;
    let key = world.add_instance(avatar)?;
    world.instance_mut(key)?.teleport_to(&Frame::IDENTITY)?;
    world.instance_mut(key)?.follow_frames(&[Frame::IDENTITY])?;
    Ok((world, key, vertex))
}

fn place(world: &mut World, key: InstanceId, vertex: usize) -> Result<DVec3> {
    let (mut skin, mut normals) = (Vec::new(), Vec::new());
    world.read_skin_blocking(key, &mut skin, &mut normals)?;
    Ok(skin[vertex])
}

/// Flesh follows until its own force is the spring's, and what holds the bone bears that.
#[test]
fn what_pulls_is_borne_by_what_holds_the_bones() -> Result<()> {
    let (mut world, key, vertex) = held()?;
    let start = place(&mut world, key, vertex)?;
    let to = start + DVec3::new(0.002, 0.006, -0.004);
    let avatar = world.instance(key)?.avatar().clone();
    let spring = SkinSpring::new(&avatar, vertex, to, STIFFNESS)?;
    world.instance_mut(key)?.pull_skin(&[spring]);
    for _ in 0..300 {
        world.step_blocking(0.01)?;
    }
    let at = place(&mut world, key, vertex)?;
    let force = STIFFNESS * (to - at);
    let moved = at.distance(start);
    assert!(moved > 5e-4 && force.length() > 0.2, "{moved} m, {force} N");
    let report = world.instance(key)?.report();
    let [load] = report.loads[..] else {
        panic!("{:?}", report.loads)
    };
    let error = (load.force + force).length();
    assert!(error < 1e-4 * force.length(), "{} N, {force} N", load.force);
    assert!(report.skeleton_energies.tracking.abs() < 1e-9);
    world.instance_mut(key)?.pull_skin(&[]);
    for _ in 0..300 {
        world.step_blocking(0.01)?;
    }
    assert!(place(&mut world, key, vertex)?.distance(start) < 1e-5);
    Ok(())
}

/// A bone that a soft spring keeps in its place comes along.
#[test]
fn bones_give_way_to_a_pull() -> Result<()> {
    let (mut world, key, vertex) = held()?;
    let soft = Spring {
        stiffness: 200.0,
        damping: 4.0,
    };
    let firm = Spring {
        stiffness: 1e3,
        damping: 10.0,
    };
    world
        .instance_mut(key)?
        .track_frames(&[Frame::IDENTITY], firm, soft)?;
    let to = place(&mut world, key, vertex)? + 0.02 * DVec3::Y;
    let avatar = world.instance(key)?.avatar().clone();
    let spring = SkinSpring::new(&avatar, vertex, to, STIFFNESS)?;
    world.instance_mut(key)?.pull_skin(&[spring]);
    for _ in 0..300 {
        world.step_blocking(0.01)?;
    }
    let bone = world.instance(key)?.frames()[0].position;
    let force = STIFFNESS * (to - place(&mut world, key, vertex)?);
    let borne = soft.stiffness * bone.y;
    assert!(bone.y > 2e-3, "{bone} m");
    assert!(
        (borne - force.y).abs() < 0.01 * force.y,
        "{borne} N, {force} N"
    );
    Ok(())
}

#[test]
fn what_cannot_be_pulled_is_refused_by_name() -> Result<()> {
    let (mut world, key, vertex) = held()?;
    let avatar = world.instance(key)?.avatar().clone();
    let at = DVec3::ZERO;
    for (vertex, place, stiffness, field) in [
        (avatar.skin.len(), at, 1.0, "skin_spring.vertex"),
        (vertex, DVec3::NAN, 1.0, "skin_spring.place"),
        (vertex, at, -1.0, "skin_spring.stiffness"),
        (vertex, at, f64::NAN, "skin_spring.stiffness"),
    ] {
        let refused = SkinSpring::new(&avatar, vertex, place, stiffness);
        let message = refused.unwrap_err().to_string();
        assert!(message.starts_with(field), "{message}");
    }
    // One that was made unusable later, or is another avatar's.
    let mut spring = SkinSpring::new(&avatar, vertex, at, 1.0)?;
    spring.place.x = f64::INFINITY;
    let large = limb(9, 12);
    let others = SkinSpring::new(&large, large.skin.len() - 1, at, 1.0)?;
    let before: State = world.instance(key)?.state().clone();
    for (spring, says) in [(spring, "skin_springs.place"), (others, "another avatar")] {
        world.instance_mut(key)?.pull_skin(&[spring]);
        let message = world.step_blocking(0.01).unwrap_err().to_string();
        assert!(message.contains(says), "{message}");
        assert_eq!(before, *world.instance(key)?.state());
    }
    Ok(())
}
