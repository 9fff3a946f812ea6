//! The Hessian as a dense matrix, made without the gathers: for tests and diagnostics.

use super::asset::Asset;
use super::compact::compact;
use super::contact::{ContactRow, body_levers};
use super::cubature::Cubature;
use super::displacement::{arms, blended_rotation, displacement, unposed_displacement};
use super::elasticity::displacement_gradient;
use super::gradient::point_force;
use super::{Basis, CpuPotential, Mixed, Motion, friction};
use crate::Result;
use crate::math::{Mat9, skew};
use crate::model::{Frame, SkinWeight, State};
use crate::potential::HessianForm;
use crate::potential::cpu::begin_step::{Step, Touching};
use glam::{DMat3, DVec3};

impl<B: Basis> CpuPotential<B> {
    /// The Hessian at `state` in the step that `instance` has begun, `dofs × dofs`.
    ///
    /// # Errors
    /// Where the instance has begun no step or the state is not usable.
    pub fn dense_hessian(
        &self,
        instance: usize,
        state: &State,
        form: HessianForm,
    ) -> Result<Vec<Vec<f64>>> {
        self.checks.instance(instance)?;
        self.checks.begun(instance, self.has_begun(instance))?;
        self.checks.state(state)?;
        let (asset, step) = (&self.asset, &self.instances[instance].step);
        let avatar = &*asset.avatar;
        let mut motion = Motion::default();
        motion.set(&step.current, state, step.origin);
        let mut dense = Dense::new(asset.space.dofs());

        let woken = &self.instances[instance].woken;
        match woken.is_none() {
            true => step.add_points(asset, &asset.cubature, &motion, form, &mut dense),
            false => step.add_points(asset, &woken.cubature, &motion, form, &mut dense),
        }

        let (mut touching, mut rows) = (Touching::default(), Vec::new());
        step.contact(asset, &motion, &mut touching);
        let stiffness = |v, k| step.contact_stiffness(asset, v, k);
        let colliders = &step.colliders;
        compact(&touching.candidates, stiffness, colliders, &mut rows);
        for k in 0..step.lagged.len() {
            let change = step.slip_change(asset, k, &step.current.handles, &motion);
            let slip = step.slip(k, step.start_slip(k) + change, &motion);
            rows.extend(friction::rows(&step.lagged[k], &slip, step.smoothing));
        }
        // Blocks and handles of each row's vertex, those that are awake behind the others.
        let first = asset.space.handle_block(0) as u32;
        let of_vertex = |v: usize| -> (Vec<u32>, Vec<Mixed>) {
            let fine = step.fine_skin.row(v);
            let blocks = asset.skin_incidence.blocks(v).iter().copied();
            let basis = asset.skin.basis.row(v).iter().map(Basis::mixed);
            (
                blocks
                    .chain(fine.iter().map(|n| first + n.handle))
                    .collect(),
                basis.chain(fine.iter().map(Basis::mixed)).collect(),
            )
        };
        let vertices: Vec<_> = (0..asset.skin.len()).map(of_vertex).collect();
        let side = |row: &ContactRow| {
            let v = row.vertex as usize;
            let (blocks, basis) = &vertices[v];
            Body {
                blocks,
                skinning: asset.skin.skinning.row(v),
                basis,
                joints: &avatar.skeleton.joints,
                frames: &motion.frames,
                unposed: step.skin_unposed(asset, v, &motion.handles),
                body: row.body,
            }
        };
        for row in &rows {
            let (body, e) = (side(row), row.direction);
            let k = DMat3::from_cols(e * e.x, e * e.y, e * e.z) * row.stiffness;
            body.add_gauss_newton(k, &mut dense);
            if form == HessianForm::Exact {
                body.add_geometric(row.force * e, &mut dense);
            }
        }
        if form == HessianForm::Exact {
            // −k a δ ∇²d of every candidate.
            for (index, candidate) in touching.candidates.iter().enumerate() {
                let (v, k) = (index / colliders.len(), index % colliders.len());
                if candidate.depth > 0.0 {
                    let collider = &colliders[k];
                    let row = ContactRow::normal(candidate, stiffness(v, k), v as u32, collider);
                    let body = side(&row);
                    let curvature =
                        collider.curvature(&touching.collider_frames[k], body.position());
                    body.add_gauss_newton(curvature * row.force, &mut dense);
                }
            }
        }
        Ok(dense.rows)
    }
}

impl Step {
    /// Adds what cubature points add.
    fn add_points<B: Basis, C: Basis>(
        &self,
        asset: &Asset<B>,
        cubature: &Cubature<C>,
        motion: &Motion,
        form: HessianForm,
        dense: &mut Dense,
    ) {
        let avatar = &*asset.avatar;
        for (i, start) in self.starts.points[..cubature.len()].iter().enumerate() {
            let weight = cubature.measure[i];
            let points = &cubature.points;
            let (skinning, basis) = (points.skinning.row(i), points.basis.row(i));
            let change = unposed_displacement(basis, &motion.handle_changes);
            let joints = &avatar.skeleton.joints;
            let d = displacement(skinning, joints, &motion.motions, start.unposed, change);
            let (mass, h) = (avatar.density * weight, self.inertial_step);
            let body = Body {
                blocks: cubature.incidence.blocks(i),
                skinning,
                basis,
                joints,
                frames: &motion.frames,
                unposed: start.unposed + change,
                body: None,
            };
            let inertia = DMat3::from_diagonal(DVec3::splat(mass / (h * h)));
            body.add_gauss_newton(inertia, dense);
            if form == HessianForm::Exact {
                let force = point_force(mass, h, d, start.predicted, self.tissue_gravity);
                body.add_geometric(force, dense);
            }

            let f_change = displacement_gradient(basis, &motion.handle_changes);
            let f = start.deformation_gradient + f_change;
            let tissue = self.tissue_at(asset, cubature, i);
            let mut tangent = match form {
                HessianForm::Exact => tissue.tangent(f),
                HessianForm::Solver => tissue.projected_tangent(f),
            };
            if let Some(damping) = self.damping(basis, tissue, i, f_change) {
                for (row, lagged) in tangent.iter_mut().zip(damping.tangent) {
                    for (entry, lagged) in row.iter_mut().zip(lagged) {
                        *entry += damping.rate * lagged;
                    }
                }
            }
            body.add_elastic(weight, &tangent, dense);
        }
    }
}

struct Dense {
    rows: Vec<Vec<f64>>,
}

impl Dense {
    fn new(dofs: usize) -> Self {
        Self {
            rows: vec![vec![0.0; dofs]; dofs],
        }
    }

    fn add(&mut self, row: u32, column: u32, block: DMat3) {
        for i in 0..3 {
            for k in 0..3 {
                self.rows[3 * row as usize + i][3 * column as usize + k] += block.col(k)[i];
            }
        }
    }
}

/// A material point of the system, or its place z seen from a frame of the system.
struct Body<'a, B> {
    blocks: &'a [u32],
    skinning: &'a [SkinWeight],
    basis: &'a [B],
    joints: &'a [DVec3],
    frames: &'a [Frame],
    unposed: DVec3,
    body: Option<u32>,
}

impl<B: Basis> Body<'_, B> {
    fn position(&self) -> DVec3 {
        super::displacement::position(self.skinning, self.joints, self.frames, self.unposed)
    }

    fn arms(&self) -> Vec<DVec3> {
        let mut out = vec![DVec3::ZERO; self.skinning.len()];
        arms(
            self.skinning,
            self.joints,
            self.frames,
            self.unposed,
            &mut out,
        );
        out
    }

    /// Its blocks in local order, then the body's c and ω.
    fn blocks(&self) -> Vec<u32> {
        let body = self.body.into_iter().flat_map(|c| [2 * c, 2 * c + 1]);
        self.blocks.iter().copied().chain(body).collect()
    }

    /// ∂z/∂q of every block, in local order.
    fn jacobian(&self) -> Vec<DMat3> {
        let blended = blended_rotation(self.skinning, self.frames);
        let weights = self.skinning.iter().zip(self.arms());
        let frames =
            weights.flat_map(|(w, arm)| [DMat3::from_diagonal(DVec3::splat(w.weight)), -skew(arm)]);
        let handles = self.basis.iter().map(|n| blended * n.value());
        let body = self.body.into_iter().flat_map(|c| {
            // Rows of the Jacobian are the levers of the axes.
            let rows =
                DVec3::AXES.map(|e| body_levers(&self.frames[c as usize], self.position(), e));
            [0, 1].map(|b| DMat3::from_cols(rows[0][b], rows[1][b], rows[2][b]).transpose())
        });
        frames.chain(handles).chain(body).collect()
    }

    /// Jᵀ K J.
    fn add_gauss_newton(&self, k: DMat3, dense: &mut Dense) {
        let (blocks, jacobian) = (self.blocks(), self.jacobian());
        for (&row, a) in blocks.iter().zip(&jacobian) {
            for (&column, b) in blocks.iter().zip(&jacobian) {
                dense.add(row, column, a.transpose() * k * *b);
            }
        }
    }

    /// fᵀ ∂²z/∂q²: (ω_j, ω_j) is ½ (f a_jᵀ + a_j fᵀ) − (f·a_j) I, (ω_j, φ_h) is −w_j \[f\]× R_j N_h. Seen
    /// from a body z = exp(−\[δω\]) (x − c): (ω, ω) is as a bone's with r = x − c, (ω, b) is \[f\]× ∂z/∂q_b.
    fn add_geometric(&self, f: DVec3, dense: &mut Dense) {
        for (k, (w, a)) in self.skinning.iter().zip(self.arms()).enumerate() {
            let omega = self.blocks[2 * k + 1];
            let outer = DMat3::from_cols(f * a.x, f * a.y, f * a.z);
            let dot = DMat3::from_diagonal(DVec3::splat(f.dot(a)));
            dense.add(omega, omega, (outer + outer.transpose()) * 0.5 - dot);
            let rotation = self.frames[w.bone as usize].rotation;
            let handles = &self.blocks[2 * self.skinning.len()..];
            for (&phi, n) in handles.iter().zip(self.basis) {
                let mixed = -(skew(f) * rotation * n.value()) * w.weight;
                dense.add(omega, phi, mixed);
                dense.add(phi, omega, mixed.transpose());
            }
        }
        if let Some(body) = self.body {
            let r = self.position() - self.frames[body as usize].position;
            let omega = 2 * body + 1;
            let outer = DMat3::from_cols(f * r.x, f * r.y, f * r.z);
            let dot = DMat3::from_diagonal(DVec3::splat(f.dot(r)));
            dense.add(omega, omega, (outer + outer.transpose()) * 0.5 - dot);
            for (block, j) in self.blocks().into_iter().zip(self.jacobian()) {
                if block != omega {
                    let mixed = skew(f) * j;
                    dense.add(omega, block, mixed);
                    dense.add(block, omega, mixed.transpose());
                }
            }
        }
    }

    /// w (∂N/∂X)ᵀ : C : ∂N/∂X, entry by entry.
    fn add_elastic(&self, weight: f64, c: &Mat9, dense: &mut Dense) {
        let handles = &self.blocks[2 * self.skinning.len()..];
        // ∂vec(F)/∂φ of each handle, 9×3.
        let columns: Vec<[[f64; 9]; 3]> = self
            .basis
            .iter()
            .map(|n| DVec3::AXES.map(|e| n.deformation(e).to_cols_array()))
            .collect();
        for (&row, a) in handles.iter().zip(&columns) {
            for (&column, b) in handles.iter().zip(&columns) {
                let entry = |i: usize, k: usize| -> f64 {
                    let products = (0..81).map(|m| a[i][m / 9] * c[m / 9][m % 9] * b[k][m % 9]);
                    weight * products.sum::<f64>()
                };
                let column_of = |k| DVec3::from_array(std::array::from_fn(|i| entry(i, k)));
                let block = DMat3::from_cols(column_of(0), column_of(1), column_of(2));
                dense.add(row, column, block);
            }
        }
    }
}
