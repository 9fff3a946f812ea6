//! Figures of a run.

use serde::{Deserialize, Serialize};

/// `report.json`. Every number is finite.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Report {
    /// The scene.
    pub scene: String,
    /// `gpu`, `cpu` or `cpu, full space`.
    pub backend: String,
    /// What evaluated the potential.
    pub adapter: String,
    /// Steps made.
    pub steps: usize,
    /// h, s.
    pub time_step: f64,
    /// Scalar degrees of freedom: 6 a bone, 3 a handle.
    pub dofs: usize,
    /// Bones.
    pub bones: usize,
    /// Handles, without fine ones.
    pub handles: usize,
    /// Fine handles, most of them that were awake at a time.
    #[serde(default)]
    pub fine_handles: usize,
    /// Cubature points.
    pub cubature_points: usize,
    /// Skin vertices.
    pub vertices: usize,
    /// Tets of the soft layer.
    pub tets: usize,
    /// Mean Newton iterations a step.
    pub iterations: f64,
    /// Wall-clock time of a step; the first is left out, since drivers compile in it.
    pub ms_per_step: Spread,
    /// The same of the steps in which skin touches something.
    pub ms_per_step_in_contact: Median,
    /// Medians of a step's parts, ms. On a GPU, force and Hessian are those of one evaluation, timed
    /// kernel by kernel after the run.
    pub breakdown_ms: Breakdown,
    /// Smallest det F over all tets and steps; 0 and below is an inverted tet. None of an avatar without its soft layer.
    pub min_det_f: Option<f64>,
    /// Deepest point of the drawn skin inside a collider over all steps, mm.
    pub max_penetration_mm: f64,
    /// Widest gap of a joint over all steps, mm.
    pub max_joint_gap_mm: f64,
    /// Longest unposed displacement of a skin vertex over all steps, mm.
    pub max_unposed_displacement_mm: f64,
    /// The same at full press, mm.
    pub full_press_displacement_mm: f64,
    /// End of the first step in which skin touches something, s; none if it never does.
    pub first_contact_s: Option<f64>,
    /// Contact force at full press, N.
    pub contact_force_n: f64,
    /// What targets and pins bear at full press beside the avatar's weight, N; it equals the contact
    /// force at rest.
    pub load_n: f64,
    /// Weight of bones and tissue, N.
    pub weight_n: f64,
    /// Longest difference of a skin vertex's unposed displacement between the last step and the settled
    /// state before contact, mm.
    pub residual_displacement_mm: f64,
    /// The tissue's energy.
    pub energy: EnergyReport,
    /// What was decided about the motion's file, and what of it the avatar cannot follow; a sentence each.
    #[serde(default)]
    pub motion_notes: Vec<String>,
}

impl Report {
    /// [`Report::min_det_f`] where a number is needed; NaN, which no bound holds, where there is none.
    pub fn det_f(&self) -> f64 {
        self.min_det_f.unwrap_or(f64::NAN)
    }
}

/// Median and 95th percentile, ms.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Spread {
    /// Half of the steps are faster.
    pub median: f64,
    /// 95 % are.
    pub p95: f64,
}

/// A median, ms; 0 where there is no step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Median {
    /// Half of the steps are faster.
    pub median: f64,
}

/// Where a step's time goes, ms.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Breakdown {
    /// Energies and gradients.
    pub force: f64,
    /// Hessians.
    pub hessian: f64,
    /// Waiting for the device.
    pub readback: f64,
    /// Linear systems.
    pub solve: f64,
    /// Posing the drawn skin.
    pub skin: f64,
    /// The bones' own terms.
    pub skeleton: f64,
    /// All evaluations of the tissue's potential, as the step sees them.
    pub evaluation: f64,
}

/// Energies at full press and at the end, J.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct EnergyReport {
    /// Σ w Ψ(F) at full press.
    pub elastic_full_press: f64,
    /// Σ w Ψ(F) at the end.
    pub elastic_end: f64,
    /// Largest Σ w Ψ(F) of all steps.
    pub elastic_largest: f64,
}

/// The value below which a share of `values` lies (nearest rank); 0 of none.
pub(super) fn percentile(values: &[f64], share: f64) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let rank = (share * sorted.len() as f64).ceil() as usize;
    sorted.get(rank.max(1) - 1).copied().unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_are_ranks() {
        let values: Vec<f64> = (1..=100).rev().map(f64::from).collect();
        assert_eq!(percentile(&values, 0.5), 50.0);
        assert_eq!(percentile(&values, 0.95), 95.0);
        assert_eq!(percentile(&[7.0], 0.95), 7.0);
        assert_eq!(percentile(&[], 0.5), 0.0);
    }
}
