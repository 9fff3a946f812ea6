//! E(state) − E(base) for any base: the trials of a line search.

use super::asset::Asset;
use super::cubature::Cubature;
use super::displacement::{displacement, unposed_displacement};
use super::elasticity::displacement_gradient;
use super::evaluate::Instance;
use super::friction::unforeseen;
use super::{Basis, Motion, energy};
use crate::math::par_each;
use crate::model::State;
use crate::potential::Energies;
use crate::potential::cpu::begin_step::{POINT_GRAIN, Step};

/// Forces of contacts in a trial, N; see [`crate::potential::Difference`].
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Foresight {
    pub unforeseen: f64,
    pub pressing: f64,
}

impl Instance {
    /// Each term's difference, J, and what a quadratic model at the base does not foresee.
    pub fn difference<B: Basis>(
        &mut self,
        asset: &Asset<B>,
        base: &State,
        state: &State,
    ) -> (Energies, Foresight) {
        let step = &self.step;
        let (to_base, to_state) = (&mut self.base_motion, &mut self.motion);
        to_base.set(&step.current, base, step.origin);
        to_state.set(base, state, step.origin);
        let (to_base, to_state) = (&*to_base, &*to_state);
        let out = &mut self.energies;
        let mut energies = match self.woken.is_none() {
            true => point_differences(asset, &asset.cubature, step, [to_base, to_state], out),
            false => {
                let cubature = &self.woken.cubature;
                point_differences(asset, cubature, step, [to_base, to_state], out)
            }
        };

        step.contact(asset, to_base, &mut self.base_touching);
        step.contact(asset, to_state, &mut self.touching);
        let (before, after) = (&self.base_touching, &self.touching);
        let pairs = before.candidates.iter().zip(&after.candidates);
        let colliders = step.colliders.len().max(1);
        let mut foresight = Foresight::default();
        for (k, (before, after)) in pairs.enumerate() {
            let stiffness = step.contact_stiffness(asset, k / colliders, k % colliders);
            energies.contact += energy::contact(stiffness, before.depth, after.depth);
            foresight.pressing += stiffness * after.depth;
            if (before.depth > 0.0) != (after.depth > 0.0) {
                foresight.unforeseen += stiffness * before.depth.max(after.depth);
            }
        }
        for (k, lagged) in step.lagged.iter().enumerate() {
            let to = step.slip_change(asset, k, &step.current.handles, to_base);
            let before = step.slip(k, step.start_slip(k) + to, to_base);
            let change = step.slip_change(asset, k, &base.handles, to_state);
            let after = step.slip(k, before.displacement + change, to_state);
            energies.friction += energy::friction(
                lagged.limit,
                step.smoothing,
                before.length(),
                after.length(),
            );
            foresight.unforeseen += lagged.limit * unforeseen(&before, &after, step.smoothing);
        }
        (energies, foresight)
    }
}

/// The sum over the points; `out` has room for each.
fn point_differences<B: Basis, C: Basis>(
    asset: &Asset<B>,
    cubature: &Cubature<C>,
    step: &Step,
    [to_base, to_state]: [&Motion; 2],
    out: &mut [Energies],
) -> Energies {
    let out = &mut out[..cubature.len()];
    par_each(out, 4 * POINT_GRAIN, |i, out| {
        *out = point_difference((asset, cubature), step, to_base, to_state, i);
    });
    energy::sum(out)
}

fn point_difference<B: Basis, C: Basis>(
    (asset, cubature): (&Asset<B>, &Cubature<C>),
    step: &Step,
    to_base: &Motion,
    to_state: &Motion,
    i: usize,
) -> Energies {
    let avatar = &*asset.avatar;
    let joints = &avatar.skeleton.joints;
    let points = &cubature.points;
    let (skinning, basis) = (points.skinning.row(i), points.basis.row(i));
    let (start, weight) = (&step.starts.points[i], cubature.measure[i]);
    let (mass, h, gravity) = (
        avatar.density * weight,
        step.inertial_step,
        step.tissue_gravity,
    );

    let t_base = unposed_displacement(basis, &to_base.handle_changes);
    let d_base = displacement(skinning, joints, &to_base.motions, start.unposed, t_base);
    let unposed = start.unposed + t_base;
    let t_change = unposed_displacement(basis, &to_state.handle_changes);
    let d_change = displacement(skinning, joints, &to_state.motions, unposed, t_change);

    let since_start = displacement_gradient(basis, &to_base.handle_changes);
    let change = displacement_gradient(basis, &to_state.handle_changes);
    let f_base = start.deformation_gradient + since_start;
    let tissue = step.tissue_at(asset, cubature, i);
    Energies {
        inertia: energy::inertia(mass, h, d_change, d_base - start.predicted),
        gravity: energy::gravity(mass, gravity, d_change),
        elastic: energy::elastic(tissue, weight, f_base, change),
        damping: step
            .damping(basis, tissue, i, since_start)
            .map_or(0.0, |d| {
                energy::damping(weight, d.rate, d.tangent, change, d.change)
            }),
        ..Energies::default()
    }
}
