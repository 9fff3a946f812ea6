//! Rigid bodies in an avatar's system: how they fly, fall, rest, and leave the avatar as it was.

use crate::support;

use std::f64::consts::{FRAC_PI_2, PI};
use std::sync::Arc;
use supple::Result;
use supple::collider::{Collider, Shape};
use supple::glam::{DMat3, DVec3};
use supple::internal::features::pose_feature;
use supple::internal::math::{Random, rotation_exp};
use supple::internal::{random_avatar, random_state};
use supple::model::{Avatar, BoneMass, Frame, Integrator, RigidBody};
use supple::potential::CpuPotential;
use supple::sim::{Pin, Settings, Simulation, SolverMode};
use supple_files::write_glb;
use supple_pictures::picture_strip;
use supple_samples::Limb;
use supple_scene::run_scene;

const BOX: Shape = Shape::Box {
    half_extents: [0.03, 0.02, 0.012],
};

/// A small limb whose bone is pinned at the origin, with `body` beside it.
fn beside_a_limb(body: RigidBody, settings: Settings) -> Simulation<CpuPotential> {
    let limb = Limb {
        stations: 4,
        layers: 1,
        sectors: 4,
        ..support::SMALL
    };
    let avatar = support::full_space_limb(&limb, 1, true);
    let avatar = Arc::new(avatar.with_bodies([body]).unwrap());
    let potential = CpuPotential::new(avatar.clone(), 1).unwrap();
    let mut simulation = Simulation::new(&avatar, potential, settings).unwrap();
    let instance = &mut simulation.instances_mut()[0];
    let frame = instance.state.frames[0];
    instance.pins.push(Pin { bone: 0, frame });
    simulation
}

fn converged(time_step: f64) -> Settings {
    Settings {
        time_step,
        integrator: Integrator::BackwardEuler,
        solver: SolverMode::Converged {
            tolerance: 1e-11,
            max_iterations: 100,
        },
        ..Settings::default()
    }
}

fn away() -> Frame {
    Frame {
        position: DVec3::new(0.1, 0.3, 0.2),
        ..Frame::IDENTITY
    }
}

/// Backward Euler falls by g h² n (n + 1)/2 in n steps, and keeps its rotation.
#[test]
fn a_body_falls_freely() -> Result<()> {
    for solver in [SolverMode::OneIteration, SolverMode::CONVERGED] {
        let settings = Settings {
            solver,
            integrator: Integrator::BackwardEuler,
            ..Settings::default()
        };
        let body = RigidBody::new("box", BOX, 800.0)?.at(away());
        let mut simulation = beside_a_limb(body, settings);
        for n in 1..=40 {
            simulation.step_blocking()?;
            let instance = &simulation.instances()[0];
            let h = settings.time_step;
            let fallen = 0.5 * h * h * f64::from(n * (n + 1)) * instance.gravity;
            let frame = instance.state.frames[1];
            let error = (frame.position - away().position - fallen).length();
            assert!(error < 1e-9, "{solver:?}, step {n}: {error:e}");
            let turned = (frame.rotation - DMat3::IDENTITY).to_cols_array();
            assert!(turned.iter().all(|r| r.abs() < 1e-9), "{solver:?}");
        }
    }
    Ok(())
}

/// Linear momentum, spin L = ∫ρ y × ẏ and kinetic energy of a centred frame that came from `before`.
fn momenta(mass: &BoneMass, before: &Frame, after: &Frame, h: f64) -> (DVec3, DVec3, f64) {
    let spin = (after.rotation - before.rotation) * h.recip();
    // L = Σ_k (R S)_k × Ṙ_k over columns.
    let moved = after.rotation * mass.second();
    let angular = (0..3).map(|k| moved.col(k).cross(spin.col(k))).sum();
    let kinetic = mass.kinetic_energy(before, after, h);
    (mass.momentum(before, after, h), angular, kinetic)
}

/// A box thrown with a spin about no principal axis: linear momentum stays to the solver's tolerance;
/// what backward Euler loses of spin and energy goes with h, to first order.
#[test]
fn a_thrown_box_keeps_its_momenta() -> Result<()> {
    let losses = [2e-3, 1e-3, 5e-4].map(|h| -> Result<(f64, f64)> {
        let body = RigidBody::new("box", BOX, 800.0)?.at(away());
        let mass = body.mass;
        let mut simulation = beside_a_limb(body, converged(h));
        let instance = &mut simulation.instances_mut()[0];
        instance.gravity = DVec3::ZERO;
        let (velocity, spin) = (DVec3::new(0.4, 1.0, 2.0), DVec3::new(6.0, -3.0, 5.0));
        instance.set_motion(1, away(), velocity, spin);
        let now = |simulation: &Simulation<CpuPotential>| {
            let instance = &simulation.instances()[0];
            let (before, after) = (instance.history.previous(), &instance.state);
            momenta(
                &mass,
                &before.frames[1],
                &after.frames[1],
                instance.history.last_step(),
            )
        };
        let start = now(&simulation);
        for _ in 0..(0.1 / h).round() as usize {
            simulation.step_blocking()?;
        }
        let end = now(&simulation);
        let drift = (end.0 - start.0).length() / start.0.length();
        assert!(drift < 1e-7, "h = {h}: linear momentum drifts by {drift:e}");
        let spin = (end.1 - start.1).length() / start.1.length();
        let energy = (end.2 - start.2) / start.2;
        println!("h = {h}: spin {spin:.2e}, energy {energy:.2e}");
        assert!(energy < 1e-9, "h = {h}: energy rises by {energy:e}");
        Ok((spin, -energy))
    });
    let losses: Vec<_> = losses.into_iter().collect::<Result<_>>()?;
    for pair in losses.windows(2) {
        let (spin, energy) = (pair[0].0 / pair[1].0, pair[0].1 / pair[1].1);
        assert!(
            (1.7..2.3).contains(&spin),
            "spin loses {spin} times as much"
        );
        assert!((1.7..2.3).contains(&energy), "energy {energy} times");
    }
    assert!(losses[2].0 < 0.05 && losses[2].1 < 0.05, "{losses:?}");
    Ok(())
}

/// Every kind of body comes to rest on the floor, which bears its weight: what the floor's push adds up
/// to in all steps, less the weight's, is exactly the momentum gained.
#[test]
fn bodies_rest_on_the_floor_with_their_weight() -> Result<()> {
    for shape in Shape::examples() {
        let Ok(body) = RigidBody::new("body", shape.clone(), 900.0) else {
            continue;
        };
        let mass = body.mass.mass();
        // Lying on its side, 0.1 mm above the floor.
        let lowest = (body.surface.positions.iter()).fold(0.0, |a: f64, p| a.min(p.y));
        let floor = -0.3;
        let place = Frame {
            position: DVec3::new(0.0, 0.0, floor - lowest + 1e-4),
            rotation: rotation_exp(DVec3::X * FRAC_PI_2),
        };
        let settings = converged(0.01);
        let mut simulation = beside_a_limb(body.at(place), settings);
        let instance = &mut simulation.instances_mut()[0];
        let ground = Frame {
            position: DVec3::Z * floor,
            ..Frame::IDENTITY
        };
        instance.colliders = vec![Collider::new(Shape::HalfSpace, ground)];
        let weight = -mass * instance.gravity;
        let (mut impulse, steps) = (DVec3::ZERO, 200);
        for _ in 0..steps {
            let force = simulation.step_blocking()?.instances[0].contact_force;
            impulse += (force - weight) * settings.time_step;
        }
        let instance = &simulation.instances()[0];
        let (before, after) = (
            instance.history.previous().frames[1],
            instance.state.frames[1],
        );
        let velocity = (after.position - before.position) / settings.time_step;
        let sunk = place.position.z - 1e-4 - after.position.z;
        let all = weight.length() * settings.time_step * f64::from(steps);
        let error = (impulse - mass * velocity).length() / all;
        println!(
            "{shape:?}: sunk {:.3} mm, {:.1e} m/s",
            1e3 * sunk,
            velocity.length()
        );
        assert!(error < 1e-6, "{shape:?}: the floor bears all but {error:e}");
        assert!(
            velocity.length() < 2e-3 && (0.0..1e-3).contains(&sunk),
            "{shape:?}"
        );
    }
    Ok(())
}

#[test]
fn a_ball_has_two_fifths_of_its_mass_times_the_square_of_its_radius() -> Result<()> {
    let radius = 0.03;
    let body = RigidBody::new("ball", Shape::Sphere { radius }, 1000.0)?.of_mass(0.2);
    let s = body.mass.second_moment;
    assert!((body.mass.mass() - 0.2).abs() < 1e-15);
    for (i, j) in [(0, 1), (1, 2), (2, 0)] {
        let inertia = s[i][i] + s[j][j];
        assert!((inertia - 0.4 * 0.2 * radius * radius).abs() < 1e-18);
    }
    let area: f64 = body.surface.vertex_areas().iter().sum();
    let sphere = 4.0 * PI * radius * radius;
    assert!((area / sphere - 1.0).abs() < 0.02, "{area} of {sphere}");
    Ok(())
}

#[test]
fn bodies_leave_the_avatar_as_it_is() -> Result<()> {
    let avatar = random_avatar(5, 4, 6, 50, 30);
    let place = Frame {
        rotation: Random::new(9).rotation(1.0),
        ..away()
    };
    let with: Avatar = avatar.clone().with_bodies([
        RigidBody::new("box", BOX, 800.0)?.at(place),
        RigidBody::new("ball", Shape::Sphere { radius: 0.02 }, 500.0)?,
    ])?;
    assert_eq!(with.bones(), avatar.skeleton.len());
    assert_eq!(with.character(), avatar.skeleton);
    assert_eq!(with.tissue_vertices(), avatar.tissue_vertices());
    assert_eq!(with.skin_triangles(), avatar.triangles);
    assert_eq!(with.body_vertices(1).end, with.skin.len());
    assert_eq!(with.rest_state().frames[with.body_frame(0)], place);
    // No pose feature counts a body, and every skin vertex stays where it was.
    let (alone, state) = (random_state(6, &avatar, 0.6, 0.02), with.rest_state());
    let mut both = alone.clone();
    both.frames.extend(&state.frames[with.bones()..]);
    assert_eq!(
        pose_feature(&with.skeleton.parents, &both.frames),
        pose_feature(&avatar.skeleton.parents, &alone.frames)
    );
    let posed = |avatar: &Avatar, state| -> Result<Vec<DVec3>> {
        let potential = CpuPotential::new(Arc::new(avatar.clone()), 1)?;
        let mut simulation = Simulation::new(avatar, potential, Settings::default())?;
        pollster::block_on(supple::potential::Potential::pose_skin(
            simulation.potential_mut(),
            &[state],
            &[],
            &[],
        ))?;
        let (mut skin, mut normals) = (Vec::new(), Vec::new());
        simulation.read_skin_blocking(0, &mut skin, &mut normals)?;
        Ok(skin)
    };
    let (before, after) = (posed(&avatar, alone)?, posed(&with, both)?);
    assert_eq!(before, after[..before.len()]);
    // The bodies' own surfaces stand in their places.
    for (i, body) in with.bodies.iter().enumerate() {
        for (p, x) in body
            .surface
            .positions
            .iter()
            .zip(&after[with.body_vertices(i)])
        {
            assert!((body.initial_frame.transform(*p) - *x).length() < 1e-12);
        }
    }
    Ok(())
}

#[test]
fn unusable_bodies_are_refused_by_name() {
    let fails = |body: Result<RigidBody>| body.unwrap_err().to_string();
    assert!(fails(RigidBody::new("b", Shape::HalfSpace, 1.0)).contains("half-space"));
    assert!(fails(RigidBody::new("b", BOX, f64::NAN)).contains("density"));
    assert!(fails(RigidBody::new("b", Shape::Sphere { radius: -1.0 }, 1.0)).contains("radius"));
    let avatar = random_avatar(5, 2, 2, 20, 10);
    let taken = avatar.skeleton.names[0].clone();
    let body = RigidBody::new(taken, BOX, 800.0).unwrap();
    assert!(avatar.clone().with_bodies([body]).is_err());
    let with = avatar.with_bodies([RigidBody::new("b", BOX, 800.0).unwrap()]);
    let refused = supple_bake::to_bytes(&with.unwrap(), None).unwrap_err();
    assert!(refused.to_string().contains("bodies"), "{refused}");
}

const SCENE: &str = r#"
name = "thrown"
steps = 30
[avatar]
sample = "limb_s"
[settings]
integrator = "backward_euler"
[[pins]]
bone = "bone"
[[bodies]]
name = "ball"
shape = { shape = "sphere", radius = 0.02 }
mass = 0.05
position = [0.1, 0.0, 0.3]
velocity = [0.5, 0.0, 1.0]
spin_degrees = [0.0, 90.0, 0.0]
[[colliders]]
name = "floor"
shape = { shape = "half_space" }
motion = { z = [[0.0, -0.4]] }
"#;

/// A scene's body starts as it says, flies, and goes into pictures and the GLB file.
#[test]
fn a_scene_throws_a_body() -> Result<()> {
    let path = std::path::Path::new("thrown.toml");
    let scene = supple_scene::parse_scene(SCENE, path)?;
    let bone = support::full_space_limb(&support::SMALL, 1, true);
    let mut avatar = Avatar {
        skeleton: supple::model::Skeleton {
            names: vec!["bone".into()],
            ..bone.skeleton.clone()
        },
        ..bone
    };
    scene.dress(&mut avatar)?;
    let avatar = Arc::new(avatar);
    let potential = CpuPotential::new(avatar.clone(), 1)?;
    let mut simulation = Simulation::new(&avatar, potential, scene.settings)?;
    let run = run_scene(&scene, &avatar, &mut simulation, &mut |_| {})?;
    let (n, h, g) = (f64::from(30), 0.01, scene.gravity());
    let body = &scene.bodies[0];
    let flown = body.position + body.velocity * n * h + 0.5 * h * h * n * (n + 1.0) * g;
    let frame = simulation.instances()[0].state.frames[1];
    assert!((frame.position - flown).length() < 1e-8, "{frame:?}");
    let turned = (frame.rotation * DVec3::Z)
        .angle_between(DVec3::Z)
        .to_degrees();
    assert!((turned - 27.0).abs() < 0.5, "{turned}");
    assert_eq!(run.snapshots[0].bodies.len(), 1);
    assert_eq!(run.report.max_penetration_mm, 0.0);
    let strip = picture_strip(&scene, &avatar, &run.snapshots);
    assert!(strip.width > 0);
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("avatar.glb");
    write_glb(&avatar, &run.recording, &file)?;
    let bytes = std::fs::read(&file).unwrap();
    let glb = gltf::Glb::from_slice(&bytes).unwrap();
    let text = String::from_utf8_lossy(&glb.json).into_owned();
    assert!(text.contains("ball surface"));

    for (from, to, message) in [
        ("mass = 0.05", "mass = -1.0", "bodies[0].mass"),
        ("radius = 0.02", "radius = 0.0", "bodies[0].shape.radius"),
        ("mass = 0.05", "friction = 99.0", "bodies[0].friction"),
        (
            "shape = \"sphere\", radius = 0.02",
            "shape = \"half_space\"",
            "half-space",
        ),
    ] {
        let error = supple_scene::parse_scene(&SCENE.replace(from, to), path).unwrap_err();
        assert!(error.to_string().contains(message), "{error}");
    }
    Ok(())
}
