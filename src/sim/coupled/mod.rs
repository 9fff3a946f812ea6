//! The linear systems of groups: members that touch common bodies.
//!
//! With x_m the DoFs that are member m's own and z those of the group's bodies, H_m = \[A_m K_mᵀ; K_m C_m\]:
//!
//! ```text
//! A_m x_m + K_mᵀ z = −g_m                         Σ_m K_m x_m + Σ_m C_m z = −Σ_m g_m,z
//! Σ_m (C_m − K_m A_m⁻¹ K_mᵀ) z = −Σ_m (g_m,z − K_m A_m⁻¹ g_m)
//! ```
//!
//! so that members are eliminated in parallel, and only the bodies' few DoFs are solved for together (a body is a member
//! that has no others). Each factor is in f32 with one refinement against the f64 residual of the whole system, in f64
//! where that does not serve, and with a shift of the scaled diagonal where it is indefinite: as
//! [`super::dense_cholesky`] has it for one member.

mod elimination;
mod part;
mod shared;

use super::dense_cholesky::SINGLE_PRECISION_RESIDUAL;
use super::groups::{Groups, Link};
use super::iterates::Iterates;
use super::linear_solver::{DIAGONAL_SHIFTS, SolveReport, multiply_add};
use super::minimisation::{Minimisation, check};
use super::solvers::Systems;
use crate::math::par_members;
use crate::potential::{BlockPattern, Evaluation};
use crate::{Error, Result};
use part::{Attempt, BODY, Part};
use shared::Shared;

/// A solve, then a refinement of it.
const ROUNDS: usize = 2;

/// Memory of all groups' systems, made when members first touch.
#[derive(Default)]
pub(super) struct Coupled {
    parts: Vec<Part>,
    groups: Vec<Shared>,
}

impl Coupled {
    /// Solves for the Newton step of every running member that is not alone.
    pub fn solve(
        &mut self,
        groups: &Groups,
        systems: &Systems,
        running: &[bool],
        minimisations: &mut [Minimisation],
        iterates: &Iterates,
    ) {
        if groups.is_single() {
            return;
        }
        self.begin(groups, systems, running, minimisations, iterates);
        let shifts = DIAGONAL_SHIFTS.iter().map(|&shift| Attempt::Double(shift));
        for attempt in std::iter::once(Attempt::Single).chain(shifts) {
            if !self.groups.iter().any(Shared::is_pending) {
                break;
            }
            self.attempt(groups, systems, &iterates.evaluations, attempt);
        }
        for (group, shared) in self.groups.iter().enumerate().filter(|(_, g)| g.running) {
            let of_group = groups.members(group);
            for &i in of_group {
                let minimisation = &mut minimisations[i];
                minimisation.step.copy_from_slice(&self.parts[i].step);
                minimisation.solved = finish(minimisation, iterates, i, shared.solved);
            }
            let reports = || of_group.iter().map(|&i| &minimisations[i].report);
            let decrement = reports().map(|r| r.decrement).sum();
            let step_length = reports().map(|r| r.step_length).fold(0.0, f64::max);
            for &i in of_group {
                minimisations[i].report.decrement = decrement;
                minimisations[i].report.step_length = step_length;
            }
        }
    }

    /// Numbers and scales the DoFs of every group.
    fn begin(
        &mut self,
        groups: &Groups,
        systems: &Systems,
        running: &[bool],
        minimisations: &[Minimisation],
        iterates: &Iterates,
    ) {
        let Self {
            parts,
            groups: shared,
        } = self;
        parts.resize_with(running.len(), Part::default);
        shared.resize_with(groups.len(), Shared::default);
        parts.iter_mut().for_each(|part| part.group = None);
        for (group, shared) in shared.iter_mut().enumerate() {
            let (of_group, links) = (groups.members(group), groups.links(group));
            shared.running = !links.is_empty() && running[of_group[0]];
            if !shared.running {
                continue;
            }
            of_group.iter().for_each(|&i| parts[i].group = Some(group));
            shared.begin(number_bodies(parts, of_group, links));
            for &i in of_group {
                let (part, fixed) = (&mut parts[i], &minimisations[i].fixed);
                let (pattern, hessian) = (systems.pattern(i), &iterates.evaluations[i].hessian);
                let linked = links.iter().filter(|link| link.member == i);
                let linked = linked.map(|link| link.frame);
                let own_frame = is_body(links, i).then_some(0);
                part.begin(linked.chain(own_frame), pattern, hessian, fixed);
                for (dof, z) in part.shared_dofs() {
                    shared.scaling[z] += diagonal(pattern, hessian, dof);
                    // That a member cannot move the frame says nothing of the body.
                    shared.fixed[z] |= own_frame.is_some() && fixed[dof];
                }
            }
            shared.finish_scaling();
            of_group
                .iter()
                .for_each(|&i| parts[i].share_scaling(&shared.scaling));
        }
    }

    /// Tries one factor on every group that is not solved yet.
    fn attempt(
        &mut self,
        groups: &Groups,
        systems: &Systems,
        evaluations: &[Evaluation],
        attempt: Attempt,
    ) {
        let Self {
            parts,
            groups: shared,
        } = self;
        let count = parts.len();
        let pending =
            |part: &Part, shared: &[Shared]| part.group.is_some_and(|g| shared[g].is_pending());
        par_members(count, &mut parts[..], |i, part: &mut Part| {
            if pending(part, shared) {
                part.factorise(systems.pattern(i), &evaluations[i].hessian, attempt);
                part.step.fill(0.0);
            }
        });
        for round in 0..=ROUNDS {
            par_members(count, &mut parts[..], |i, part: &mut Part| {
                if !pending(part, shared) || !part.factored {
                    return;
                }
                let (evaluation, pattern) = (&evaluations[i], systems.pattern(i));
                let (hessian, gradient) = (&evaluation.hessian, &evaluation.gradient);
                multiply_add(pattern, hessian, &part.step, gradient, &mut part.residual);
                if round < ROUNDS {
                    part.forward(attempt);
                }
            });
            for (group, shared) in shared.iter_mut().enumerate() {
                let of_group = groups.members(group);
                if !shared.is_pending() || !of_group.iter().all(|&i| parts[i].factored) {
                    continue;
                }
                let norm = shared.residual_norm(parts, of_group);
                if round == 0 {
                    shared.gradient_norm = norm;
                }
                if round < ROUNDS {
                    let solved = shared.solve(parts, of_group, attempt);
                    of_group.iter().for_each(|&i| parts[i].factored = solved);
                } else {
                    shared.judge(norm, attempt);
                }
            }
            if round < ROUNDS {
                par_members(count, &mut parts[..], |_, part: &mut Part| {
                    if pending(part, shared) && part.factored {
                        part.backward(attempt);
                    }
                });
            }
        }
    }
}

impl Shared {
    /// Whether it is still to be solved.
    fn is_pending(&self) -> bool {
        self.running && self.solved.is_none()
    }

    /// Takes the step if |D (g + H δ)|, which is `norm`, is small enough.
    fn judge(&mut self, norm: f64, attempt: Attempt) {
        let start = self.gradient_norm;
        let residual = if start == 0.0 { 0.0 } else { norm / start };
        let (serves, diagonal_shift) = match attempt {
            Attempt::Single => (residual < SINGLE_PRECISION_RESIDUAL, 0.0),
            Attempt::Double(shift) => (residual.is_finite(), shift),
        };
        self.solved = serves.then_some(SolveReport {
            diagonal_shift,
            residual,
        });
    }
}

/// Whether member `i` is a body of the group that `links` join.
fn is_body(links: &[Link], i: usize) -> bool {
    links.iter().any(|link| link.body == i)
}

/// Tells each part of a group where the bodies that it touches stand; returns the number of their DoFs.
fn number_bodies(parts: &mut [Part], of_group: &[usize], links: &[Link]) -> usize {
    let mut dofs = 0;
    for &i in of_group {
        parts[i].bodies.clear();
        if is_body(links, i) {
            parts[i].bodies.push(dofs);
            dofs += BODY;
        }
    }
    for link in links {
        let at = parts[link.body].bodies[0];
        parts[link.member].bodies.push(at);
    }
    dofs
}

/// Completes a member's iteration with the step that has been solved for.
fn finish(
    minimisation: &mut Minimisation,
    iterates: &Iterates,
    member: usize,
    solved: Option<SolveReport>,
) -> Result<()> {
    let evaluation = &iterates.evaluations[member];
    let energies = iterates.skeleton_energies[member];
    check(evaluation, energies)?;
    let solved = solved.ok_or_else(|| Error::Solve {
        system: "Newton system of avatars that touch common bodies",
        problem: "not positive definite, even with its scaled diagonal doubled".into(),
    })?;
    minimisation.finish(evaluation, energies, solved)
}

/// H_ii of a packed Hessian.
fn diagonal(pattern: &BlockPattern, hessian: &[[f64; 9]], dof: usize) -> f64 {
    // The diagonal block is the last of its row.
    hessian[pattern.columns().range(dof / 3).end - 1][4 * (dof % 3)]
}
