//! Mechanical energy, measured between steps.

use super::instance::Instance;
use super::simulation::Simulation;
use super::step_start::{skeleton_start, tissue_start};
use crate::Result;
use crate::model::State;
use crate::potential::{Evaluation, Potential, StepStart};
use crate::skeleton::{SkeletonPotential, SkeletonStart};
use serde::Serialize;

/// Energy of one instance: what it has in motion, and how much its potential energies changed in the
/// last step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct EnergyBalance {
    /// Σ ½ m |ẋⁿ|² of tissue and bones, with ẋⁿ as the last step differentiates, J.
    pub kinetic: f64,
    /// Elastic energy of the tissue, J.
    pub elastic: f64,
    /// Gravity on tissue and bones, J.
    pub gravity: f64,
    /// Penalty energy of contacts, J.
    pub contact: f64,
    /// Springs of joints, bending and targets, less the weight that they carry beforehand, J. Dampers count with their dissipation.
    pub skeleton: f64,
}

impl EnergyBalance {
    /// Change of all potential energies, J.
    pub fn potential_change(&self) -> f64 {
        self.elastic + self.gravity + self.contact + self.skeleton
    }
}

impl<P: Potential> Simulation<P> {
    /// The energy of every instance after its last step, with colliders and targets where they are
    /// now. Costs an evaluation with its Hessian: a diagnosis, not a part of a step.
    ///
    /// # Errors
    /// A lost device.
    pub async fn energy_balance(&mut self) -> Result<Vec<EnergyBalance>> {
        let physics = &self.physics;
        // A step from qⁿ⁻¹ whose inertia draws to x̃ has the inertia energy m/(2h̃²) |x − x̃|², which at x = xⁿ is kinetic.
        let resting: Vec<_> = self
            .instances
            .iter()
            .map(|instance| {
                let mut resting = instance.clone();
                resting.state.clone_from(instance.history.previous());
                resting
            })
            .collect();
        let starts: Vec<_> = resting
            .iter()
            .map(|instance| StepStart {
                inertia: instance.history.velocity(),
                ..tissue_start(
                    &physics.settings,
                    physics.captured_under_gravity,
                    instance,
                    &[],
                )
            })
            .collect();
        let states: Vec<_> = self.instances.iter().map(|i| i.state.clone()).collect();
        let all = vec![true; states.len()];
        let mut evaluations = vec![Evaluation::default(); states.len()];
        self.potential.begin_step(&starts, &all).await?;
        self.potential
            .evaluate(&states, &all, &mut evaluations)
            .await?;
        let balance = |((instance, state), evaluation): ((&Instance, &State), &Evaluation)| {
            let start = SkeletonStart {
                inertia: instance.history.velocity(),
                ..skeleton_start(&physics.settings, instance)
            };
            let bones = SkeletonPotential::new(&physics.skeleton, &start)
                .difference(&instance.state.frames, &state.frames);
            let tissue = &evaluation.energies;
            EnergyBalance {
                kinetic: tissue.inertia + bones.inertia,
                elastic: tissue.elastic,
                gravity: tissue.gravity + bones.gravity,
                contact: tissue.contact,
                skeleton: bones.joint
                    + bones.bending
                    + bones.limit
                    + bones.tracking
                    + bones.preload,
            }
        };
        let pairs = resting.iter().zip(&states).zip(&evaluations);
        Ok(pairs.map(balance).collect())
    }
}
