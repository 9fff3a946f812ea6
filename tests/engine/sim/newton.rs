//! Newton's control flow on energies whose behaviour is known: how it starts, searches and stops.

use supple::glam::{DMat3, DVec3};
use supple::internal::random_avatar;
use supple::model::{Avatar, Integrator, Space, State};
use supple::potential::{
    BlockPattern, Difference, Evaluation, Potential, PreviousSkin, StepEnd, StepStart, Trial,
};
use supple::sim::{Iteration, Pin, Settings, Simulation, SolverMode, StepReport, Stop};
use supple::{Error, Result};

/// Energy, gradient and solver's Hessian of one handle's displacement.
type Law = fn(DVec3) -> (f64, DVec3, DMat3);

/// Handles that feel a law each on its own, and no bones at all.
struct Toy {
    law: Law,
    pattern: BlockPattern,
    base: Vec<State>,
    evaluations: usize,
    /// Geometric terms: this times the Hessian.
    geometric: Option<f64>,
}

impl Toy {
    fn new(avatar: &Avatar, law: Law, instances: usize) -> Self {
        Self {
            law,
            pattern: BlockPattern::new(avatar.space(), &[], &[]),
            base: vec![avatar.rest_state(); instances],
            evaluations: 0,
            geometric: None,
        }
    }

    fn energy(&self, state: &State) -> f64 {
        state.handles.iter().map(|&x| (self.law)(x).0).sum()
    }
}

impl Potential for Toy {
    fn name(&self) -> String {
        "toy".into()
    }
    fn space(&self) -> Space {
        self.pattern.space()
    }
    fn pattern(&self) -> &BlockPattern {
        &self.pattern
    }
    fn instances(&self) -> usize {
        self.base.len()
    }
    async fn begin_step(&mut self, starts: &[StepStart<'_>], _: &[bool]) -> Result<()> {
        self.base = starts.iter().map(|s| s.current.clone()).collect();
        Ok(())
    }
    async fn evaluate(
        &mut self,
        states: &[State],
        active: &[bool],
        out: &mut [Evaluation],
    ) -> Result<()> {
        self.evaluations += 1;
        for i in (0..states.len()).filter(|&i| active[i]) {
            out[i].energies.elastic = self.energy(&states[i]) - self.energy(&self.base[i]);
            out[i].gradient = vec![0.0; self.space().dofs()];
            out[i].hessian = vec![[0.0; 9]; self.pattern.len()];
            for (h, &x) in states[i].handles.iter().enumerate() {
                let (_, gradient, hessian) = (self.law)(x);
                let block = self.space().handle_block(h);
                gradient.write_to_slice(&mut out[i].gradient[3 * block..]);
                let at = self.pattern.find(block, block).unwrap();
                out[i].hessian[at] = hessian.to_cols_array();
            }
            out[i].geometric.clear();
            if let Some(factor) = self.geometric {
                let scaled = out[i].hessian.iter().map(|b| b.map(|h| factor * h));
                out[i].geometric = scaled.collect();
            }
        }
        Ok(())
    }
    async fn end_step(
        &mut self,
        states: &[State],
        wanted: &[bool],
        out: &mut [StepEnd],
    ) -> Result<()> {
        for i in (0..states.len()).filter(|&i| wanted[i]) {
            out[i].energies.elastic = self.energy(&states[i]) - self.energy(&self.base[i]);
            out[i].frame_gradient = vec![0.0; 6 * states[i].frames.len()];
        }
        Ok(())
    }
    async fn energy_differences(
        &mut self,
        trials: &[Trial<'_>],
        out: &mut [Difference],
    ) -> Result<()> {
        for (out, trial) in out.iter_mut().zip(trials) {
            *out = Difference {
                energy: self.energy(trial.state) - self.energy(trial.base),
                ..Difference::default()
            };
        }
        Ok(())
    }
    async fn pose_skin(
        &mut self,
        _: &[State],
        _: &[&[[f32; 3]]],
        _: &[PreviousSkin],
    ) -> Result<()> {
        Ok(())
    }
    async fn read_skin(&mut self, _: usize, _: &mut Vec<DVec3>, _: &mut Vec<DVec3>) -> Result<()> {
        Ok(())
    }
    async fn read_contacts(
        &mut self,
        _: usize,
        _: &State,
        _: &mut Vec<DVec3>,
        _: &mut Vec<f64>,
    ) -> Result<()> {
        Ok(())
    }
}

/// ½ k |x − a|².
fn quadratic(x: DVec3) -> (f64, DVec3, DMat3) {
    let r = x - DVec3::new(0.01, -0.02, 0.03);
    (
        50.0 * r.length_squared(),
        100.0 * r,
        DMat3::IDENTITY * 100.0,
    )
}

/// √(1 + |x|²): from |x| > 1 a full Newton step overshoots further each time.
fn flat(x: DVec3) -> (f64, DVec3, DMat3) {
    let root = (1.0 + x.length_squared()).sqrt();
    let outer = DMat3::from_cols(x * x.x, x * x.y, x * x.z);
    let hessian = DMat3::IDENTITY * root.recip() - outer * root.powi(-3);
    (root, x / root, hessian)
}

/// A soft well behind a hard wall at x = 0.1.
fn wall(x: DVec3) -> (f64, DVec3, DMat3) {
    let depth = (x.x - 0.1).max(0.0);
    let stiffness = if depth > 0.0 { 1e6 } else { 0.0 };
    let hessian = DMat3::IDENTITY + DMat3::from_diagonal(DVec3::X * stiffness);
    let energy = 0.5 * (x.length_squared() + stiffness * depth * depth);
    (energy, x + DVec3::X * stiffness * depth, hessian)
}

/// A gradient that is not of its energy: no length along the step helps.
fn contradictory(x: DVec3) -> (f64, DVec3, DMat3) {
    (x.x, -DVec3::X, DMat3::IDENTITY)
}

fn not_a_number(_: DVec3) -> (f64, DVec3, DMat3) {
    (f64::NAN, DVec3::ZERO, DMat3::IDENTITY)
}

fn not_a_force(_: DVec3) -> (f64, DVec3, DMat3) {
    (0.0, DVec3::INFINITY, DMat3::IDENTITY)
}

fn not_definite(x: DVec3) -> (f64, DVec3, DMat3) {
    (0.0, x + DVec3::X, DMat3::IDENTITY * -1.0)
}

/// One bone, pinned, and handles at `start` that come from `previous`.
fn simulation(law: Law, solver: SolverMode, previous: DVec3, start: DVec3) -> Simulation<Toy> {
    let avatar = random_avatar(1, 1, 3, 5, 12);
    let settings = Settings {
        solver,
        integrator: Integrator::BackwardEuler,
        ..Settings::default()
    };
    let mut simulation = Simulation::new(&avatar, Toy::new(&avatar, law, 1), settings).unwrap();
    let instance = &mut simulation.instances_mut()[0];
    let frame = instance.state.frames[0];
    instance.pins.push(Pin { bone: 0, frame });
    instance.state.handles.fill(start);
    let mut before = instance.state.clone();
    before.handles.fill(previous);
    (instance.history).set_previous(&before, &instance.state, settings.time_step);
    simulation
}

fn converged(tolerance: f64, max_iterations: usize) -> SolverMode {
    SolverMode::Converged {
        tolerance,
        max_iterations,
    }
}

#[test]
fn one_iteration_solves_a_quadratic() {
    let start = DVec3::new(0.3, 0.2, 0.1);
    let mut simulation = simulation(quadratic, SolverMode::OneIteration, start, start);
    let report = simulation.step_blocking().unwrap();
    assert_eq!(report.instances[0].stop, Stop::OneIteration);
    assert_eq!(simulation.potential().evaluations, 1);
    for x in &simulation.instances()[0].state.handles {
        let error = (*x - DVec3::new(0.01, -0.02, 0.03)).length();
        // The f32 factor, refined once.
        assert!(error < 1e-9, "{error:e}");
    }
}

#[test]
fn the_line_search_tames_an_overshooting_step() {
    let start = DVec3::new(3.0, 0.0, -1.0);
    let mut simulation = simulation(flat, converged(1e-9, 50), start, start);
    let report = simulation.step_blocking().unwrap();
    assert_eq!(report.instances[0].stop, Stop::Converged);
    assert!(simulation.instances()[0].state.handles[0].length() < 1e-9);
    // The full step would end at |x|³ = 32. One iteration alone goes as far as lowers the energy.
    let mut once = self::simulation(flat, SolverMode::OneIteration, start, start);
    let report = once.step_blocking().unwrap();
    assert_eq!(report.instances[0].stop, Stop::OneIteration);
    assert_eq!(report.instances[0].iterations, 1);
    let end = once.instances()[0].state.handles[0].length();
    assert!(end < start.length(), "{end}");
}

#[test]
fn a_prediction_that_raises_the_energy_is_not_started_from() {
    // The next step would carry the handles 0.05 m into the wall.
    let (previous, start) = (DVec3::ZERO, DVec3::X * 0.075);
    let mut blocked = simulation(wall, SolverMode::OneIteration, previous, start);
    let report = blocked.step_blocking().unwrap();
    assert!(report.instances[0].started_at_current);
    assert_eq!(blocked.potential().evaluations, 2);
    // From qⁿ the wall is not felt, so the step ends at the well's bottom.
    assert!(blocked.instances()[0].state.handles[0].length() < 1e-9);
    let mut free = simulation(wall, SolverMode::OneIteration, start, start * 0.5);
    let report = free.step_blocking().unwrap();
    assert!(!report.instances[0].started_at_current);
    assert_eq!(free.potential().evaluations, 1);
}

#[test]
fn an_observer_sees_every_iteration_and_changes_nothing() {
    let start = DVec3::new(3.0, 0.0, -1.0);
    let plain = &mut simulation(flat, converged(1e-9, 50), start, start);
    let expected = plain.step_blocking().unwrap().instances.remove(0);
    let observed = &mut simulation(flat, converged(1e-9, 50), start, start);
    let (mut seen, mut report) = (Vec::new(), StepReport::default());
    let mut observer = |iteration: &Iteration<'_>| {
        let (x, report) = (iteration.state.handles[0], iteration.report);
        let slope: f64 = (iteration.gradient.iter().zip(iteration.step))
            .map(|(g, d)| g * d)
            .sum();
        assert_eq!(report.decrement, -slope);
        // The pinned bone's part is its reaction: only the three handles count.
        let norm = 3.0_f64.sqrt() * flat(x).1.length();
        assert!((iteration.gradient_norm() - norm).abs() <= 1e-12 * norm);
        seen.push((report.iterations, x, report.step_length));
    };
    pollster::block_on(observed.step_observed(&mut report, &mut observer)).unwrap();
    assert_eq!(report.instances[0], expected);
    assert_eq!(observed.instances()[0].state, plain.instances()[0].state);
    let numbers = seen.iter().map(|(number, ..)| *number);
    assert!(numbers.eq(1..=expected.iterations));
    assert_eq!(seen[0].1, start);
    assert_eq!(seen.last().unwrap().2, expected.step_length);
}

#[test]
fn iterations_end_by_limit_or_stall_and_say_so() {
    let start = DVec3::new(3.0, 0.0, -1.0);
    let mut limited = simulation(flat, converged(1e-12, 2), start, start);
    let report = limited.step_blocking().unwrap();
    assert_eq!(report.instances[0].stop, Stop::IterationLimit);
    assert_eq!(report.instances[0].iterations, 2);
    let mut stalled = simulation(contradictory, converged(1e-9, 50), start, start);
    let report = stalled.step_blocking().unwrap();
    assert_eq!(report.instances[0].stop, Stop::LineSearchStalled);
    assert_eq!(stalled.instances()[0].state.handles[0], start);
}

#[test]
fn what_is_not_finite_or_not_solvable_is_an_error_and_the_state_is_kept() {
    let start = DVec3::new(0.3, 0.2, 0.1);
    for mode in [SolverMode::OneIteration, converged(1e-9, 10)] {
        for (law, quantity) in [(not_a_number as Law, "energy"), (not_a_force, "force")] {
            let mut simulation = simulation(law, mode, start * 0.9, start);
            let before = simulation.instances()[0].clone();
            let error = simulation.step_blocking().unwrap_err();
            assert!(
                matches!(error, Error::NotFinite { quantity: q } if q == quantity),
                "{error}"
            );
            let after = &simulation.instances()[0];
            assert_eq!(
                (&before.state, &before.history),
                (&after.state, &after.history)
            );
        }
        let mut simulation = simulation(not_definite, mode, start, start);
        let before = simulation.instances()[0].clone();
        let error = simulation.step_blocking().unwrap_err();
        assert!(matches!(error, Error::Solve { .. }), "{error}");
        assert_eq!(before.state, simulation.instances()[0].state);
    }
}

#[test]
fn geometric_terms_are_dropped_where_the_hessian_is_indefinite_with_them() {
    let start = DVec3::new(0.3, 0.2, 0.1);
    for mode in [SolverMode::OneIteration, converged(1e-9, 10)] {
        let run = |geometric: Option<f64>| {
            let mut simulation = simulation(quadratic, mode, start, start);
            simulation.potential_mut().geometric = geometric;
            let report = simulation.step_blocking().unwrap().instances.remove(0);
            let handles = simulation.instances()[0].state.handles.clone();
            (report, handles)
        };
        let (without, end) = run(None);
        assert_eq!(without.geometric_dropped, 0);
        // Little below 0: a shift of the diagonal would do, and is not what is wanted.
        let (dropped, same) = run(Some(-1.001));
        assert_eq!(dropped.geometric_dropped, dropped.iterations);
        assert_eq!((same, dropped.diagonal_shift), (end, 0.0));
    }
    // Three times the Hessian: a third of the way.
    let mut simulation = simulation(quadratic, SolverMode::OneIteration, start, start);
    simulation.potential_mut().geometric = Some(2.0);
    let report = simulation.step_blocking().unwrap();
    assert_eq!(report.instances[0].geometric_dropped, 0);
    let bottom = DVec3::new(0.01, -0.02, 0.03);
    for x in &simulation.instances()[0].state.handles {
        assert!((*x - start.lerp(bottom, 1.0 / 3.0)).length() < 1e-9, "{x}");
    }
}

#[test]
fn inactive_instances_stay_and_others_move() {
    let avatar = random_avatar(1, 1, 3, 5, 12);
    let toy = Toy::new(&avatar, quadratic, 3);
    let mut simulation = Simulation::new(&avatar, toy, Settings::default()).unwrap();
    simulation.instances_mut()[1].active = false;
    let before = simulation.instances()[1].clone();
    let report = simulation.step_blocking().unwrap();
    assert_eq!(report.instances[1].stop, Stop::Inactive);
    assert_eq!(simulation.instances()[1].state, before.state);
    for i in [0, 2] {
        assert_eq!(report.instances[i].stop, Stop::AsModelled);
        assert!(simulation.instances()[i].state.handles[0].length() > 0.01);
    }
}

#[test]
fn unusable_input_is_refused_by_name() {
    let start = DVec3::new(0.3, 0.2, 0.1);
    type Spoil = fn(&mut supple::sim::Instance);
    let cases: [(&str, Spoil); 9] = [
        ("state", |i| i.state.handles[1].y = f64::NAN),
        ("state", |i| i.state.handles.truncate(2)),
        ("history", |i| {
            let at = i.state.frames[0];
            i.history
                .set_velocity(0, &at, DVec3::X * f64::INFINITY, DVec3::ZERO)
        }),
        ("state", |i| i.state.frames[0].rotation *= 1.1),
        ("bending", |i| i.bending.clear()),
        ("bending", |i| i.bending[0].stiffness = -1.0),
        ("pins", |i| i.pins[0].bone = 7),
        ("pins", |i| i.pins[0].frame.rotation = DMat3::ZERO),
        ("gravity", |i| i.gravity.z = f64::NAN),
    ];
    for (field, spoil) in cases {
        let mut simulation = simulation(quadratic, SolverMode::OneIteration, start, start);
        spoil(&mut simulation.instances_mut()[0]);
        let error = simulation.step_blocking().unwrap_err();
        assert!(matches!(error, Error::Invalid { .. }), "{field}: {error}");
        assert!(error.to_string().contains(field), "{field}: {error}");
        assert_eq!(simulation.potential().evaluations, 0);
    }
}
