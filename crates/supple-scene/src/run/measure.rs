//! What is measured in a run.

use crate::run::report::{Breakdown, Median, Report, Spread, percentile};
use crate::scene::Scene;
use glam::{DMat3, DVec3};
use supple::internal::cpu::contact::may_touch;
use supple::internal::cpu::elasticity::displacement_gradient;
use supple::internal::cpu::{min_det_f, skin_displacement};
use supple::model::{Avatar, State};
use supple::sim::{Instance, StepReport};

/// Figures as they come in.
pub(super) struct Measures<'a> {
    avatar: &'a Avatar,
    settled: usize,
    full_press: usize,
    time_step: f64,
    scene: String,
    steps: Vec<StepReport>,
    /// Unposed displacement of the skin after the last step, m.
    displacement: Vec<DVec3>,
    settled_displacement: Vec<DVec3>,
    report: Report,
}

impl<'a> Measures<'a> {
    pub fn new(scene: &Scene, avatar: &'a Avatar) -> Self {
        Self {
            avatar,
            settled: scene.step_at(scene.measure.settled),
            full_press: scene.step_at(scene.measure.full_press).max(1),
            time_step: scene.settings.time_step,
            scene: scene.name.clone(),
            steps: Vec::with_capacity(scene.steps),
            displacement: vec![DVec3::ZERO; avatar.skin.len()],
            settled_displacement: vec![DVec3::ZERO; avatar.skin.len()],
            report: Report {
                min_det_f: (!avatar.layer.is_empty()).then_some(1.0),
                ..Report::default()
            },
        }
    }

    /// Unposed displacement of the skin after the last step, m.
    pub fn displacement(&self) -> &[DVec3] {
        &self.displacement
    }

    /// What the steps told.
    pub fn steps(&self) -> &[StepReport] {
        &self.steps
    }

    /// Takes in the state that the scene starts with.
    pub fn start(&mut self, state: &State) {
        self.displacement = skin_displacement(self.avatar, state);
        self.settled_displacement.clone_from(&self.displacement);
        if let Some(least) = &mut self.report.min_det_f {
            *least = min_det_f(self.avatar, state);
        }
    }

    /// Takes in step number `step`, counted from 1.
    pub fn add(&mut self, step: usize, report: &StepReport, instance: &Instance, skin: &[DVec3]) {
        const MM: f64 = 1e3;
        self.displacement = skin_displacement(self.avatar, &instance.state);
        let longest = longest(self.displacement.iter().copied()) * MM;
        let this = &report.instances[0];
        let r = &mut self.report;
        r.fine_handles = r.fine_handles.max(instance.state.awake.len());
        r.max_unposed_displacement_mm = r.max_unposed_displacement_mm.max(longest);
        r.max_joint_gap_mm = r.max_joint_gap_mm.max(this.max_joint_gap * MM);
        r.max_penetration_mm = r
            .max_penetration_mm
            .max(penetration(self.avatar, instance, skin) * MM);
        if let Some(least) = &mut r.min_det_f {
            let det = min_det_f(self.avatar, &instance.state);
            if det < *least || det.is_nan() {
                *least = det;
            }
        }
        let elastic = elastic_energy(self.avatar, &instance.state);
        r.energy.elastic_largest = r.energy.elastic_largest.max(elastic);
        r.energy.elastic_end = elastic;
        if this.contacts > 0 {
            let time = step as f64 * self.time_step;
            r.first_contact_s = r.first_contact_s.or(Some(time));
        }
        if step == self.settled {
            self.settled_displacement.clone_from(&self.displacement);
        }
        if step == self.full_press {
            let borne: DVec3 = this.loads.iter().map(|l| l.force).sum();
            r.full_press_displacement_mm = longest;
            r.contact_force_n = this.contact_force.length();
            r.load_n = (borne + this.weight).length();
            r.weight_n = this.weight.length();
            r.energy.elastic_full_press = elastic;
        }
        self.steps.push(report.clone());
    }

    /// The report of the whole run.
    pub fn report(self, avatar: &Avatar, adapter: String) -> Report {
        // Drivers compile in the first step.
        let timed = &self.steps[1.min(self.steps.len().saturating_sub(1))..];
        let median =
            |of: fn(&StepReport) -> f64| percentile(&timed.iter().map(of).collect::<Vec<_>>(), 0.5);
        let all: Vec<f64> = timed.iter().map(|s| s.timings.step).collect();
        let touching = timed.iter().filter(|s| s.instances[0].contacts > 0);
        let touching: Vec<f64> = touching.map(|s| s.timings.step).collect();
        let iterations: usize = self.steps.iter().map(|s| s.instances[0].iterations).sum();
        let changed = self.displacement.iter().zip(&self.settled_displacement);
        Report {
            scene: self.scene,
            adapter,
            steps: self.steps.len(),
            time_step: self.time_step,
            dofs: avatar.space().dofs() - 3 * (avatar.fine.slots - self.report.fine_handles),
            bones: avatar.skeleton.len(),
            handles: avatar.coarse_handles(),
            cubature_points: avatar.cubature.len(),
            vertices: avatar.skin.len(),
            tets: avatar.layer.mesh.tets.len(),
            iterations: iterations as f64 / self.steps.len().max(1) as f64,
            ms_per_step: Spread {
                median: percentile(&all, 0.5),
                p95: percentile(&all, 0.95),
            },
            ms_per_step_in_contact: Median {
                median: percentile(&touching, 0.5),
            },
            breakdown_ms: Breakdown {
                force: median(|s| s.timings.force),
                hessian: median(|s| s.timings.hessian),
                readback: median(|s| s.timings.readback),
                solve: median(|s| s.timings.solve),
                skin: median(|s| s.timings.skin),
                skeleton: median(|s| s.timings.skeleton),
                evaluation: median(|s| s.timings.evaluation),
            },
            residual_displacement_mm: 1e3 * longest(changed.map(|(now, then)| *now - *then)),
            ..self.report
        }
    }
}

fn longest(vectors: impl Iterator<Item = DVec3>) -> f64 {
    vectors.map(DVec3::length).fold(0.0, f64::max)
}

/// Deepest place of the skin, and of bodies, inside a collider that is not their own, m.
fn penetration(avatar: &Avatar, instance: &Instance, skin: &[DVec3]) -> f64 {
    let depths = instance.colliders.iter().flat_map(|collider| {
        let place = collider.world_frame(&instance.state.frames);
        let vertices = avatar.skin.skinning.iter().zip(skin);
        vertices
            .filter(|(bones, _)| may_touch(bones, collider))
            .map(move |(_, x)| -collider.signed_distance(&place, *x).distance)
    });
    depths.fold(0.0, f64::max)
}

/// Σ w Ψ(F) over the cubature points, J: the coarse ones also where cells are awake.
fn elastic_energy(avatar: &Avatar, state: &State) -> f64 {
    let (points, mut blocks) = (&avatar.cubature, Vec::new());
    let mut energy = |i: usize| {
        let mut change = displacement_gradient(points.basis.row(i), &state.handles);
        if !state.awake.is_empty() {
            let awake = |handle| state.awake.contains(&handle);
            avatar.fine.blocks(i, awake, &mut blocks);
            for block in &blocks {
                let phi = avatar.fine_displacement(state, block.handle);
                let [x, y, z] = block.gradient.map(|g| g * phi.unwrap_or_default());
                change += DMat3::from_cols(x, y, z);
            }
        }
        points.measure[i] * avatar.tissue_at(i).energy_density(DMat3::IDENTITY + change)
    };
    (0..points.len()).map(&mut energy).sum()
}
