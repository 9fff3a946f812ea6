//! One instance of a batch and its evaluation: the stages in order, each parallel over points, vertices
//! or block rows.

use super::asset::Asset;
use super::compact::compact;
use super::contact::{ContactRow, body_levers, contact_point, skin_levers};
use super::cubature::Cubature;
use super::evaluate_points::{Derivatives, evaluate_points};
use super::friction::{self, Slip};
use super::geometric::{Vertex, add_geometric};
use super::hessian::{
    ContactRows, ContactTerms, SkinBlocks, gather_contact_forces, gather_contacts,
    gather_point_forces, gather_points,
};
use super::point_hessian::{PointTerms, PointView, is_prescribed};
use super::woken::Woken;
use super::{Basis, Motion, energy};
use crate::math::{Mat9, RowsMut, Stopwatch, Strided, par_each, par_join, par_split};
use crate::model::State;
use crate::potential::cpu::begin_step::{Step, Touching};
use crate::potential::cpu::pose_skin::PosedSkin;
use crate::potential::{Energies, Evaluation, EvaluationTimings, StepEnd, StepStart};
use crate::{Error, Result};
use glam::DVec3;

/// Block rows and contacts of one task.
const ROW_GRAIN: usize = 2;
const CONTACT_GRAIN: usize = 16;

/// One avatar of the batch: its step, and the memory that its evaluations reuse.
pub(super) struct Instance {
    pub step: Step,
    /// The points in place of the asset's own while fine handles are awake.
    pub woken: Woken,
    pub motion: Motion,
    pub base_motion: Motion,
    feature: Vec<f64>,
    pub posed_skin: PosedSkin,
    pub touching: Touching,
    pub base_touching: Touching,
    pub energies: Vec<Energies>,
    /// Time of the current step's evaluations: `force` is what is done point by point, with the tangents,
    /// `hessian` the gather into block rows, with the gradient.
    pub timings: EvaluationTimings,
    terms: Vec<PointTerms>,
    arms: Vec<DVec3>,
    tangents: Vec<Mat9>,
    slips: Vec<Slip>,
    pub contacts: Vec<ContactRow>,
    levers: Vec<DVec3>,
    contact_rows: ContactRows,
    gradient: Vec<DVec3>,
}

impl Instance {
    pub fn new<B: Basis>(asset: &Asset<B>) -> Self {
        let points = asset.most_points();
        let bones = asset.cubature.points.skinning.entries().len();
        let most_bones = asset.avatar.fine.points.skinning.longest();
        let of_children = (points - asset.cubature.len()) * most_bones;
        Self {
            step: Step::new(asset),
            woken: Woken::new(asset),
            motion: Motion::default(),
            base_motion: Motion::default(),
            feature: Vec::new(),
            posed_skin: PosedSkin::default(),
            touching: Touching::default(),
            base_touching: Touching::default(),
            energies: vec![Energies::default(); points],
            timings: EvaluationTimings::default(),
            terms: vec![PointTerms::default(); points],
            arms: vec![DVec3::ZERO; bones + of_children],
            tangents: vec![[[0.0; 9]; 9]; points],
            slips: Vec::new(),
            contacts: Vec::new(),
            levers: Vec::new(),
            contact_rows: ContactRows::default(),
            gradient: vec![DVec3::ZERO; asset.space.blocks()],
        }
    }

    pub fn begin_step<B: Basis>(&mut self, asset: &Asset<B>, start: &StepStart<'_>) {
        let watch = Stopwatch::start();
        let (motion, feature) = (&mut self.motion, &mut self.feature);
        let (touching, posed_skin) = (&mut self.touching, &self.posed_skin);
        let step = &mut self.step;
        match self.woken.is_none() {
            true => {
                let points = (asset, &asset.cubature);
                step.begin(points, start, motion, feature, touching, posed_skin);
            }
            false => {
                let points = (asset, &self.woken.cubature);
                step.begin(points, start, motion, feature, touching, posed_skin);
            }
        }
        self.timings = EvaluationTimings {
            force: watch.ms(),
            ..EvaluationTimings::default()
        };
    }

    /// E(q) − E(qⁿ), its gradient and the solver's Hessian. [`Instance::check`] tells whether it is whole.
    pub fn evaluate<B: Basis>(&mut self, asset: &Asset<B>, state: &State, out: &mut Evaluation) {
        let watch = Stopwatch::start();
        out.contacts = self.evaluate_terms(asset, state, Derivatives::All);
        self.timings.force += watch.ms();
        let watch = Stopwatch::start();
        out.hessian.resize(self.hessian_blocks(asset), [0.0; 9]);
        let mut gradient = std::mem::take(&mut self.gradient);
        let (own, hessian) = (&asset.cubature, &mut out.hessian);
        match self.woken.is_none() {
            true => self.gather(asset, own, &mut gradient, hessian),
            false => self.gather(asset, &self.woken.cubature, &mut gradient, hessian),
        }
        self.gradient = gradient;
        self.add_geometric(asset, &mut out.geometric);
        self.timings.hessian += watch.ms();

        out.energies = self.sum_energies(asset);
        out.gradient.clear();
        out.gradient
            .extend(self.gradient.iter().flat_map(|g| g.to_array()));
        out.contact_force = self.contact_force();
    }

    /// The same without what handles need, at the state that the step ends with.
    pub fn end_step<B: Basis>(&mut self, asset: &Asset<B>, state: &State, out: &mut StepEnd) {
        let watch = Stopwatch::start();
        out.contacts = self.evaluate_terms(asset, state, Derivatives::OfFrames);
        let mut gradient = std::mem::take(&mut self.gradient);
        let of_frames = 2 * asset.space.frames;
        let rows = &mut gradient[..of_frames];
        match self.woken.is_none() {
            true => self.frame_forces(asset, &asset.cubature, rows),
            false => self.frame_forces(asset, &self.woken.cubature, rows),
        }
        out.frame_gradient.clear();
        let numbers = gradient[..of_frames].iter().flat_map(|g| g.to_array());
        out.frame_gradient.extend(numbers);
        self.gradient = gradient;
        out.energies = self.sum_energies(asset);
        out.contact_force = self.contact_force();
        self.timings.force += watch.ms();
    }

    /// What points and contacts have of their own at `state`; how many contacts there are.
    fn evaluate_terms<B: Basis>(
        &mut self,
        asset: &Asset<B>,
        state: &State,
        wanted: Derivatives,
    ) -> usize {
        let step = &self.step;
        self.motion.set(&step.current, state, step.origin);
        let (motion, touching) = (&self.motion, &mut self.touching);
        let woken = &self.woken;
        let skinning = match woken.is_none() {
            true => &asset.cubature.points.skinning,
            false => &woken.cubature.points.skinning,
        };
        let count = skinning.len();
        let points = (
            &mut self.terms[..count],
            &mut self.energies[..count],
            RowsMut::new(skinning.offsets(), &mut self.arms),
            &mut self.tangents[..count],
        );
        par_join(
            || step.contact(asset, motion, touching),
            || match woken.is_none() {
                true => evaluate_points(asset, &asset.cubature, step, motion, wanted, points),
                false => evaluate_points(asset, &woken.cubature, step, motion, wanted, points),
            },
        );
        let count = self.list_contacts(asset);
        self.evaluate_levers(asset);
        count
    }

    /// The rows of what touches, the normals' before friction's; how many contacts there are.
    pub fn list_contacts<B: Basis>(&mut self, asset: &Asset<B>) -> usize {
        let stiffness = |v, k| self.step.contact_stiffness(asset, v, k);
        let (candidates, colliders) = (&self.touching.candidates, &self.step.colliders);
        let count = compact(candidates, stiffness, colliders, &mut self.contacts);
        self.evaluate_slips(asset);
        count
    }

    /// E(q) − E(qⁿ), term by term.
    fn sum_energies<B: Basis>(&self, asset: &Asset<B>) -> Energies {
        let (step, candidates) = (&self.step, &self.touching.candidates);
        Energies {
            contact: step.sum_contact_energy(asset, candidates) - step.contact_energy,
            friction: self.friction_energy(),
            ..energy::sum(&self.energies[..self.points(asset)])
        }
    }

    /// Of contact and friction on the skin, N.
    fn contact_force(&self) -> DVec3 {
        self.contacts.iter().map(|c| -c.force * c.direction).sum()
    }

    /// Whether energies and a gradient are finite.
    pub fn check(energies: &Energies, gradient: &[f64]) -> Result<()> {
        if !energies.total().is_finite() {
            return Err(Error::NotFinite { quantity: "energy" });
        }
        if gradient.iter().any(|g| !g.is_finite()) {
            return Err(Error::NotFinite {
                quantity: "gradient",
            });
        }
        Ok(())
    }

    /// The slip of every lagged contact, and its rows behind the normals'.
    fn evaluate_slips<B: Basis>(&mut self, asset: &Asset<B>) {
        let (step, motion) = (&self.step, &self.motion);
        self.slips.resize(step.lagged.len(), Slip::default());
        par_each(&mut self.slips, CONTACT_GRAIN, |k, out| {
            let change = step.slip_change(asset, k, &step.current.handles, motion);
            *out = step.slip(k, step.start_slip(k) + change, motion);
        });
        for (lagged, slip) in step.lagged.iter().zip(&self.slips) {
            self.contacts
                .extend(friction::rows(lagged, slip, step.smoothing));
        }
    }

    /// Σ μ λ (f₀(|u_T|) − f₀ at qⁿ), J.
    fn friction_energy(&self) -> f64 {
        let step = &self.step;
        let pairs = step.lagged.iter().zip(&self.slips).enumerate();
        pairs
            .map(|(k, (lagged, slip))| {
                let start = Slip {
                    displacement: step.start_slip(k),
                    ..*slip
                };
                energy::friction(lagged.limit, step.smoothing, start.length(), slip.length())
            })
            .sum()
    }

    fn evaluate_levers<B: Basis>(&mut self, asset: &Asset<B>) {
        let (step, motion, contacts) = (&self.step, &self.motion, &self.contacts);
        let stride = asset.lever_stride + step.fine_skin.longest();
        self.levers.resize(contacts.len() * stride, DVec3::ZERO);
        let (frames, joints) = (&motion.frames, &asset.avatar.skeleton.joints);
        let parts = Strided::new(stride, &mut self.levers);
        par_split(contacts.len(), CONTACT_GRAIN, parts, |k, out| {
            let contact = &contacts[k];
            let (v, direction) = (contact.vertex as usize, contact.direction);
            let skinning = asset.skin.skinning.row(v);
            let side = (skinning, asset.skin.basis.row(v));
            let fine = step.fine_skin.row(v);
            let unposed = step.skin_unposed(asset, v, &motion.handles);
            let (of_skin, out) = out.split_at_mut(2 * side.0.len() + side.1.len());
            let (of_fine, of_body) = out.split_at_mut(fine.len());
            let pulled = skin_levers(side, joints, frames, unposed, direction, of_skin);
            for (n, out) in fine.iter().zip(of_fine) {
                *out = n.pull_back(pulled);
            }
            if let Some(body) = contact.body {
                let point = contact_point(skinning, joints, frames, unposed);
                let levers = body_levers(&frames[body as usize], point, direction);
                of_body[..2].copy_from_slice(&levers);
            }
        });
        let blocks = skin_blocks(asset, step);
        (self.contact_rows).fill(contacts, &blocks, asset.space.blocks());
    }

    /// The geometric terms of the contacts' rows, where the step wants them.
    fn add_geometric<B: Basis>(&self, asset: &Asset<B>, out: &mut Vec<[f64; 9]>) {
        out.clear();
        if !self.step.geometric {
            return;
        }
        out.resize(self.hessian_blocks(asset), [0.0; 9]);
        let (joints, frames) = (&asset.avatar.skeleton.joints, &self.motion.frames);
        let into = (&asset.pattern, &self.step.prescribed[..]);
        for row in self.contacts.iter().filter(|row| row.force != 0.0) {
            let v = row.vertex as usize;
            let vertex = Vertex {
                skinning: asset.skin.skinning.row(v),
                basis: asset.skin.basis.row(v),
                fine: self.step.fine_skin.row(v),
                unposed: self.step.skin_unposed(asset, v, &self.motion.handles),
            };
            add_geometric(into, row, &vertex, joints, frames, out);
        }
    }

    /// Gradient and packed Hessian, block row by block row.
    fn gather<B: Basis, C: Basis>(
        &self,
        asset: &Asset<B>,
        cubature: &Cubature<C>,
        gradient: &mut [DVec3],
        hessian: &mut [[f64; 9]],
    ) {
        let (contacts, prescribed) = (self.contact_terms(asset), &self.step.prescribed[..]);
        let rows = self.rows(asset);
        let (awake, asleep) = gradient.split_at_mut(rows);
        asleep.fill(DVec3::ZERO);
        let parts = (
            awake,
            RowsMut::new(asset.pattern.columns().offsets(), hessian),
        );
        par_split(rows, ROW_GRAIN, parts, |row, parts| {
            let (force, out) = parts;
            out.fill([0.0; 9]);
            if is_prescribed(prescribed, row) {
                *force = self.force(cubature, &contacts, row);
                return;
            }
            *force = DVec3::ZERO;
            let point = |i| self.point_view(cubature, i);
            gather_points(&cubature.incidence, row, point, force, out);
            gather_contacts(&contacts, row, force, out);
        });
    }

    /// The gradient by frames.
    fn frame_forces<B: Basis, C: Basis>(
        &self,
        asset: &Asset<B>,
        cubature: &Cubature<C>,
        out: &mut [DVec3],
    ) {
        let contacts = self.contact_terms(asset);
        par_each(out, ROW_GRAIN, |row, force| {
            *force = self.force(cubature, &contacts, row);
        });
    }

    /// Cubature points.
    fn points<B: Basis>(&self, asset: &Asset<B>) -> usize {
        match self.woken.is_none() {
            true => asset.cubature.len(),
            false => self.woken.cubature.len(),
        }
    }

    /// Block rows but for those of slots that are not taken, which come last.
    fn rows<B: Basis>(&self, asset: &Asset<B>) -> usize {
        asset.space.blocks() - asset.avatar.fine.slots + self.woken.handles()
    }

    /// Blocks of these rows.
    fn hessian_blocks<B: Basis>(&self, asset: &Asset<B>) -> usize {
        asset.pattern.columns().offsets()[self.rows(asset)] as usize
    }

    /// The gradient of block row `row`.
    fn force<C: Basis>(
        &self,
        cubature: &Cubature<C>,
        contacts: &ContactTerms<'_>,
        row: usize,
    ) -> DVec3 {
        let mut force = DVec3::ZERO;
        let point = |i| self.point_view(cubature, i);
        gather_point_forces(&cubature.incidence, row, point, &mut force);
        gather_contact_forces(contacts, row, &mut force);
        force
    }

    fn point_view<'a, C: Basis>(&'a self, cubature: &'a Cubature<C>, i: usize) -> PointView<'a, C> {
        let points = &cubature.points;
        PointView {
            terms: &self.terms[i],
            skinning: points.skinning.row(i),
            arms: &self.arms[points.skinning.range(i)],
            basis: points.basis.row(i),
            tangent: &self.tangents[i],
            prescribed: &self.step.prescribed,
        }
    }

    fn contact_terms<'a, B: Basis>(&'a self, asset: &'a Asset<B>) -> ContactTerms<'a> {
        ContactTerms {
            rows: &self.contact_rows,
            contacts: &self.contacts,
            levers: (
                asset.lever_stride + self.step.fine_skin.longest(),
                &self.levers,
            ),
            skin: skin_blocks(asset, &self.step),
            pattern: &asset.pattern,
            prescribed: &self.step.prescribed,
        }
    }
}

/// The blocks that move skin vertices in a step.
fn skin_blocks<'a, B: Basis>(asset: &'a Asset<B>, step: &'a Step) -> SkinBlocks<'a> {
    SkinBlocks {
        coarse: &asset.skin_incidence,
        fine: &step.fine_skin,
        first_handle: asset.space.handle_block(0) as u32,
    }
}
