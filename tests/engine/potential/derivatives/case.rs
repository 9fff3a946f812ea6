//! The avatars, states and colliders that the potential is differentiated at.

use pollster::block_on;
use std::sync::Arc;
use supple::collider::{Collider, Shape};
use supple::glam::DVec3;
use supple::internal::math::Random;
use supple::internal::{random_avatar, random_state};
use supple::material::{Material, StableNeoHookean};
use supple::model::{Avatar, Frame, InertialTarget, PoseBlend, State};
use supple::potential::{CpuPotential, Potential, StepStart, TissueFactors};

/// What a case is made of.
pub struct Case {
    pub name: &'static str,
    pub avatar: Avatar,
    pub time_step: f64,
    pub tissue_gravity: DVec3,
    pub colliders: Vec<Collider>,
    pub slip_speed: f64,
    pub factors: TissueFactors,
}

pub fn soft(youngs_modulus: f64) -> Material {
    Material::StableNeoHookean(StableNeoHookean {
        youngs_modulus,
        poissons_ratio: 0.4,
    })
}

/// Every shape, turned and placed so that part of the skin is in it.
fn colliders(random: &mut Random) -> Vec<Collider> {
    let place = |shape: Shape| {
        let frame = Frame {
            rotation: random.rotation(1.0),
            position: DVec3::new(1.0, 2.0, 3.0) + random.vector(0.04),
        };
        Collider {
            // Every other one takes the tissue's.
            stiffness: shape.index().is_multiple_of(2).then_some(1e6),
            margin: 4e-3,
            ..Collider::new(shape, frame)
        }
    };
    Shape::examples().into_iter().map(place).collect()
}

/// The same, rough and on the move.
fn rough(random: &mut Random) -> Vec<Collider> {
    let mut colliders = colliders(random);
    for collider in &mut colliders {
        let (shift, turn) = (random.vector(1e-5), random.vector(3e-4));
        collider.previous = collider.frame.moved(shift, turn);
        collider.friction = random.uniform(0.2, 1.0);
    }
    colliders
}

/// The same, every other one fixed to the frame `body`, which stands at the avatar's place.
pub fn carried(random: &mut Random, body: u32) -> Vec<Collider> {
    let mut colliders = rough(random);
    for collider in colliders.iter_mut().step_by(2) {
        collider.body = Some(body);
        collider.frame.position -= DVec3::new(1.0, 2.0, 3.0);
    }
    colliders
}

/// `avatar` with a frame more: a free body without tissue.
fn with_body(mut avatar: Avatar) -> Avatar {
    avatar.skeleton.names.push("body".into());
    avatar.skeleton.parents.push(None);
    avatar.skeleton.joints.push(DVec3::new(0.01, -0.02, 0.03));
    avatar.bone_masses.push(avatar.bone_masses[0]);
    avatar.cubature.pose_blend = PoseBlend::default();
    avatar.skin.pose_blend = PoseBlend::default();
    avatar.validate().unwrap();
    avatar
}

/// None of them 1.
pub fn factors() -> TissueFactors {
    let mut factors = TissueFactors::default();
    (factors.stiffness, factors.damping) = (1.5, 0.5);
    (factors.gravity, factors.friction) = (2.0, 0.75);
    factors.tension = 0.25;
    factors
}

pub fn cases() -> Vec<Case> {
    let random = &mut Random::new(11);
    let avatar = |density: f64, material: Material, damping: f64| {
        let mut avatar = Avatar {
            density,
            material,
            ..random_avatar(3, 3, 6, 12, 60)
        };
        // On each point's own.
        for local in &mut avatar.tissue {
            local.damping_time *= damping;
        }
        avatar
    };
    let gravity = DVec3::new(1.0, -9.0, 2.0);
    let case = |name, avatar, time_step, tissue_gravity, colliders| Case {
        name,
        avatar,
        time_step,
        tissue_gravity,
        colliders,
        slip_speed: 1e-3,
        factors: TissueFactors::default(),
    };
    // A term is alone where the others' factors are made negligible.
    let none = 1e-15;
    vec![
        case(
            "inertia",
            avatar(1e3, soft(none), 0.0),
            0.01,
            DVec3::ZERO,
            vec![],
        ),
        case(
            "gravity",
            avatar(1e3, soft(none), 0.0),
            1e9,
            gravity,
            vec![],
        ),
        case(
            "elastic",
            avatar(none, soft(3e4), 0.0),
            0.01,
            DVec3::ZERO,
            vec![],
        ),
        case(
            "damping",
            avatar(none, soft(none), 1e20),
            0.01,
            DVec3::ZERO,
            vec![],
        ),
        case(
            "contact",
            avatar(none, soft(none), 0.0),
            0.01,
            DVec3::ZERO,
            colliders(random),
        ),
        case(
            "friction",
            avatar(none, soft(none), 0.0),
            0.01,
            DVec3::ZERO,
            rough(random),
        ),
        Case {
            slip_speed: 0.5,
            ..case(
                "friction that holds",
                avatar(none, soft(none), 0.0),
                0.01,
                DVec3::ZERO,
                rough(random),
            )
        },
        case(
            "carried",
            with_body(avatar(none, soft(none), 0.0)),
            0.01,
            DVec3::ZERO,
            carried(random, 3),
        ),
        case(
            "all",
            with_body(avatar(1e3, soft(3e4), 2.0)),
            0.01,
            gravity,
            // No crease and no vertex on the brink within a step of the differences.
            carried(&mut Random::new(12), 3),
        ),
    ]
}

impl Case {
    /// qⁿ⁻¹, qⁿ, and a state away from both, somewhere far from the world's origin.
    pub fn states(&self) -> [State; 3] {
        let random = &mut Random::new(21);
        let mut base = random_state(22, &self.avatar, 0.8, 0.004);
        base.frames
            .iter_mut()
            .for_each(|f| f.position += DVec3::new(1.0, 2.0, 3.0));
        let mut step = |size: f64| -> Vec<f64> {
            (0..3 * base.space().blocks())
                .map(|k| {
                    let frames = 2 * self.avatar.skeleton.len();
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

    pub fn start<'a>(&'a self, previous: &'a State, current: &'a State) -> StepStart<'a> {
        StepStart {
            time_step: self.time_step,
            inertia: InertialTarget::backward_euler(previous, self.time_step),
            current,
            colliders: &self.colliders,
            tissue_gravity: self.tissue_gravity,
            slip_speed: self.slip_speed,
            geometric_contact: true,
            factors: self.factors,
            pose_offsets: &[],
            prescribed: &[],
        }
    }

    pub fn begun<B: supple::internal::cpu::Basis>(
        &self,
        mut potential: CpuPotential<B>,
    ) -> CpuPotential<B> {
        let [previous, current, _] = &self.states();
        let start = self.start(previous, current);
        let count = potential.instances();
        block_on(potential.begin_step(&vec![start; count], &vec![true; count])).unwrap();
        potential
    }

    pub fn reference(&self) -> CpuPotential {
        self.begun(CpuPotential::new(Arc::new(self.avatar.clone()), 1).unwrap())
    }
}
