//! What stays constant at a cubature point through a step: T and F at qⁿ, ŷ, and the lagged tangent.

use super::asset::Asset;
use super::cubature::Cubature;
use super::displacement::unposed_displacement;
use super::elasticity::displacement_gradient;
use super::inertial_target::{PastMotion, inertial_target};
use super::pose_blend::pose_offset;
use super::{Basis, Motion};
use crate::material::MaterialPoint;
use crate::math::{Mat9, Strided, par_split};
use crate::potential::StepStart;
use crate::potential::cpu::begin_step::POINT_GRAIN;
use glam::{DMat3, DVec3};

/// A point at the start of a step.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct PointStart {
    /// T at qⁿ, m.
    pub unposed: DVec3,
    /// ŷ = Σ_{k≥1} c_k (x(qⁿ⁻ᵏ) − x(qⁿ)), m: where inertia would move it, with this step's x̄ in all of them.
    pub predicted: DVec3,
    /// Fⁿ.
    pub deformation_gradient: DMat3,
}

/// All of them.
#[derive(Default)]
pub(super) struct PointStarts {
    pub points: Vec<PointStart>,
    /// Cⁿ of each point, Pa; empty without damping.
    pub damping_tangents: Vec<Mat9>,
    /// x̄ of each point, m.
    pub rest: Vec<DVec3>,
    past: PastMotion,
}

impl PointStarts {
    /// Memory for steps of `asset`.
    pub fn new<B: Basis>(asset: &Asset<B>) -> Self {
        let points = asset.most_points();
        let damped = asset.avatar.is_damped();
        Self {
            points: vec![PointStart::default(); points],
            damping_tangents: vec![[[0.0; 9]; 9]; if damped { points } else { 0 }],
            rest: vec![DVec3::ZERO; points],
            past: PastMotion::default(),
        }
    }

    /// The starts of a step from `start` with the pose `feature` of qⁿ, the `offsets` of the skin, and `motion`, which stands
    /// at qⁿ, each point being of its `tissue`.
    pub fn begin<'t, B: Basis, C: Basis>(
        &mut self,
        (asset, cubature): (&Asset<B>, &Cubature<C>),
        (feature, offsets): (&[f64], &[[f32; 3]]),
        start: &StepStart<'_>,
        motion: &Motion,
        tissue: impl Fn(usize) -> MaterialPoint<'t> + Sync,
    ) {
        self.past.set(&start.inertia, start.current);
        let past = &self.past;
        let (columns, position) = (&asset.cubature_columns, &asset.avatar.cubature.position);
        let extension = &asset.avatar.pose_extension;
        let coarse = position.len();
        let chunks = coarse.div_ceil(POINT_GRAIN);
        let parts = Strided::new(POINT_GRAIN, &mut self.rest[..coarse]);
        par_split(chunks, 1, parts, |chunk, rest| {
            let first = chunk * POINT_GRAIN;
            columns.blend(position, feature, first, rest);
            if !offsets.is_empty() {
                for (i, rest) in (first..).zip(&mut *rest) {
                    *rest += pose_offset(extension.row(i), offsets);
                }
            }
        });
        // A child is shifted as the coarse point of its cell.
        let fine = &asset.avatar.fine;
        for (k, &child) in cubature.children.iter().enumerate() {
            let cell = fine.cell_of_point[child as usize] as usize;
            let shift = self.rest[cell] - position[cell];
            self.rest[coarse + k] = fine.points.position[child as usize] + shift;
        }

        let count = cubature.len();
        let damped = self.damping_tangents.len().min(count);
        let parts = (
            Strided::new(POINT_GRAIN, &mut self.points[..count]),
            Strided::new(POINT_GRAIN, &mut self.damping_tangents[..damped]),
        );
        let rest = &self.rest;
        let chunks = count.div_ceil(POINT_GRAIN);
        par_split(chunks, 1, parts, |chunk, (points, tangents)| {
            let first = chunk * POINT_GRAIN;
            for (i, point) in (first..).zip(&mut *points) {
                *point = point_start((asset, cubature), past, motion, i, rest[i]);
            }
            for ((i, tangent), point) in (first..).zip(tangents).zip(&*points) {
                *tangent = tissue(i).projected_tangent(point.deformation_gradient);
            }
        });
    }
}

/// The start of point `i`, whose x̄ is `rest`.
fn point_start<B: Basis, C: Basis>(
    (asset, cubature): (&Asset<B>, &Cubature<C>),
    past: &PastMotion,
    motion: &Motion,
    i: usize,
    rest: DVec3,
) -> PointStart {
    let points = &cubature.points;
    let (skinning, basis) = (points.skinning.row(i), points.basis.row(i));
    let joints = &asset.avatar.skeleton.joints;
    let unposed = rest + unposed_displacement(basis, &motion.handles);
    PointStart {
        unposed,
        predicted: inertial_target(skinning, basis, joints, past, unposed),
        deformation_gradient: DMat3::IDENTITY + displacement_gradient(basis, &motion.handles),
    }
}
