//! The energies of the tissue, on a random avatar far from rest, moving, with every collider shape in touch: a term
//! is alone where the others' factors are made negligible.

use super::term::{Energy, Moved, Term};
use pollster::block_on;
use std::sync::Arc;
use supple::collider::{Collider, Shape};
use supple::glam::DVec3;
use supple::internal::cpu::HessianForm;
use supple::internal::math::Random;
use supple::internal::{random_avatar, random_state};
use supple::material::{Material, StableNeoHookean};
use supple::model::{Avatar, Frame, InertialTarget, State};
use supple::potential::{
    CpuPotential, Difference, Evaluation, Potential, StepStart, TissueFactors, Trial,
};

/// What of a property is left where a term must not be felt.
const NONE: f64 = 1e-15;

/// Far from the world's origin.
const PLACE: DVec3 = DVec3::new(1.0, 2.0, 3.0);

/// What a term is made of; by default it has none at all.
struct Setup {
    density: f64,
    material: Material,
    /// Factor on the damping time of each point.
    damping: f64,
    time_step: f64,
    tissue_gravity: DVec3,
    colliders: Vec<Collider>,
    slip_speed: f64,
    /// Whether there is a frame more: a body without tissue, which carries every other collider.
    body: bool,
}

impl Default for Setup {
    fn default() -> Self {
        Self {
            density: NONE,
            material: soft(NONE),
            damping: 0.0,
            time_step: 0.01,
            tissue_gravity: DVec3::ZERO,
            colliders: Vec::new(),
            slip_speed: 1e-3,
            body: false,
        }
    }
}

fn soft(youngs_modulus: f64) -> Material {
    Material::StableNeoHookean(StableNeoHookean {
        youngs_modulus,
        poissons_ratio: 0.4,
    })
}

/// `shape`, turned and placed so that part of the skin is in it.
fn touching(shape: Shape, random: &mut Random) -> Collider {
    let frame = Frame {
        rotation: random.rotation(1.0),
        position: PLACE + random.vector(0.04),
    };
    Collider {
        stiffness: Some(1e6),
        margin: 4e-3,
        ..Collider::new(shape, frame)
    }
}

pub fn terms() -> Vec<Term> {
    let random = &mut Random::new(11);
    let gravity = DVec3::new(1.0, -9.0, 2.0);
    let mut terms = vec![
        term(
            "inertia",
            Setup {
                density: 1e3,
                ..Setup::default()
            },
        ),
        Term {
            linear: true,
            ..term(
                "gravity",
                Setup {
                    density: 1e3,
                    // Inertia falls with its square.
                    time_step: 1e12,
                    tissue_gravity: gravity,
                    ..Setup::default()
                },
            )
        },
        term(
            "elasticity",
            Setup {
                material: soft(3e4),
                ..Setup::default()
            },
        ),
        term(
            "damping",
            Setup {
                damping: 1e20,
                ..Setup::default()
            },
        ),
    ];
    let colliders: Vec<_> = Shape::examples()
        .into_iter()
        .map(|shape| touching(shape, random))
        .collect();
    for collider in &colliders {
        terms.push(term(
            &format!("contact with {:?}", collider.shape),
            Setup {
                colliders: vec![collider.clone()],
                ..Setup::default()
            },
        ));
    }
    let rough = |c: &Collider| Collider {
        friction: 0.6,
        previous: c
            .frame
            .moved(DVec3::new(1e-3, -5e-4, 8e-4), DVec3::new(0.02, 0.01, -0.03)),
        ..c.clone()
    };
    let rough: Vec<_> = colliders.iter().map(rough).collect();
    // Where all contacts slide, and where none does.
    for (slip_speed, body) in [(1e-4, false), (1.0, false), (1e-4, true), (1.0, true)] {
        terms.push(term(
            &format!("contact and friction, ε_v = {slip_speed} m/s, carried: {body}"),
            Setup {
                colliders: rough.clone(),
                slip_speed,
                body,
                ..Setup::default()
            },
        ));
    }
    terms.push(term(
        "all of the tissue's",
        Setup {
            density: 1e3,
            material: soft(3e4),
            damping: 2.0,
            tissue_gravity: gravity,
            colliders,
            ..Setup::default()
        },
    ));
    terms
}

fn term(name: &str, setup: Setup) -> Term {
    Term {
        name: name.into(),
        energy: Box::new(Tissue::new(setup)),
        at_rest: None,
        linear: false,
    }
}

/// A potential in a step that has begun, about a state.
struct Tissue {
    potential: CpuPotential,
    state: State,
}

impl Tissue {
    fn new(setup: Setup) -> Self {
        let mut avatar = Avatar {
            density: setup.density,
            material: setup.material,
            ..random_avatar(3, 3, 6, 12, 60)
        };
        // On each point's own.
        for local in &mut avatar.tissue {
            local.damping_time *= setup.damping;
        }
        let mut colliders = setup.colliders;
        if setup.body {
            let body = avatar.skeleton.len() as u32;
            avatar.skeleton.names.push("body".into());
            avatar.skeleton.parents.push(None);
            avatar.skeleton.joints.push(DVec3::new(0.01, -0.02, 0.03));
            avatar.bone_masses.push(avatar.bone_masses[0]);
            for collider in colliders.iter_mut().step_by(2) {
                collider.body = Some(body);
                collider.frame.position -= PLACE;
            }
        }
        let [earlier, current, state] = states(&avatar);
        let near = |seed| {
            let mut state =
                earlier.moved(&vec![1e-3 * f64::from(seed); earlier.space().dofs()], 1.0);
            state.handles.reverse();
            state
        };
        let (previous, earliest) = (near(1), near(-2));
        let past = [previous, earlier, earliest];
        let mut potential = CpuPotential::new(Arc::new(avatar), 1).unwrap();
        let start = StepStart {
            time_step: setup.time_step,
            inertia: InertialTarget {
                past: &past,
                weights: [-2.4, 0.9, -0.15],
                drift: 0.3,
                step: 0.7 * setup.time_step,
                share: None,
            },
            current: &current,
            colliders: &colliders,
            tissue_gravity: setup.tissue_gravity,
            slip_speed: setup.slip_speed,
            geometric_contact: false,
            factors: TissueFactors::default(),
            pose_offsets: &[],
            prescribed: &[],
        };
        block_on(potential.begin_step(&[start], &[true])).unwrap();
        Self { potential, state }
    }

    fn moved(&self, by: Moved) -> State {
        let Some((dof, length)) = by else {
            return self.state.clone();
        };
        let mut step = vec![0.0; self.state.space().dofs()];
        step[dof] = length;
        self.state.moved(&step, 1.0)
    }

    fn evaluate(&mut self, at: Moved) -> Evaluation {
        let (state, mut out) = (self.moved(at), [Evaluation::default()]);
        block_on(self.potential.evaluate(&[state], &[true], &mut out)).unwrap();
        let [evaluation] = out;
        evaluation
    }
}

impl Energy for Tissue {
    fn difference(&mut self, from: Moved, to: Moved) -> f64 {
        let (base, state) = (&self.moved(from), &self.moved(to));
        let trial = Trial {
            instance: 0,
            base,
            state,
        };
        let mut out = [Difference::default()];
        block_on(self.potential.energy_differences(&[trial], &mut out)).unwrap();
        out[0].energy
    }

    fn gradient(&mut self, at: Moved) -> Vec<f64> {
        self.evaluate(at).gradient
    }

    fn hessian(&mut self, form: HessianForm) -> Vec<Vec<f64>> {
        if form == HessianForm::Exact {
            return self.potential.dense_hessian(0, &self.state, form).unwrap();
        }
        let packed = self.evaluate(None).hessian;
        let dofs = self.state.space().dofs();
        let mut full = vec![vec![0.0; dofs]; dofs];
        for ((row, column), block) in self.potential.pattern().blocks().zip(&packed) {
            for (k, value) in block.iter().enumerate() {
                let (r, c) = (3 * row + k % 3, 3 * column + k / 3);
                full[r][c] = *value;
                full[c][r] = *value;
            }
        }
        full
    }

    fn stated_projection(&mut self) -> Option<Vec<Vec<f64>>> {
        let form = HessianForm::Solver;
        Some(self.potential.dense_hessian(0, &self.state, form).unwrap())
    }
}

/// qⁿ⁻¹, qⁿ, and a state away from both.
fn states(avatar: &Avatar) -> [State; 3] {
    let random = &mut Random::new(21);
    let mut base = random_state(22, avatar, 0.8, 0.004);
    base.frames.iter_mut().for_each(|f| f.position += PLACE);
    let mut step = |size: f64| -> Vec<f64> {
        let frames = 2 * base.frames.len();
        (0..base.space().dofs())
            .map(|k| {
                let rotation = k / 3 < frames && k / 3 % 2 == 1;
                random.uniform(-1.0, 1.0) * size * if rotation { 20.0 } else { 1.0 }
            })
            .collect()
    };
    let (first, second) = (step(1e-3), step(2e-3));
    [
        base.clone(),
        base.moved(&first, 1.0),
        base.moved(&second, 1.0),
    ]
}
