//! The bone press in equilibrium, in any space: what reduced models are measured with.

use glam::DVec3;
use std::sync::Arc;
use supple::Result;
use supple::collider::{Collider, Shape};
use supple::internal::cpu::{Basis, min_det_f};
use supple::material::{Material, StableNeoHookean};
use supple::model::{Avatar, Frame, Integrator, State};
use supple::potential::{CpuPotential, Potential};
use supple::sim::{LinearSolver, Pin, Settings, Simulation, SolverMode};
use supple_bake::{Recipe, SparseCholesky, full_space as in_full_space};

/// Radius of the sphere, m.
const RADIUS: f64 = 0.03;

/// Where the sphere first touches the limb, m: the middle of what it slides over starts here.
const TOUCH: DVec3 = DVec3::new(0.1, 0.0, 0.04);

/// What a press ends in.
#[derive(Clone, Debug)]
pub struct Pressed {
    /// The equilibrium.
    pub state: State,
    /// Displacement of the skin from rest, m.
    pub displacement: Vec<DVec3>,
    /// What the sphere is pushed back with at each depth, N.
    pub forces: Vec<f64>,
}

impl Pressed {
    /// What the sphere is pushed back with at the last depth, N.
    pub fn force(&self) -> f64 {
        self.forces.last().copied().unwrap_or(0.0)
    }

    /// ‖u − u_truth‖ / ‖u_truth‖ over the skin.
    pub fn relative_error(&self, truth: &Self) -> f64 {
        relative_error(&self.displacement, &truth.displacement)
    }
}

/// ‖a − b‖ / ‖b‖.
pub fn relative_error(a: &[DVec3], b: &[DVec3]) -> f64 {
    let square = |v: &mut dyn Iterator<Item = DVec3>| v.map(DVec3::length_squared).sum::<f64>();
    let difference = square(&mut a.iter().zip(b).map(|(a, b)| *a - *b));
    (difference / square(&mut b.iter().copied())).sqrt()
}

/// A recipe of the benchmark's tissue: E = 30 kPa, ν = 0.4, not captured under gravity.
pub fn limb_recipe() -> Recipe {
    Recipe {
        material: Some(Material::StableNeoHookean(StableNeoHookean {
            youngs_modulus: 30e3,
            poissons_ratio: 0.4,
        })),
        captured_under_gravity: false,
        ..Recipe::default()
    }
}

/// The limb `avatar` pressed in its own space to each of `depths` in turn, m.
///
/// # Errors
/// As [`press_with`].
pub fn press(avatar: &Arc<Avatar>, depths: &[f64]) -> Result<Pressed> {
    let potential = CpuPotential::new(avatar.clone(), 1)?;
    press_with(avatar, potential, None, depths)
}

/// The same with every node of its layer solved for.
///
/// # Errors
/// As [`press_with`].
pub fn press_full_space(avatar: &Avatar, depths: &[f64]) -> Result<Pressed> {
    let avatar = Arc::new(in_full_space(avatar)?);
    let potential = CpuPotential::new(avatar.clone(), 1)?;
    let solver = Box::new(SparseCholesky::new(potential.pattern())?);
    press_with(&avatar, potential, Some(solver), depths)
}

/// The layer of `avatar` pressed by `shape` at each of `frames` in turn, every node free, from rest or from `start`; and the
/// smallest det F over all tets.
///
/// # Errors
/// As [`press_along`].
pub fn press_full_space_along(
    avatar: &Avatar,
    shape: Shape,
    frames: &[Frame],
    start: Option<&State>,
) -> Result<(Pressed, f64)> {
    let avatar = Arc::new(in_full_space(avatar)?);
    let potential = CpuPotential::new(avatar.clone(), 1)?;
    let solver = Box::new(SparseCholesky::new(potential.pattern())?);
    let pressed = press_from(&avatar, potential, Some(solver), shape, frames, start)?;
    let least = min_det_f(&avatar, &pressed.state);
    Ok((pressed, least))
}

/// The same of any basis, with a linear solver of one's own.
///
/// # Errors
/// Whatever a step says.
pub fn press_with<B: Basis>(
    avatar: &Avatar,
    potential: CpuPotential<B>,
    solver: Option<Box<dyn LinearSolver + Send + Sync>>,
    depths: &[f64],
) -> Result<Pressed> {
    let frames: Vec<Frame> = depths.iter().map(|d| sphere(*d).1).collect();
    press_along(avatar, potential, solver, sphere(0.0).0, &frames)
}

/// What presses the limb, at `depth`, m.
pub fn sphere(depth: f64) -> (Shape, Frame) {
    let frame = Frame {
        position: TOUCH + (RADIUS - depth) * DVec3::Z,
        ..Frame::IDENTITY
    };
    (Shape::Sphere { radius: RADIUS }, frame)
}

/// Any avatar whose bones stand still in the bind pose, pressed by `shape` at each of `frames` in turn. Steps are
/// so long that inertia is nothing.
///
/// # Errors
/// Whatever a step says.
pub fn press_along<B: Basis>(
    avatar: &Avatar,
    potential: CpuPotential<B>,
    solver: Option<Box<dyn LinearSolver + Send + Sync>>,
    shape: Shape,
    frames: &[Frame],
) -> Result<Pressed> {
    press_from(avatar, potential, solver, shape, frames, None)
}

/// [`press_along`] from `start` in place of rest.
fn press_from<B: Basis>(
    avatar: &Avatar,
    potential: CpuPotential<B>,
    solver: Option<Box<dyn LinearSolver + Send + Sync>>,
    shape: Shape,
    frames: &[Frame],
    start: Option<&State>,
) -> Result<Pressed> {
    let settings = Settings {
        time_step: 100.0,
        integrator: Integrator::BackwardEuler,
        solver: SolverMode::Converged {
            tolerance: 1e-6,
            max_iterations: 100,
        },
        ..Settings::default()
    };
    let mut simulation = match solver {
        Some(solver) => Simulation::with_solver(avatar, potential, settings, solver)?,
        None => Simulation::new(avatar, potential, settings)?,
    };
    let instance = &mut simulation.instances_mut()[0];
    if let Some(start) = start.filter(|start| start.space() == instance.state.space()) {
        instance.state.clone_from(start);
    }
    let bones = instance.state.frames.iter().enumerate();
    instance.pins = bones.map(|(bone, &frame)| Pin { bone, frame }).collect();
    let mut forces = Vec::new();
    for &frame in frames {
        let instance = &mut simulation.instances_mut()[0];
        instance.colliders = vec![Collider::new(shape.clone(), frame)];
        instance.history.rest(&instance.state);
        let report = simulation.step_blocking()?;
        forces.push(report.instances[0].contact_force.length());
    }
    let (mut skin, mut normals) = (Vec::new(), Vec::new());
    simulation.read_skin_blocking(0, &mut skin, &mut normals)?;
    let rest = &avatar.skin.position;
    Ok(Pressed {
        state: simulation.instances()[0].state.clone(),
        displacement: skin.iter().zip(rest).map(|(x, rest)| *x - *rest).collect(),
        forces,
    })
}
