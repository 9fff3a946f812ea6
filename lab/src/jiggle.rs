//! Tissue that swings: let go, braked and walking, at several rates of frames beside steps of a millisecond.

mod mode;
mod walking;

use super::press::limb_recipe;
use super::{Bound, Figure, Page, Runner};
use glam::DVec3;
use mode::{Mode, damped_swing};
use std::f64::consts::{PI, TAU};
use std::sync::Arc;
use supple::Result;
use supple::internal::cpu::{posed_skin, skin_displacement};
use supple::internal::math::par_map;
use supple::material::{Material, StableNeoHookean};
use supple::model::{Avatar, Frame, Integrator, State, Surface};
use supple::potential::{CpuPotential, Potential};
use supple::sim::{Pin, Settings, Simulation, SolverMode};
use supple_bake::{HandleRegion, Recipe, SparseCholesky, bake, full_space};
use supple_pictures::{Animation, Camera, ColourScale, Curves, Legend, Mesh, Panel};
use supple_samples::Limb;

/// See [`draw`].
pub const FIGURE: Figure = Figure {
    name: "jiggle",
    title: "Tissue that jiggles alike at any rate",
    paper: "",
    draw,
};

/// Frames a second; the last one is the reference.
const RATES: [f64; 4] = [30.0, 60.0, 120.0, 1000.0];
const REFERENCE: usize = RATES.len() - 1;
/// Amplitude of what is let go, m.
const LET_GO: f64 = 2e-3;
/// Hz, of what is let go, and of what brakes.
const FREQUENCIES: [f64; 2] = [4.0, 4.5];
/// Half swings of a bounce of 0, 0.5 and 1.
const BOUNCES: [(f64, Bound); 3] = [
    (0.0, Bound::Within(1.0, 2.0)),
    (0.5, Bound::Within(3.0, 5.0)),
    (1.0, Bound::AtLeast(9.0)),
];

/// A layer of soft tissue around its bone.
const LIMB: Limb = Limb {
    length: 0.25,
    inner_radius: 0.015,
    outer_radius: 0.04,
    stations: 6,
    layers: 2,
    sectors: 6,
};

/// Lets tissue go and brakes its bone, at every rate, and compares.
fn draw(runner: &Runner) -> Result<Page> {
    let mut page = Page::new(
        "Soft tissue around a bone, every node solved for, at 30, 60 and 120 frames a second beside frames of 1 ms. Let go \
         from 2 mm of its first mode it must swing at that mode's frequency and decay by its damping ratio; braked from 2 m/s \
         within 0.1 s it must swing as far and as often. Steps of second order do; backward Euler, the paper's, damps by \
         ωh/2 beside what is asked for.",
    );
    let limb = Soft::new()?;
    ring_down(runner, &limb, &mut page)?;
    brake(runner, &limb, &mut page)?;
    walking::draw(runner, &mut page)?;
    Ok(page)
}

/// The limb of 1 Pa or so, to be scaled.
struct Soft {
    avatar: Avatar,
    law: StableNeoHookean,
    mode: Mode,
}

impl Soft {
    fn new() -> Result<Self> {
        let law = StableNeoHookean {
            youngs_modulus: 2e3,
            poissons_ratio: 0.4,
        };
        let recipe = Recipe {
            material: Some(Material::StableNeoHookean(law)),
            handles: vec![HandleRegion {
                count: Some(12),
                ..HandleRegion::default()
            }],
            captured_under_gravity: true,
            ..limb_recipe()
        };
        let avatar = full_space(&bake(&LIMB.body()?, &recipe, &mut |_| {})?.0)?;
        let mode = Mode::first(&avatar)?;
        Ok(Self { avatar, law, mode })
    }

    /// So soft that its first mode has `frequency`, Hz, and the damping ratio `damping`.
    fn tuned(&self, frequency: f64, damping: f64) -> Arc<Avatar> {
        let mut avatar = self.avatar.clone();
        // ω² goes with E.
        avatar.material = Material::StableNeoHookean(StableNeoHookean {
            youngs_modulus: self.law.youngs_modulus * (frequency / self.mode.frequency).powi(2),
            ..self.law
        });
        // ζ = ω β/2.
        avatar.set_damping_time(damping / (PI * frequency));
        Arc::new(avatar)
    }

    /// Plays `avatar` from `state` and what was before, its bone at `place` (m, of a time), for `duration`, s: all states.
    fn play(
        &self,
        avatar: &Arc<Avatar>,
        settings: Settings,
        duration: f64,
        start: &[DVec3],
        place: impl Fn(f64) -> DVec3,
    ) -> Result<Vec<State>> {
        let h = settings.time_step;
        let potential = CpuPotential::new(avatar.clone(), 1)?;
        let sparse = Box::new(SparseCholesky::new(potential.pattern())?);
        let mut simulation = Simulation::with_solver(avatar, potential, settings, sparse)?;
        let instance = &mut simulation.instances_mut()[0];
        instance.gravity = DVec3::ZERO;
        let at = |time: f64| Frame {
            position: place(time),
            ..Frame::IDENTITY
        };
        let mut state = instance.state.clone();
        state.frames[0] = at(0.0);
        state.handles.copy_from_slice(start);
        instance.set_state(state.clone());
        let frame = at(0.0);
        instance.pins.push(Pin { bone: 0, frame });
        if at(-h) != frame {
            let past = [1.0, 2.0, 3.0].map(|k| {
                let mut past = state.clone();
                past.frames[0] = at(-k * h);
                past
            });
            instance.history.set_motion(past, h);
        }
        let mut states = vec![state];
        for step in 1..=(duration / h).round() as usize {
            simulation.instances_mut()[0].pins[0].frame = at(step as f64 * h);
            simulation.step_blocking()?;
            states.push(simulation.instances()[0].state.clone());
        }
        Ok(states)
    }
}

fn settings(rate: f64) -> Settings {
    Settings {
        time_step: 1.0 / rate,
        ..Settings::default()
    }
}

/// How a rate is called.
fn frames(rate: f64) -> String {
    match rate {
        1000.0 => "1 ms".into(),
        rate => format!("{rate} Hz"),
    }
}

/// 2 mm of the first mode, let go.
fn ring_down(runner: &Runner, limb: &Soft, page: &mut Page) -> Result<()> {
    let frequency = FREQUENCIES[0];
    let omega = TAU * frequency;
    let start: Vec<DVec3> = limb.mode.shape.iter().map(|s| LET_GO * *s).collect();
    let mut rows = Vec::new();
    for &damping in runner.pick(&[0.1][..], &[0.1, 0.2]) {
        let avatar = limb.tuned(frequency, damping);
        let mut chart = Curves::new(
            &format!("Let go at {frequency} Hz, damping ratio {damping}"),
            "time (s)",
            "first mode (mm)",
        );
        let paper = Settings {
            integrator: Integrator::BackwardEuler,
            solver: SolverMode::OneIteration,
            ..settings(60.0)
        };
        let ways = RATES.map(|rate| (frames(rate), settings(rate), true));
        for (name, settings, checked) in
            ways.into_iter()
                .chain([("60 Hz, backward Euler".to_string(), paper, false)])
        {
            let states = limb.play(&avatar, settings, 1.2, &start, |_| DVec3::ZERO)?;
            let samples: Vec<(f64, f64)> = (states.iter().enumerate())
                .map(|(k, s)| (k as f64 * settings.time_step, limb.mode.amplitude(s)))
                .collect();
            let (sigma, swing) = damped_swing(&samples, omega);
            let [ratio, pitch] = [sigma / omega, swing / omega];
            rows.push(vec![
                name.clone(),
                format!("{damping}"),
                format!("{ratio:.3}"),
                format!("{:.2}", frequency * pitch),
            ]);
            if checked {
                let what = |what: &str| format!("let go, ζ {damping}, {name}: {what}");
                page.check(
                    what("decay a second over 2πf, off the damping ratio"),
                    (ratio - damping).abs(),
                    "",
                    Bound::AtMost(0.015),
                );
                page.check(
                    what("frequency over the mode's"),
                    pitch,
                    "",
                    Bound::Within(0.9, 1.1),
                );
            }
            chart = chart.line(&name, samples.iter().map(|(t, a)| (*t, 1e3 * a)));
        }
        page.curves(chart);
    }
    page.table(
        "Let go from 2 mm: the damped swing that is nearest to the first mode's part.",
        &["frames", "damping ratio wanted", "found", "frequency (Hz)"],
        rows,
    );
    Ok(())
}

/// Half swings above a tenth of the widest, and the widest, m, of displacements one after the other.
fn swings(of: &[f64]) -> (usize, f64) {
    let mut widest = vec![0.0f64];
    for &y in of {
        match widest.last_mut() {
            Some(last) if *last * y >= 0.0 => *last = if y.abs() > last.abs() { y } else { *last },
            _ => widest.push(y),
        }
    }
    let first = widest.iter().fold(0.0, |a: f64, s| a.max(s.abs()));
    let count = widest.iter().filter(|s| s.abs() > 0.1 * first).count();
    (count, first)
}

/// A bone that brakes from 2 m/s in 0.1 s.
fn brake(runner: &Runner, limb: &Soft, page: &mut Page) -> Result<()> {
    let frequency = FREQUENCIES[1];
    let sway: DVec3 = limb.mode.momentum.iter().sum();
    let direction = sway.normalize();
    let place = |time: f64| {
        let braking = time.clamp(0.0, 0.1);
        2.0 * (time.min(0.0) + braking - 5.0 * braking * braking) * direction
    };
    let still = vec![DVec3::ZERO; limb.mode.shape.len()];
    let mut rows = Vec::new();
    for &(bounce, swung) in runner.pick(&BOUNCES[1..2], &BOUNCES) {
        let avatar = limb.tuned(frequency, 10f64.powf(-1.5 * bounce));
        let runs = par_map(RATES.len(), |k| {
            limb.play(&avatar, settings(RATES[k]), 2.0, &still, place)
        });
        let runs = runs.into_iter().collect::<Result<Vec<_>>>()?;
        let curves: Vec<Vec<f64>> = (runs.iter())
            .map(|states| {
                let mean = |s: &State| s.handles.iter().sum::<DVec3>() / s.handles.len() as f64;
                states.iter().map(|s| mean(s).dot(direction)).collect()
            })
            .collect();
        let (_, truth) = swings(&curves[REFERENCE]);
        let mut chart = Curves::new(
            &format!("Braked from 2 m/s in 0.1 s, {frequency} Hz, bounce {bounce}"),
            "time (s)",
            "mean displacement (mm)",
        );
        for (rate, curve) in RATES.into_iter().zip(&curves) {
            let name = frames(rate);
            let (count, first) = swings(curve);
            rows.push(vec![
                name.clone(),
                format!("{bounce}"),
                count.to_string(),
                format!("{:.1}", 1e3 * first),
            ]);
            let what = |what: &str| format!("braked, bounce {bounce}, {name}: {what}");
            if rate != RATES[REFERENCE] {
                let one_off = match swung {
                    Bound::Within(least, most) => Bound::Within(least - 1.0, most + 1.0),
                    Bound::AtLeast(least) => Bound::AtLeast(least - 1.0),
                    bound => bound,
                };
                page.check(what("half swings"), count as f64, "", one_off);
                page.check(
                    what("widest over that of 1 ms"),
                    first / truth,
                    "",
                    Bound::Within(0.9, 1.1),
                );
            } else {
                page.check(what("half swings"), count as f64, "", swung);
            }
            let points = curve.iter().enumerate();
            chart = chart.line(&name, points.map(|(k, y)| (k as f64 / rate, 1e3 * y)));
        }
        page.curves(chart);
        if bounce == 0.5 {
            let animation = animation(runner, &avatar, &runs);
            page.animation(
                "brake",
                animation,
                "braked from 2 m/s, bounce 0.5, half as fast as it is",
            );
        }
    }
    page.table(
        "Braked: half swings above a tenth of the widest.",
        &["frames", "bounce", "half swings", "widest (mm)"],
        rows,
    );
    Ok(())
}

/// The runs side by side, at the frames of the slowest, seen from their bone.
fn animation(runner: &Runner, avatar: &Avatar, runs: &[Vec<State>]) -> Animation {
    let scale = ColourScale::up_to(40.0);
    let count = runner.pick(4, 24);
    let rest = &avatar.skin.position;
    let wide: Vec<DVec3> = rest.iter().flat_map(|x| [*x, 1.4 * *x]).collect();
    let [width, height] = [240, 200];
    let aspect = width as f64 / height as f64;
    let camera = Camera::framing(&wide, DVec3::new(-0.5, 1.0, -0.45), DVec3::Z, aspect);
    let frame = |k: usize| {
        let panels = RATES.into_iter().zip(runs).map(|(rate, states)| {
            let state = &states[(k as f64 * rate / RATES[0]).round() as usize];
            let origin = state.frames[0].position;
            let skin = posed_skin(avatar, state).positions;
            let surface = Surface {
                positions: skin.iter().map(|x| *x - origin).collect(),
                triangles: avatar.triangles.clone(),
            };
            let moved = skin_displacement(avatar, state);
            let colours = scale.colours(moved.iter().map(|d| 1e3 * d.length()));
            Panel {
                image: runner.picture(&[Mesh::coloured(surface, colours)], camera, [width, height]),
                caption: frames(rate),
            }
        });
        let legend = Legend {
            title: "displacement (mm)".into(),
            scale,
        };
        runner.sheet(panels.collect(), 0, Some(legend))
    };
    Animation {
        frames: par_map(count, frame),
        frame_time: 2.0 / RATES[0],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_swings_are_told_by_their_widest() {
        let (count, widest) = swings(&[0.0, -1.0, -3.0, -1.0, 2.0, 1.0, -1.0, 0.2, -0.1]);
        assert_eq!((count, widest), (3, 3.0));
    }
}
