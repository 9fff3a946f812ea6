//! What an instance's step starts from: constant through its Newton iterations.

use super::asset::Asset;
use super::compact::lag;
use super::contact::{Candidate, contact, contact_point, may_touch};
use super::cubature::Cubature;
use super::displacement::{FrameMotion, displacement, unposed_displacement};
use super::elasticity::{Damping, displacement_gradient};
use super::fine_skin::FineSkin;
use super::friction::{Lagged, Slip, carried};
use super::point_start::PointStarts;
use super::pose_blend::add_offsets;
use super::{Basis, Motion, energy};
use crate::collider::Collider;
use crate::material::MaterialPoint;
use crate::math::{Strided, par_join, par_split};
use crate::model::{Frame, State, pose_feature_into};
use crate::potential::cpu::pose_skin::PosedSkin;
use crate::potential::{StepStart, TissueFactors};
use glam::{DMat3, DVec3};

/// Points and vertices of one task: some ten microseconds of work; a multiple of [`super::pose_columns::GROUP`].
pub(super) const POINT_GRAIN: usize = 16;
pub(super) const VERTEX_GRAIN: usize = 128;

/// The colliders in one state, and every skin vertex against each of them.
#[derive(Default)]
pub(super) struct Touching {
    /// Where the colliders stand, relative to the instance's origin.
    pub collider_frames: Vec<Frame>,
    /// Vertex-major.
    pub candidates: Vec<Candidate>,
}

/// The start of one instance's step.
pub(super) struct Step {
    /// h̃, s; 0 before the first step.
    pub inertial_step: f64,
    /// The root's joint at tⁿ: frames and colliders are relative to it.
    pub origin: DVec3,
    pub tissue_gravity: DVec3,
    /// What the instance's tissue has differently.
    factors: TissueFactors,
    /// What β is multiplied by, 1/s: the factor on it over h̃.
    pub damping_rate: f64,
    pub colliders: Vec<Collider>,
    /// How each collider whose motion is given moves in this step.
    collider_motions: Vec<FrameMotion>,
    /// The contacts of qⁿ that rub.
    pub lagged: Vec<Lagged>,
    /// ε_v h, m.
    pub smoothing: f64,
    /// Whether the geometric terms of contact are wanted.
    pub geometric: bool,
    /// Which frames are prescribed.
    pub prescribed: Vec<bool>,
    /// qⁿ.
    pub current: State,
    /// φ̃ − φⁿ, m; empty where it is zero.
    pub handle_drift: Vec<DVec3>,
    pub starts: PointStarts,
    /// x̄ of the skin, m.
    pub skin_rest: Vec<DVec3>,
    /// What fine handles that are awake do to it.
    pub fine_skin: FineSkin,
    /// Σ ½ k a δ² at qⁿ, J.
    pub contact_energy: f64,
}

impl Step {
    /// Memory for steps of `asset`.
    pub fn new<B: Basis>(asset: &Asset<B>) -> Self {
        Self {
            inertial_step: 0.0,
            origin: DVec3::ZERO,
            tissue_gravity: DVec3::ZERO,
            factors: TissueFactors::default(),
            damping_rate: 0.0,
            colliders: Vec::new(),
            collider_motions: Vec::new(),
            lagged: Vec::new(),
            smoothing: 0.0,
            geometric: false,
            prescribed: vec![false; asset.space.frames],
            current: asset.avatar.rest_state(),
            handle_drift: Vec::with_capacity(asset.space.handles),
            starts: PointStarts::new(asset),
            skin_rest: vec![DVec3::ZERO; asset.skin.len()],
            fine_skin: FineSkin::default(),
            contact_energy: 0.0,
        }
    }

    /// x̄ from θⁿ, ŷ from the states before, the lagged tangent, and the contact energy at qⁿ. The rest are
    /// buffers of the evaluation.
    pub fn begin<B: Basis, C: Basis>(
        &mut self,
        (asset, cubature): (&Asset<B>, &Cubature<C>),
        start: &StepStart<'_>,
        motion: &mut Motion,
        feature: &mut Vec<f64>,
        touching: &mut Touching,
        posed_skin: &PosedSkin,
    ) {
        let avatar = &*asset.avatar;
        self.inertial_step = start.inertia.step;
        self.origin = start.current.frames[0].position;
        let factors = start.factors;
        self.tissue_gravity = factors.gravity * start.tissue_gravity;
        self.factors = factors;
        self.damping_rate = factors.damping / start.inertia.step;
        self.colliders.clear();
        let relative = start.colliders.iter().map(|c| c.relative_to(self.origin));
        self.colliders.extend(relative);
        for collider in &mut self.colliders {
            collider.friction *= factors.friction;
        }
        self.collider_motions.clear();
        let moved = |c: &Collider| FrameMotion::new(&c.previous, &c.frame);
        self.collider_motions
            .extend(self.colliders.iter().map(moved));
        self.smoothing = start.slip_speed * start.time_step;
        self.geometric = start.geometric_contact;
        for (frame, prescribed) in self.prescribed.iter_mut().enumerate() {
            *prescribed = start.is_prescribed(frame);
        }
        self.current.clone_from(start.current);
        self.handle_drift.clear();
        if start.inertia.drift != 0.0 && self.damping_rate > 0.0 {
            let handles = start.current.handles.iter().enumerate();
            let drift = handles.map(|(h, phi)| start.inertia.handle_drift(h, *phi));
            self.handle_drift.extend(drift);
        }

        pose_feature_into(&avatar.skeleton.parents, &start.current.frames, feature);
        motion.set(start.current, start.current, self.origin);
        let (feature, motion) = (&*feature, &*motion);
        let pose = (&feature[..], start.pose_offsets);
        let mut starts = std::mem::take(&mut self.starts);
        let tissue = |i: usize| cubature.tissue_at(asset, i, &factors);
        par_join(
            || starts.begin((asset, cubature), pose, start, motion, tissue),
            || self.begin_skin(asset, pose, motion, touching, posed_skin),
        );
        self.starts = starts;
    }

    /// x̄ of the skin and its contacts at qⁿ.
    fn begin_skin<B: Basis>(
        &mut self,
        asset: &Asset<B>,
        (feature, offsets): (&[f64], &[[f32; 3]]),
        motion: &Motion,
        touching: &mut Touching,
        posed_skin: &PosedSkin,
    ) {
        match posed_skin.blended(feature) {
            Some(rest) => self.skin_rest.copy_from_slice(rest),
            None => {
                let (columns, position) = (&asset.skin_columns, &asset.avatar.skin.position);
                let chunks = position.len().div_ceil(VERTEX_GRAIN);
                let parts = Strided::new(VERTEX_GRAIN, &mut self.skin_rest);
                par_split(chunks, 1, parts, |chunk, out| {
                    columns.blend(position, feature, chunk * VERTEX_GRAIN, out);
                });
            }
        }
        add_offsets(&mut self.skin_rest, offsets);
        self.lag_contacts(asset, motion, touching);
        self.contact(asset, motion, touching);
        self.contact_energy = self.sum_contact_energy(asset, &touching.candidates);
    }

    /// Lists the contacts at qⁿ with what was there at tⁿ and has_friction.
    fn lag_contacts<B: Basis>(
        &mut self,
        asset: &Asset<B>,
        motion: &Motion,
        touching: &mut Touching,
    ) {
        self.lagged.clear();
        if self.colliders.iter().all(|c| c.friction == 0.0) {
            return;
        }
        let frames = &motion.frames;
        touching.collider_frames.clear();
        let places = self
            .colliders
            .iter()
            .map(|c| c.previous_world_frame(frames));
        touching.collider_frames.extend(places);
        self.candidates(asset, motion, touching);
        // From here on a place is that of the frame that a collider is fixed to: its own or its body's.
        for (place, collider) in touching.collider_frames.iter_mut().zip(&self.colliders) {
            if let Some(body) = collider.body {
                *place = frames[body as usize];
            }
        }
        let mut lagged = std::mem::take(&mut self.lagged);
        let joints = &asset.avatar.skeleton.joints;
        let point = |v: usize| {
            let unposed = self.skin_unposed(asset, v, &motion.handles);
            contact_point(asset.skin.skinning.row(v), joints, frames, unposed)
        };
        let stiffness = |v, k| self.contact_stiffness(asset, v, k);
        let (candidates, places) = (&touching.candidates, &touching.collider_frames);
        lag(
            candidates,
            stiffness,
            &self.colliders,
            places,
            point,
            &mut lagged,
        );
        self.lagged = lagged;
    }

    /// The tissue at cubature point `i`, with this step's factors.
    pub fn tissue_at<'a, B: Basis, C: Basis>(
        &self,
        asset: &'a Asset<B>,
        cubature: &Cubature<C>,
        i: usize,
    ) -> MaterialPoint<'a> {
        cubature.tissue_at(asset, i, &self.factors)
    }

    /// The damping of point `i`, of its `tissue`, whose F has moved by `change` since Fⁿ.
    pub fn damping<B: Basis>(
        &self,
        basis: &[B],
        tissue: MaterialPoint<'_>,
        i: usize,
        change: DMat3,
    ) -> Option<Damping<'_>> {
        let tangent = self.starts.damping_tangents.get(i)?;
        let drift = match &self.handle_drift[..] {
            [] => DMat3::ZERO,
            drift => displacement_gradient(basis, drift),
        };
        Some(Damping {
            rate: self.damping_rate * tissue.local.damping_time,
            tangent,
            change: change - drift,
        })
    }

    /// Every skin vertex of the state in `motion` against every collider at the end of the step.
    pub fn contact<B: Basis>(&self, asset: &Asset<B>, motion: &Motion, touching: &mut Touching) {
        touching.collider_frames.clear();
        let places = self.colliders.iter().map(|c| c.world_frame(&motion.frames));
        touching.collider_frames.extend(places);
        self.candidates(asset, motion, touching);
    }

    /// Every skin vertex against every collider at its place.
    fn candidates<B: Basis>(&self, asset: &Asset<B>, motion: &Motion, touching: &mut Touching) {
        let stride = self.colliders.len();
        let Touching {
            collider_frames,
            candidates,
        } = touching;
        candidates.resize(stride * asset.skin.len(), Candidate::default());
        if stride == 0 {
            return;
        }
        let joints = &asset.avatar.skeleton.joints;
        let parts = Strided::new(stride, candidates);
        par_split(asset.skin.len(), VERTEX_GRAIN, parts, |v, out| {
            // A vertex without an area touches nothing.
            if asset.avatar.skin.measure[v] == 0.0 {
                out.fill(Candidate::default());
                return;
            }
            let unposed = self.skin_unposed(asset, v, &motion.handles);
            let skinning = asset.skin.skinning.row(v);
            let point = contact_point(skinning, joints, &motion.frames, unposed);
            for ((out, collider), place) in
                out.iter_mut().zip(&self.colliders).zip(&*collider_frames)
            {
                *out = if may_touch(skinning, collider) {
                    contact(point, collider, place)
                } else {
                    Candidate::default()
                };
            }
        });
    }

    /// u of the lagged contact `k` at qⁿ, m: the collider's motion is ahead of the skin's.
    pub fn start_slip(&self, k: usize) -> DVec3 {
        let lagged = &self.lagged[k];
        match lagged.body {
            None => -carried(lagged, &self.collider_motions[lagged.collider as usize]),
            Some(_) => DVec3::ZERO,
        }
    }

    /// What `motion`, from a base with displacements `base`, adds to u of the lagged contact `k`, m.
    pub fn slip_change<B: Basis>(
        &self,
        asset: &Asset<B>,
        k: usize,
        base: &[DVec3],
        motion: &Motion,
    ) -> DVec3 {
        let lagged = &self.lagged[k];
        let v = lagged.vertex as usize;
        let moved = displacement(
            asset.skin.skinning.row(v),
            &asset.avatar.skeleton.joints,
            &motion.motions,
            self.skin_unposed(asset, v, base),
            self.skin_displacement(asset, v, &motion.handle_changes),
        );
        match lagged.body {
            None => moved,
            Some(body) => moved - carried(lagged, &motion.motions[body as usize]),
        }
    }

    /// The lagged contact `k` with its u in the state of `motion`.
    pub fn slip(&self, k: usize, displacement: DVec3, motion: &Motion) -> Slip {
        let lagged = &self.lagged[k];
        let rotation = match lagged.body {
            None => self.collider_motions[lagged.collider as usize].rotation,
            Some(body) => motion.frames[body as usize].rotation,
        };
        Slip {
            displacement,
            normal: rotation * lagged.normal,
        }
    }

    /// T of skin vertex `v`, m.
    pub fn skin_unposed<B: Basis>(&self, asset: &Asset<B>, v: usize, handles: &[DVec3]) -> DVec3 {
        self.skin_rest[v] + self.skin_displacement(asset, v, handles)
    }

    /// Σ N φ of skin vertex `v`, m.
    fn skin_displacement<B: Basis>(&self, asset: &Asset<B>, v: usize, handles: &[DVec3]) -> DVec3 {
        let coarse = unposed_displacement(asset.skin.basis.row(v), handles);
        match self.fine_skin.row(v) {
            [] => coarse,
            fine => coarse + unposed_displacement(fine, handles),
        }
    }

    /// k a of skin vertex `v` and collider `k`, N/m.
    pub fn contact_stiffness<B: Basis>(&self, asset: &Asset<B>, v: usize, k: usize) -> f64 {
        let tissue = asset.avatar.contact_stiffness_at(v) * self.factors.stiffness;
        self.colliders[k].stiffness_on(tissue) * asset.avatar.skin.measure[v]
    }

    /// Σ ½ k a δ² of the candidates, J.
    pub fn sum_contact_energy<B: Basis>(&self, asset: &Asset<B>, candidates: &[Candidate]) -> f64 {
        let rows = candidates.chunks_exact(self.colliders.len().max(1));
        let mut sum = 0.0;
        for (v, row) in rows.enumerate() {
            for (k, candidate) in row.iter().enumerate() {
                if candidate.depth > 0.0 {
                    let stiffness = self.contact_stiffness(asset, v, k);
                    sum += energy::contact(stiffness, 0.0, candidate.depth);
                }
            }
        }
        sum
    }
}
