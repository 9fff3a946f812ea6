//! A member's part of its group's system.

use super::elimination::{Elimination, FIXED, Places};
use crate::potential::BlockPattern;
use crate::sim::linear_solver::diagonal_scaling;

/// DoFs of a body.
pub(super) const BODY: usize = 6;

/// Which factor is tried: f32, or f64 with a shift of the scaled diagonal.
#[derive(Clone, Copy)]
pub(super) enum Attempt {
    Single,
    Double(f64),
}

/// A member of a group: its numbering, its factor, and where its solution stands.
#[derive(Default)]
pub(super) struct Part {
    /// The group it is in; none where it is alone or does not run.
    pub group: Option<usize>,
    pub places: Places,
    /// Where the DoFs of each body that it touches (its own, where it is one) start among the group's.
    pub bodies: Vec<usize>,
    /// By DoF of its state: d with d² H_ii = 1.
    pub scaling: Vec<f64>,
    /// g + H δ.
    pub residual: Vec<f64>,
    /// δ.
    pub step: Vec<f64>,
    /// C − Wᵀ W over the bodies' DoFs, column by column.
    pub schur: Vec<f64>,
    /// −D r − Wᵀ y of them.
    pub reduced: Vec<f64>,
    /// z of them, scaled.
    pub moved: Vec<f64>,
    pub factored: bool,
    single: Option<Elimination<f32>>,
    double: Option<Elimination<f64>>,
}

/// The factor of an attempt.
macro_rules! with_factor {
    ($part:ident, $attempt:ident, |$factor:ident| $then:expr) => {
        match ($attempt, &mut $part.single, &mut $part.double) {
            (Attempt::Single, Some($factor), _) => $then,
            (Attempt::Double(_), _, Some($factor)) => $then,
            _ => (),
        }
    };
}

impl Part {
    /// Numbers the DoFs: those of `linked` frames, of a body its own, are the group's.
    pub fn begin(
        &mut self,
        linked: impl Iterator<Item = usize>,
        pattern: &BlockPattern,
        hessian: &[[f64; 9]],
        fixed: &[bool],
    ) {
        let (dofs, places) = (fixed.len(), &mut self.places);
        let of_dof = &mut places.of_dof;
        of_dof.clear();
        of_dof.resize(dofs, 0);
        // The group's are marked first, from 1 on.
        places.shared = 0;
        for dof in linked.flat_map(|frame| BODY * frame..BODY * (frame + 1)) {
            places.shared += 1;
            of_dof[dof] = places.shared as u32;
        }
        let free = |(place, fixed): &(&u32, &bool)| **place == 0 && !**fixed;
        places.own = of_dof.iter().zip(fixed).filter(free).count();
        let mut next = 0;
        for (place, fixed) in of_dof.iter_mut().zip(fixed) {
            *place = match *place {
                0 if *fixed => FIXED,
                0 => {
                    next += 1;
                    next - 1
                }
                shared => places.own as u32 + shared - 1,
            };
        }
        self.scaling.resize(dofs, 1.0);
        diagonal_scaling(pattern, hessian, fixed, &mut self.scaling);
        self.residual.resize(dofs, 0.0);
        self.step.resize(dofs, 0.0);
        let shared = self.places.shared;
        self.schur.resize(shared * shared, 0.0);
        self.reduced.resize(shared, 0.0);
        self.moved.resize(shared, 0.0);
    }

    /// Which of the group's DoFs the `k`-th of the bodies' is.
    pub fn of_group(&self, k: usize) -> usize {
        self.bodies[k / BODY] + k % BODY
    }

    /// (DoF, which of the group's it is) of the bodies' DoFs in the member's state.
    pub fn shared_dofs(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        let own = self.places.own as u32;
        let shared = move |&(_, &place): &(usize, &u32)| place != FIXED && place >= own;
        let places = self.places.of_dof.iter().enumerate().filter(shared);
        places.map(move |(dof, place)| (dof, self.of_group((place - own) as usize)))
    }

    /// Scales the bodies' DoFs as their group does.
    pub fn share_scaling(&mut self, of_group: &[f64]) {
        let own = self.places.own;
        for dof in 0..self.scaling.len() {
            let place = self.places.of_dof[dof];
            if place != FIXED && place as usize >= own {
                self.scaling[dof] = of_group[self.of_group(place as usize - own)];
            }
        }
    }

    /// |D (g + H δ)|² over its own DoFs.
    pub fn residual_norm_squared(&self) -> f64 {
        let own = self.places.own as u32;
        let scaled = self.scaling.iter().zip(&self.residual);
        (scaled.zip(&self.places.of_dof))
            .filter(|(_, place)| **place < own)
            .map(|((d, r), _)| (d * r).powi(2))
            .sum()
    }

    pub fn factorise(&mut self, pattern: &BlockPattern, hessian: &[[f64; 9]], attempt: Attempt) {
        let (places, dofs) = (&self.places, self.places.of_dof.len());
        let (scaling, schur) = (&self.scaling, &mut self.schur);
        let system = (pattern, hessian);
        self.factored = match attempt {
            Attempt::Single => (self.single.get_or_insert_with(|| Elimination::new(dofs)))
                .factorise(system, places, scaling, 0.0, schur),
            Attempt::Double(shift) => (self.double.get_or_insert_with(|| Elimination::new(dofs)))
                .factorise(system, places, scaling, shift, schur),
        };
    }

    pub fn forward(&mut self, attempt: Attempt) {
        let (places, scaling) = (&self.places, &self.scaling);
        let (residual, reduced) = (&self.residual, &mut self.reduced);
        with_factor!(self, attempt, |factor| factor
            .forward(places, scaling, residual, reduced));
    }

    pub fn backward(&mut self, attempt: Attempt) {
        let (places, scaling) = (&self.places, &self.scaling);
        let (moved, step) = (&self.moved, &mut self.step);
        with_factor!(self, attempt, |factor| factor
            .backward(places, scaling, moved, step));
    }
}
