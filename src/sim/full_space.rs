//! The full-space solve: the accuracy reference and the speed baseline of everything reduced.

use super::{Settings, Simulation, SparseCholesky};
use crate::Result;
use crate::bake;
use crate::model::Avatar;
use crate::potential::Potential;
use crate::reference::Reference;
use std::sync::Arc;

/// The same bones, tissue and contacts as `avatar`'s with every free node of its layer as a handle and
/// every tet as a point: f64, sparse Newton with a supernodal Cholesky. Also gives the avatar in that
/// space, whose states the simulation's are.
///
/// # Errors
/// As [`bake::full_space`], [`Reference::new`], [`SparseCholesky::new`] and
/// [`Simulation::with_solver`].
pub fn full_space(
    avatar: &Avatar,
    instances: usize,
    contact_capacity: usize,
    settings: Settings,
) -> Result<(Arc<Avatar>, Simulation<Reference>)> {
    let avatar = Arc::new(bake::full_space(avatar)?);
    let potential = Reference::new(avatar.clone(), instances, contact_capacity)?;
    let solver = Box::new(SparseCholesky::new(potential.pattern())?);
    let simulation = Simulation::with_solver(&avatar, potential, settings, solver)?;
    Ok((avatar, simulation))
}
