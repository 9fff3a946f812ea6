//! A rigid block on an incline: it sticks below the angle of friction and slides above, on a mesh too.

use super::{CONVERGED, GRAVITY, HALF, blocks, simulation};
use supple::Result;
use supple::collider::{Collider, MeshShape, Shape};
use supple::glam::{DMat3, DVec3};
use supple::model::{Frame, Surface};
use supple::sim::SolverMode;

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
    instance.set_state(state);
    let mut speeds = Vec::new();
    for _ in 0..60 {
        simulation.step_blocking()?;
        let instance = &simulation.instances()[0];
        let moved =
            instance.state.frames[0].position - instance.history.previous().frames[0].position;
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
/// has_friction is the push and not k a δ.
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
