//! The full-space solve: the accuracy reference and the speed baseline of everything reduced.

use crate::full_space::sparse_cholesky::SparseCholesky;
use std::sync::Arc;
use supple::Result;
use supple::model::Avatar;
use supple::potential::{CpuPotential, Potential};
use supple::sim::{Settings, Simulation};

/// The same bones, tissue and contacts as `avatar`'s with every free node of its layer as a handle and
/// every tet as a point: f64, sparse Newton with a supernodal Cholesky. Also gives the avatar in that
/// space, whose states the simulation's are.
///
/// # Errors
/// As [`super::full_space`], [`CpuPotential::new`], [`SparseCholesky::new`] and
/// [`Simulation::with_solver`].
pub fn full_space_simulation(
    avatar: &Avatar,
    instances: usize,
    settings: Settings,
) -> Result<(Arc<Avatar>, Simulation<CpuPotential>)> {
    let avatar = Arc::new(super::full_space(avatar)?);
    let potential = CpuPotential::new(avatar.clone(), instances)?;
    let solver = Box::new(SparseCholesky::new(potential.pattern())?);
    let simulation = Simulation::with_solver(&avatar, potential, settings, solver)?;
    Ok((avatar, simulation))
}
