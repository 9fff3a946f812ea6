//! Spring bones in a step: the published dynamics, rest, collisions, any time step.

use crate::support::{LIMP, SMALL, TAIL_STEP, full_space_limb, with_tail};
use std::sync::Arc;
use supple::Result;
use supple::collider::{Collider, Shape};
use supple::file::{AvatarFile, Parts};
use supple::glam::{DMat3, DQuat, DVec3};
use supple::internal::math::{Random, rotation_log};
use supple::model::{Avatar, Frame, SpringCollider, SpringJoint};
use supple::potential::{CpuPotential, Potential};
use supple::sim::{Pin, Settings, Simulation, SpringMode};

const PUBLISHED: f64 = 1.0 / 60.0;

fn tailed(count: usize, like: SpringJoint) -> Avatar {
    with_tail(&full_space_limb(&SMALL, 1, true), count, like)
}

fn simulation(avatar: &Avatar, time_step: f64) -> Result<Simulation<CpuPotential>> {
    let potential = CpuPotential::new(Arc::new(avatar.clone()), 1)?;
    let settings = Settings {
        time_step,
        ..Settings::default()
    };
    let mut simulation = Simulation::new(avatar, potential, settings)?;
    hold(&mut simulation, Frame::IDENTITY);
    Ok(simulation)
}

fn hold(simulation: &mut Simulation<CpuPotential>, frame: Frame) {
    simulation.instances_mut()[0].pins = vec![Pin { bone: 0, frame }];
}

/// Where the tails of all spring bones are.
fn tails(avatar: &Avatar, frames: &[Frame]) -> Vec<DVec3> {
    let tail = |joint: &SpringJoint| frames[joint.bone as usize].transform(joint.tail);
    avatar.springs.joints.iter().map(tail).collect()
}

/// The root as it is shaken.
fn shaken(time: f64) -> Frame {
    Frame {
        rotation: DMat3::from_rotation_z(0.4 * (7.0 * time).sin()),
        position: DVec3::new(0.0, 0.05 * (11.0 * time).sin(), 0.03 * (5.0 * time).sin()),
    }
}

/// The published algorithm as its text has it, with quaternions and two places of each tail.
struct Published {
    joints: Vec<SpringJoint>,
    heads: Vec<DVec3>,
    now: Vec<DVec3>,
    last: Vec<DVec3>,
}

impl Published {
    fn new(avatar: &Avatar) -> Self {
        let rest = tails(avatar, &avatar.rest_state().frames);
        Self {
            joints: avatar.springs.joints.clone(),
            heads: avatar.skeleton.joints[1..].to_vec(),
            now: rest.clone(),
            last: rest,
        }
    }

    fn step(&mut self, root: &Frame, dt: f64) {
        let mut rotation = DQuat::from_mat3(&root.rotation);
        let mut head = root.transform(self.heads[0]);
        for k in 0..self.joints.len() {
            let joint = self.joints[k];
            let axis = joint.tail.normalize();
            let inertia = (self.now[k] - self.last[k]) * (1.0 - joint.drag_force);
            let stiffness = dt * (rotation * axis) * joint.stiffness;
            let next = self.now[k] + inertia + stiffness + dt * joint.gravity;
            let next = head + (next - head).normalize() * joint.tail.length();
            self.last[k] = self.now[k];
            self.now[k] = next;
            let to = (rotation.inverse() * (next - head)).normalize();
            rotation *= DQuat::from_rotation_arc(axis, to);
            head = next;
        }
    }
}

#[test]
fn at_sixty_steps_a_second_they_move_as_published() -> Result<()> {
    let falling = SpringJoint {
        gravity: DVec3::new(0.0, 0.02, -0.1),
        ..LIMP
    };
    let hair = SpringJoint {
        stiffness: 0.6,
        drag_force: 0.3,
        gravity: DVec3::NEG_Z * 0.05,
        ..LIMP
    };
    // A pendulum of one joint, then chains on a root that is shaken.
    let cases = [
        (1, falling, false),
        (1, hair, true),
        (4, hair, true),
        (4, falling, true),
    ];
    for (count, like, shakes) in cases {
        let avatar = tailed(count, like);
        let mut simulation = simulation(&avatar, PUBLISHED)?;
        let mut published = Published::new(&avatar);
        let mut way = 0.0_f64;
        for step in 1..=120 {
            let time = if shakes {
                f64::from(step) * PUBLISHED
            } else {
                0.0
            };
            hold(&mut simulation, shaken(time));
            simulation.step_blocking()?;
            published.step(&shaken(time), PUBLISHED);
            let found = tails(&avatar, &simulation.instances()[0].state.frames);
            for (found, wanted) in found.iter().zip(&published.now) {
                // Chains without drag double their rounding every few steps.
                assert!(
                    found.distance(*wanted) < 1e-9,
                    "{count} joints, step {step}: {found} {wanted}"
                );
            }
            way = way.max(found[0].distance(Published::new(&avatar).now[0]));
        }
        assert!(way > 0.03, "{way}");
    }
    Ok(())
}

/// The largest distance of the last tail from `wanted` over two seconds, at steps of `time_step`; and the path.
fn path(avatar: &Avatar, time_step: f64) -> Result<Vec<DVec3>> {
    let mut simulation = simulation(avatar, time_step)?;
    let per = (0.1 / time_step).round() as usize;
    let mut out = Vec::new();
    for step in 1..=20 * per {
        hold(&mut simulation, shaken(step as f64 * time_step));
        simulation.step_blocking()?;
        if step.is_multiple_of(per) {
            let frames = &simulation.instances()[0].state.frames;
            out.push(tails(avatar, frames)[avatar.springs.joints.len() - 1]);
        }
    }
    Ok(out)
}

#[test]
fn other_time_steps_swing_alike() -> Result<()> {
    let hair = SpringJoint {
        stiffness: 0.6,
        drag_force: 0.3,
        gravity: DVec3::NEG_Z * 0.05,
        ..LIMP
    };
    let avatar = tailed(3, hair);
    let wanted = path(&avatar, PUBLISHED)?;
    let rest = tails(&avatar, &avatar.rest_state().frames)[2];
    let swing = wanted.iter().map(|p| p.distance(rest)).fold(0.0, f64::max);
    // Below h₀ the three joints lag by half a step less each, at 11 rad/s by 0.28 rad in all. Above it substeps are of h₀, and
    // what is left is how coarsely the root's motion is told.
    for (time_step, most) in [
        (0.001, 0.28),
        (0.005, 0.28),
        (1.0 / 30.0, 0.02),
        (0.05, 0.05),
        (0.1, 0.15),
    ] {
        let found = path(&avatar, time_step)?;
        let off = found.iter().zip(&wanted).map(|(a, b)| a.distance(*b));
        let off = off.fold(0.0, f64::max) / swing;
        assert!(off < most, "{time_step} s: {off}");
    }
    Ok(())
}

#[test]
fn what_rests_stays_where_it_is_bit_by_bit() -> Result<()> {
    let hair = SpringJoint {
        stiffness: 1.0,
        drag_force: 0.4,
        ..LIMP
    };
    for time_step in [0.004, PUBLISHED, 0.05] {
        let avatar = tailed(3, hair);
        let mut simulation = simulation(&avatar, time_step)?;
        let (mut skin, mut normals) = (Vec::new(), Vec::new());
        for step in 0..40 {
            simulation.step_blocking()?;
            simulation.read_skin_blocking(0, &mut skin, &mut normals)?;
            for v in avatar.tissue_vertices()..avatar.skin.len() {
                let off = skin[v].distance(avatar.skin.position[v]);
                assert!(off < 1e-15, "step {step}, vertex {v}: {off}");
            }
            let frames = &simulation.instances()[0].state.frames[1..];
            let rest = &avatar.rest_state().frames[1..];
            assert!(
                frames
                    .iter()
                    .zip(rest)
                    .all(|(a, b)| a.rotation == b.rotation)
            );
        }
        // Pushed away it comes back to the same bits.
        hold(&mut simulation, shaken(0.2));
        simulation.step_blocking()?;
        hold(&mut simulation, Frame::IDENTITY);
        for _ in 0..(8.0 / time_step) as usize {
            simulation.step_blocking()?;
        }
        let frames = &simulation.instances()[0].state.frames[1..];
        let rest = &avatar.rest_state().frames[1..];
        assert!(
            frames
                .iter()
                .zip(rest)
                .all(|(a, b)| a.rotation == b.rotation),
            "{time_step}"
        );
    }
    Ok(())
}

#[test]
fn tails_stay_out_of_colliders_by_their_hit_radius() -> Result<()> {
    let falling = SpringJoint {
        stiffness: 0.05,
        drag_force: 0.2,
        gravity: DVec3::NEG_Z * 0.4,
        hit_radius: 0.01,
        ..LIMP
    };
    let mut avatar = tailed(3, falling);
    let root = avatar.skeleton.joints[1];
    let below =
        |along: f64, down: f64| root - avatar.skeleton.joints[0] - DVec3::new(along, 0.0, down);
    let (axis, ground) = (below(0.01, 0.11), root.z - 0.07);
    let sphere = SpringCollider {
        bone: 0,
        offset: below(0.015, 0.075),
        tail: None,
        radius: 0.03,
    };
    let capsule = SpringCollider {
        bone: 0,
        offset: axis - DVec3::Y * 0.1,
        tail: Some(axis + DVec3::Y * 0.1),
        radius: 0.02,
    };
    for (colliders, of_world) in [
        (vec![sphere], false),
        (vec![capsule], false),
        (vec![], true),
    ] {
        avatar.springs.chains[0].colliders = (0..colliders.len() as u32).collect();
        avatar.springs.colliders = colliders;
        let mut simulation = simulation(&avatar, 0.01)?;
        if of_world {
            let frame = Frame {
                position: DVec3::Z * ground,
                ..Frame::IDENTITY
            };
            let solid = Collider::new(Shape::HalfSpace, frame);
            simulation.instances_mut()[0].colliders.push(solid);
        }
        let mut met = 0;
        for step in 0..300 {
            let mut frame = shaken(f64::from(step) * 0.01);
            frame.position = DVec3::X * frame.position.y;
            hold(&mut simulation, frame);
            simulation.step_blocking()?;
            let frames = &simulation.instances()[0].state.frames;
            for tail in tails(&avatar, frames) {
                let local = frames[0].inverse_transform(tail);
                let clear = match avatar.springs.colliders.first() {
                    None => tail.z - ground,
                    Some(c) => {
                        let end = c.tail.unwrap_or(c.offset);
                        let nearest = c.offset.with_y(local.y.clamp(c.offset.y, end.y));
                        local.distance(nearest) - c.radius
                    }
                };
                assert!(clear > falling.hit_radius - 1e-9, "step {step}: {clear} m");
                met += usize::from(clear < falling.hit_radius + 1e-3);
            }
        }
        assert!(met > 20, "{met}");
    }
    Ok(())
}

#[test]
fn a_center_takes_its_own_motion_out() -> Result<()> {
    let hair = SpringJoint {
        stiffness: 0.2,
        drag_force: 0.3,
        ..LIMP
    };
    let mut avatar = tailed(2, hair);
    avatar.springs.chains[0].center = Some(0);
    let mut simulation = simulation(&avatar, 0.008)?;
    for step in 1..60 {
        hold(&mut simulation, shaken(f64::from(step) * 0.02));
        simulation.step_blocking()?;
        let frames = &simulation.instances()[0].state.frames;
        for bone in 1..3 {
            let turn = rotation_log(frames[0].rotation.transpose() * frames[bone].rotation);
            assert!(turn.length() < 1e-9, "step {step}: {turn}");
        }
    }
    Ok(())
}

#[test]
fn targets_are_where_they_return_to_and_modes_say_who_swings() -> Result<()> {
    let hair = SpringJoint {
        stiffness: 2.0,
        drag_force: 0.5,
        gravity: DVec3::NEG_Z * 0.1,
        ..LIMP
    };
    let avatar = tailed(2, hair);
    let bent = DMat3::from_rotation_y(0.6);
    let pins = |simulation: &mut Simulation<CpuPotential>| {
        let instance = &mut simulation.instances_mut()[0];
        let frame = Frame {
            rotation: bent,
            ..avatar.rest_state().frames[1]
        };
        instance.pins.push(Pin { bone: 1, frame });
    };
    for mode in [SpringMode::Off, SpringMode::Free, SpringMode::All] {
        let mut simulation = simulation(&avatar, 0.01)?;
        simulation.instances_mut()[0].springs = mode;
        pins(&mut simulation);
        for _ in 0..200 {
            simulation.step_blocking()?;
        }
        let frames = &simulation.instances()[0].state.frames;
        let angle = rotation_log(frames[1].rotation * bent.transpose()).length();
        let further = rotation_log(frames[1].rotation.transpose() * frames[2].rotation).length();
        match mode {
            SpringMode::Off => assert!(angle < 1e-14 && further < 1e-9, "{angle} {further}"),
            SpringMode::Free => assert!(angle < 1e-14 && further > 0.01, "{angle} {further}"),
            // Drawn down from where the pin says that it rests.
            _ => assert!((0.01..0.1).contains(&angle), "{angle}"),
        }
    }
    Ok(())
}

#[test]
fn any_time_step_and_any_motion_leave_them_whole() -> Result<()> {
    let wild = SpringJoint {
        stiffness: 4.0,
        drag_force: 0.0,
        gravity: DVec3::NEG_Z * 2.0,
        hit_radius: 0.02,
        ..LIMP
    };
    let mut avatar = tailed(5, wild);
    avatar.springs.colliders = vec![SpringCollider {
        bone: 0,
        offset: DVec3::ZERO,
        tail: None,
        radius: 0.4,
    }];
    avatar.springs.chains[0].colliders = vec![0];
    let random = &mut Random::new(9);
    let mut simulation = simulation(&avatar, 0.01)?;
    for step in 0..400 {
        let time_step = random.uniform(0.001_f64.ln(), 0.14_f64.ln()).exp();
        simulation.set_settings(Settings {
            time_step,
            ..Settings::default()
        })?;
        let frame = Frame {
            rotation: random.rotation(3.0),
            position: random.vector(if step % 50 == 0 { 1e3 } else { 1.0 }),
        };
        hold(&mut simulation, frame);
        simulation.step_blocking()?;
        let instance = &simulation.instances()[0];
        assert!(instance.state.is_finite() && instance.history.previous().is_finite());
        for joint in &avatar.springs.joints {
            let (bone, parent) = (joint.bone as usize, joint.bone as usize - 1);
            let frames = &instance.state.frames;
            let offset = avatar.skeleton.joints[bone] - avatar.skeleton.joints[parent];
            let gap = frames[parent]
                .transform(offset)
                .distance(frames[bone].position);
            assert!(
                gap < 1e-9 * (1.0 + frames[0].position.length()),
                "step {step}: {gap}"
            );
            assert!(frames[bone].is_rigid());
        }
    }
    Ok(())
}

#[test]
fn their_rows_are_not_in_the_hessian() -> Result<()> {
    let avatar = full_space_limb(&SMALL, 2, true);
    let blocks = |avatar: &Avatar| -> Result<usize> {
        Ok(CpuPotential::new(Arc::new(avatar.clone()), 1)?
            .pattern()
            .len())
    };
    // Of a frame that moves there would be a row across all frames; here each vertex' own.
    assert_eq!(
        blocks(&with_tail(&avatar, 100, LIMP))?,
        blocks(&avatar)? + 300
    );
    Ok(())
}

#[test]
fn a_baked_file_keeps_them_and_one_without_them_is_read() -> Result<()> {
    let path = std::path::Path::new("tail.supple");
    let avatar = tailed(3, LIMP);
    let bytes = AvatarFile::new(avatar.clone()).to_bytes(Parts::All)?;
    assert_eq!(AvatarFile::from_bytes(&bytes, path)?.avatar, avatar);
    let mut still = avatar.clone();
    still.springs = Default::default();
    let bytes = AvatarFile::new(still.clone()).to_bytes(Parts::All)?;
    assert!(!bytes.windows(4).any(|tag| tag == b"sprg"));
    assert_eq!(AvatarFile::from_bytes(&bytes, path)?.avatar, still);
    Ok(())
}

#[test]
fn what_makes_no_sense_is_refused() {
    let broken = |change: &dyn Fn(&mut Avatar)| {
        let mut avatar = tailed(3, LIMP);
        change(&mut avatar);
        avatar.validate().unwrap_err().to_string()
    };
    let joint = |change: fn(&mut SpringJoint)| {
        broken(&|avatar: &mut Avatar| change(&mut avatar.springs.joints[1]))
    };
    assert!(joint(|j| j.bone = 0).contains("springs.joints[1].bone"));
    assert!(joint(|j| j.bone = 99).contains("springs.joints[1].bone"));
    assert!(joint(|j| j.bone = 1).contains("must rise"));
    assert!(joint(|j| j.chain = 1).contains("springs.joints[1].chain"));
    assert!(joint(|j| j.tail = DVec3::ZERO).contains("springs.joints[1].tail"));
    assert!(joint(|j| j.tail.x = f64::NAN).contains("springs.joints[1].tail"));
    assert!(joint(|j| j.rest_rotation *= 2.0).contains("rest_rotation"));
    assert!(joint(|j| j.stiffness = -1.0).contains("stiffness"));
    assert!(joint(|j| j.hit_radius = f64::NAN).contains("hit_radius"));
    assert!(joint(|j| j.drag_force = 1.5).contains("drag_force"));
    assert!(joint(|j| j.gravity.y = f64::INFINITY).contains("gravity"));
    let center = broken(&|avatar| avatar.springs.chains[0].center = Some(1));
    assert!(center.contains("springs.joints[0].chain"), "{center}");
    let collider = broken(&|avatar| avatar.springs.chains[0].colliders = vec![0]);
    assert!(
        collider.contains("springs.chains[0].colliders"),
        "{collider}"
    );
    let massive = broken(&|avatar| avatar.bone_masses[3] = avatar.bone_masses[0]);
    assert!(
        massive.contains("without mass") || massive.contains("springs"),
        "{massive}"
    );
    assert_eq!(TAIL_STEP, 0.05);
}
