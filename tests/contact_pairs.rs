//! Contact and friction as a whole: a rigid block on an incline, two free bodies that collide, and skin
//! dragged by a plate in full space.

mod support;

use pollster::block_on;
use std::sync::Arc;
use supple::Result;
use supple::collider::{Collider, MeshShape, Shape};
use supple::glam::{DMat3, DVec3};
use supple::math::{Random, Rows};
use supple::model::{
    Avatar, BoneMass, Frame, PointSet, PoseBlend, Skeleton, SkinWeight, SoftLayer, State, Surface,
};
use supple::potential::{Evaluation, Potential, StepStart};
use supple::reference::Reference;
use supple::sim::{Pin, Settings, Simulation, SolverMode, SparseCholesky, Stop};

const GRAVITY: f64 = 9.81;
const HALF: DVec3 = DVec3::new(0.02, 0.02, 0.01);

/// Free rigid blocks without tissue, each with a grid of vertices on its lower face.
fn blocks(count: usize) -> Avatar {
    let half = HALF.to_array();
    let mass = 8000.0 * HALF.x * HALF.y * HALF.z;
    let mut second_moment = [[0.0; 4]; 4];
    for axis in 0..3 {
        second_moment[axis][axis] = mass * half[axis] * half[axis] / 3.0;
    }
    second_moment[3][3] = mass;
    const GRID: usize = 5;
    let at = |k: usize| -1.0 + 2.0 * k as f64 / (GRID - 1) as f64;
    let grid = (0..GRID * GRID).map(|k| HALF * DVec3::new(at(k % GRID), at(k / GRID), -1.0));
    let grid: Vec<DVec3> = grid.collect();
    let vertices = count * grid.len();
    let empty = PointSet {
        position: Vec::new(),
        measure: Vec::new(),
        skinning: Rows::default(),
        basis: Rows::default(),
        pose_blend: PoseBlend::default(),
    };
    let avatar = Avatar {
        name: "blocks".into(),
        skeleton: Skeleton {
            names: (0..count).map(|j| format!("block {j}")).collect(),
            parents: vec![None; count],
            joints: vec![DVec3::ZERO; count],
            aliases: Vec::new(),
            limits: Vec::new(),
        },
        bone_masses: vec![BoneMass { second_moment }; count],
        handles: Vec::new(),
        cubature: empty.clone(),
        skin: PointSet {
            position: (0..count).flat_map(|_| grid.clone()).collect(),
            measure: vec![4.0 * HALF.x * HALF.y / grid.len() as f64; vertices],
            skinning: (0..vertices)
                .map(|v| {
                    [SkinWeight {
                        bone: (v / grid.len()) as u32,
                        weight: 1.0,
                    }]
                })
                .collect(),
            basis: (0..vertices).map(|_| []).collect(),
            ..empty
        },
        triangles: Vec::new(),
        layer: SoftLayer {
            skin_embedding: (0..vertices).map(|_| []).collect(),
            ..SoftLayer::default()
        },
        ..support::full_space_limb(&support::SMALL, 1, true)
    };
    avatar.validate().unwrap();
    avatar
}

fn simulation(avatar: &Avatar, solver: SolverMode) -> Result<Simulation<Reference>> {
    let potential = Reference::new(Arc::new(avatar.clone()), 1, 1000)?;
    let settings = Settings {
        solver,
        ..Settings::default()
    };
    Simulation::new(avatar, potential, settings)
}

const CONVERGED: SolverMode = SolverMode::Converged {
    tolerance: 1e-11,
    max_iterations: 100,
};

/// The block's speed down an incline of angle α in time, one entry a step.
fn incline(alpha: f64, friction: f64, solver: SolverMode) -> Result<Vec<f64>> {
    let floor = Collider {
        friction,
        ..Collider::new(Shape::HalfSpace, Frame::IDENTITY)
    };
    slide(alpha, floor, solver)
}

/// The same on any `floor` that is even along x: at angle 0 its surface is at z = 0 at the origin.
fn slide(alpha: f64, floor: Collider, solver: SolverMode) -> Result<Vec<f64>> {
    let avatar = blocks(1);
    let mut simulation = simulation(&avatar, solver)?;
    let turn = DMat3::from_rotation_y(alpha);
    let down = turn * DVec3::X;
    let instance = &mut simulation.instances_mut()[0];
    let turned = Frame {
        rotation: turn,
        position: DVec3::ZERO,
    };
    // Where the weight is borne: k a δ |∇d| = m g cos α.
    let (mass, _) = avatar.bone_masses[0].moments();
    let slope = floor.signed_distance(&floor.frame, DVec3::ZERO).normal.z;
    let depth = mass * GRAVITY * alpha.cos() / (1e8 * 4.0 * HALF.x * HALF.y * slope * slope);
    let frame = turned.compose(&floor.frame);
    instance.colliders.push(Collider {
        frame,
        previous: frame,
        ..floor
    });
    let mut state = instance.state.clone();
    state.frames[0] = Frame {
        rotation: turn,
        position: turn * (DVec3::Z * (HALF.z - depth)),
    };
    instance.place(state);
    let mut speeds = Vec::new();
    for _ in 0..60 {
        simulation.step_blocking()?;
        let instance = &simulation.instances()[0];
        let moved = instance.state.frames[0].position - instance.previous.frames[0].position;
        speeds.push(down.dot(moved) / simulation.settings().time_step);
    }
    Ok(speeds)
}

/// Below tan α = μ the smoothing lets it creep at the speed v with f₀′ = 1 − (1 − v/ε_v)² = tan α/μ.
#[test]
fn a_block_sticks_below_the_angle_of_friction() -> Result<()> {
    for solver in [CONVERGED, SolverMode::OneIteration] {
        for ratio in [0.3, 0.8, 0.97] {
            let friction: f64 = 0.5;
            let speeds = incline((ratio * friction).atan(), friction, solver)?;
            let expected = 1e-3 * (1.0 - (1.0 - ratio).sqrt());
            let last = speeds[speeds.len() - 1];
            assert!(
                (last - expected).abs() < 1e-3 * expected,
                "{solver:?}, tan α = {ratio} μ: creeps at {last}, expected {expected} m/s"
            );
        }
    }
    Ok(())
}

#[test]
fn a_block_slides_above_the_angle_of_friction() -> Result<()> {
    for solver in [CONVERGED, SolverMode::OneIteration] {
        for (ratio, friction) in [(1.1_f64, 0.5), (2.0, 0.5), (1.5, 0.2)] {
            let alpha = (ratio * friction).atan();
            let speeds = incline(alpha, friction, solver)?;
            let expected = GRAVITY * (alpha.sin() - friction * alpha.cos());
            let measured = (speeds[59] - speeds[29]) / 0.3;
            assert!(
                (measured - expected).abs() < 1e-3 * expected,
                "{solver:?}, tan α = {ratio} μ: a = {measured}, expected {expected} m/s²"
            );
        }
        // Without friction it falls freely along the slope.
        let speeds = incline(0.3, 0.0, solver)?;
        let measured = (speeds[59] - speeds[29]) / 0.3;
        assert!((measured / (GRAVITY * 0.3_f64.sin()) - 1.0).abs() < 1e-4);
    }
    Ok(())
}

/// A thin plate and a cube high above it, whose distance is so coarsely sampled that its slope over the
/// plate is a half: d rises from 0 at the nodes on the plate's underside to t at those t above it, t thick.
fn coarse_plate() -> Result<Collider> {
    let cell = 0.01;
    let block = |half: DVec3, middle: DVec3| -> Result<Surface> {
        let half_extents = half.to_array();
        let mut surface = Shape::Box { half_extents }.sampled(50)?;
        surface.positions.iter_mut().for_each(|p| *p += middle);
        Ok(surface)
    };
    // 4 cells of the 47 on either side are the border.
    let height = 39.0 * cell;
    let mut surface = block(DVec3::new(1.2, 0.1, 0.25 * cell), DVec3::Z * 0.25 * cell)?;
    let above = block(DVec3::splat(cell), DVec3::Z * (height - cell))?;
    let first = surface.positions.len() as u32;
    surface.positions.extend(above.positions);
    let triangles = above.triangles.iter().map(|t| t.map(|v| first + v));
    surface.triangles.extend(triangles);
    let top = Frame {
        position: DVec3::Z * (-0.5 * cell),
        ..Frame::IDENTITY
    };
    Ok(Collider {
        margin: 0.25 * cell,
        ..Collider::new(Shape::Mesh(MeshShape::new(&surface)?), top)
    })
}

/// A floor that is a mesh holds and lets go like a half-space; also where ∇d is no unit vector, since what
/// rubs is the push and not k a δ.
#[test]
fn a_block_on_a_mesh_slides_as_on_a_half_space() -> Result<()> {
    let half_extents = [1.2, 0.1, 0.05];
    let slab = Shape::Box { half_extents }.sampled(200)?;
    let under = Frame {
        position: DVec3::Z * -0.05,
        ..Frame::IDENTITY
    };
    let slab = Collider::new(Shape::Mesh(MeshShape::new(&slab)?), under);
    for (floor, slope) in [(slab, 1.0), (coarse_plate()?, 0.5)] {
        let normal = floor.signed_distance(&floor.frame, DVec3::ZERO).normal;
        assert!((normal - DVec3::Z * slope).length() < 1e-5, "{normal}");
        for ratio in [0.8, 2.0] {
            let friction: f64 = 0.4;
            let alpha = (ratio * friction).atan();
            let floor = Collider {
                friction,
                ..floor.clone()
            };
            let speeds = slide(alpha, floor, SolverMode::OneIteration)?;
            let flat = incline(alpha, friction, SolverMode::OneIteration)?;
            // Distances are kept in f32: of 0.1 m to 6e-9 m, while the block sinks in by microns.
            for (mesh, flat) in speeds.iter().zip(&flat).skip(30) {
                assert!(
                    (mesh - flat).abs() < 5e-3 * flat,
                    "|∇d| = {slope}, tan α = {ratio} μ: {mesh} and {flat} m/s"
                );
            }
        }
    }
    Ok(())
}

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
        stiffness: 1e7,
        carrier: Some(1),
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
        instance.place(state);
        let approach = Frame::moved(
            &instance.state.frames[0],
            DVec3::new(-2e-3, 1e-3, 5e-3),
            DVec3::new(0.02, -0.03, 0.05),
        );
        instance.previous.frames[0] = approach;
        let (mut exchanged, mut turned, mut touched, mut rubbed) = (0.0, 0.0, 0, 0.0);
        for step in 0..30 {
            let [old, now] = [0, 1].map(|_| simulation.instances()[0].clone());
            let report = simulation.step_blocking()?.instances.remove(0);
            let new = &simulation.instances()[0].state;
            touched += report.contacts;
            rubbed = f64::max(rubbed, report.energies.friction.abs());
            let changes = (0..2).map(|j| {
                let (a, b, c) = (
                    &old.previous.frames[j],
                    &now.state.frames[j],
                    &new.frames[j],
                );
                let rotation = (c.rotation - b.rotation) - (b.rotation - a.rotation);
                let position = (c.position - b.position) - (b.position - a.position);
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
        assert_eq!(rubbed > 0.0, friction > 0.0);
    }
    Ok(())
}

/// A collider touches no vertex of the frame that carries it, and only frames without tissue carry.
#[test]
fn nothing_touches_what_its_own_frame_carries() -> Result<()> {
    let (avatar, mut state, ball) = pair(0.0);
    state.frames[0].position.z = 0.02;
    let mut potential = Reference::new(Arc::new(avatar.clone()), 1, 1000)?;
    let contacts = |potential: &mut Reference, ball: Collider| -> Result<usize> {
        let colliders = [ball];
        let start = StepStart {
            time_step: 0.01,
            previous: &state,
            current: &state,
            colliders: &colliders,
            tissue_gravity: DVec3::ZERO,
            slip_speed: 1e-3,
            geometric_contact: false,
        };
        let mut out = [Evaluation::default()];
        block_on(potential.begin_step(&[start], &[true]))?;
        block_on(potential.evaluate(&[state.clone()], &[true], &mut out))?;
        Ok(out[0].contacts)
    };
    // The ball reaches vertices of both blocks, and is carried by one of them.
    let kinematic = Collider {
        carrier: None,
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
        carrier: Some(0),
        ..ball
    });
    let error = soft.step_blocking().unwrap_err().to_string();
    assert!(error.contains("collider.carrier"), "{error}");
    Ok(())
}

/// In full space a plate drags the skin until all of it slides: then the drag is μ times the push.
#[test]
fn sliding_skin_is_dragged_by_its_friction() -> Result<()> {
    let avatar = support::full_space_limb(&support::SMALL, 1, true);
    let potential = Reference::new(Arc::new(avatar.clone()), 1, 1000)?;
    let solver = Box::new(SparseCholesky::new(potential.pattern())?);
    let settings = Settings {
        solver: SolverMode::CONVERGED,
        ..Settings::default()
    };
    let mut simulation = Simulation::with_solver(&avatar, potential, settings, solver)?;
    let instance = &mut simulation.instances_mut()[0];
    let frame = instance.state.frames[0];
    instance.pins.push(Pin { bone: 0, frame });
    let plate = |x: f64| Frame {
        position: DVec3::new(x, 0.0, -0.037),
        ..Frame::IDENTITY
    };
    for direction in [1.0, -1.0] {
        simulation.instances_mut()[0].colliders = vec![Collider::new(Shape::HalfSpace, plate(0.0))];
        for _ in 0..5 {
            simulation.step_blocking()?;
        }
        simulation.instances_mut()[0].colliders[0].friction = 0.4;
        let mut force = DVec3::ZERO;
        for step in 1..=30 {
            let x = direction * 2e-3 * f64::from(step);
            simulation.instances_mut()[0].colliders[0].frame = plate(x);
            let report = simulation.step_blocking()?.instances.remove(0);
            assert_eq!(report.stop, Stop::Converged, "step {step}");
            force = report.contact_force;
        }
        assert!(force.z > 1.0, "{force}");
        let ratio = direction * force.x / force.z;
        assert!((ratio - 0.4).abs() < 1e-6, "{force}: ratio {ratio}");
    }
    Ok(())
}
