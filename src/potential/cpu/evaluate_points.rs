//! The cubature points of an evaluation, each on its own.

use super::asset::Asset;
use super::cubature::Cubature;
use super::displacement::{arms, blended_rotation, displacement, unposed_displacement};
use super::gradient::point_force;
use super::point_hessian::PointTerms;
use super::{Basis, Motion, elasticity, energy};
use crate::math::{Mat9, RowsMut, par_split};
use crate::potential::Energies;
use crate::potential::cpu::begin_step::{POINT_GRAIN, Step};
use glam::{DMat3, DVec3};

/// What an evaluation writes of each cubature point: terms, energies, arms, and w C.
pub(super) type PointParts<'a> = (
    &'a mut [PointTerms],
    &'a mut [Energies],
    RowsMut<'a, DVec3>,
    &'a mut [Mat9],
);

/// Which derivatives of the energy by a point's blocks are wanted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Derivatives {
    /// The gradient by frames: then stress and tangent are not looked at, and not made.
    OfFrames,
    /// The gradient and the Hessian.
    All,
}

/// Stages displacement, elasticity and energy at every cubature point; `out` has a part for each.
pub(super) fn evaluate_points<B: Basis, C: Basis>(
    asset: &Asset<B>,
    cubature: &Cubature<C>,
    step: &Step,
    motion: &Motion,
    wanted: Derivatives,
    out: PointParts<'_>,
) {
    par_split(cubature.len(), POINT_GRAIN, out, |i, parts| {
        let (terms, energies, arms, tangent) = parts;
        let tangent = (wanted == Derivatives::All).then_some(tangent);
        (*terms, *energies) = evaluate_point((asset, cubature), step, motion, i, arms, tangent);
    });
}

/// The same at point `i`, with qⁿ as the base; without a `tangent`, without a stress.
fn evaluate_point<B: Basis, C: Basis>(
    (asset, cubature): (&Asset<B>, &Cubature<C>),
    step: &Step,
    motion: &Motion,
    i: usize,
    point_arms: &mut [DVec3],
    tangent: Option<&mut Mat9>,
) -> (PointTerms, Energies) {
    let avatar = &*asset.avatar;
    let tissue = step.tissue_at(asset, cubature, i);
    let (joints, points) = (&avatar.skeleton.joints, &cubature.points);
    let (skinning, basis) = (points.skinning.row(i), points.basis.row(i));
    let (start, weight) = (&step.starts.points[i], cubature.measure[i]);
    let (mass, h, gravity) = (
        avatar.density * weight,
        step.inertial_step,
        step.tissue_gravity,
    );
    let changes = &motion.handle_changes;

    let change = unposed_displacement(basis, changes);
    let d = displacement(skinning, joints, &motion.motions, start.unposed, change);
    arms(
        skinning,
        joints,
        &motion.frames,
        start.unposed + change,
        point_arms,
    );
    let blended = blended_rotation(skinning, &motion.frames);
    let force = point_force(mass, h, d, start.predicted, gravity);

    let f_start = start.deformation_gradient;
    let f_change = elasticity::displacement_gradient(basis, changes);
    let damping = step.damping(basis, tissue, i, f_change);
    let mut stress = DMat3::ZERO;
    if let Some(tangent) = tangent {
        stress = elasticity::stress(tissue, f_start + f_change, damping);
        *tangent = elasticity::tangent(tissue, f_start + f_change, damping, weight);
    }

    let inertia = mass / (h * h);
    let terms = PointTerms {
        inertia,
        force,
        pulled_force: blended.transpose() * force,
        stress: stress * weight,
        blended: blended * inertia,
        metric: blended.transpose() * blended * inertia,
    };
    let energies = Energies {
        inertia: energy::inertia(mass, h, d, -start.predicted),
        gravity: energy::gravity(mass, gravity, d),
        elastic: energy::elastic(tissue, weight, f_start, f_change),
        damping: damping.map_or(0.0, |d| {
            energy::damping(weight, d.rate, d.tangent, f_change, d.change - f_change)
        }),
        ..Energies::default()
    };
    (terms, energies)
}
