//! What no user should do: colliders that appear inside the body, targets that flip, springs and tissues of very
//! different stiffness, also side by side in one avatar, joints that are drawn beyond their limits, a rough body thrown
//! into the skin, time steps of any length in any order. Within stated bounds the avatar recovers; beyond them it stays
//! finite, or the step is refused and leaves everything as it was.

use std::ops::Range;
use std::sync::{Arc, OnceLock};
use supple::Error;
use supple::bake::{CubatureRecipe, HandleRegion, Recipe, bake};
use supple::collider::{Collider, Shape};
use supple::glam::{DMat3, DVec3};
use supple::material::{LocalTissue, Material, StableNeoHookean};
use supple::math::{Random, rotation_exp};
use supple::model::{Avatar, Frame, JointRange, RigidBody, State, Surface};
use supple::potential::Potential;
use supple::reference::{Reference, min_det_f};
use supple::sample::Finger;
use supple::sim::{Instance, Settings, Simulation, SolverMode};
use supple::skeleton::{Spring, Tracking};

/// A coarse finger: three bones, 16 handles.
fn finger() -> &'static Avatar {
    static FINGER: OnceLock<Avatar> = OnceLock::new();
    FINGER.get_or_init(|| {
        let finger = Finger {
            edge_length: 0.004,
            ..Finger::default()
        };
        let recipe = Recipe {
            handles: vec![HandleRegion {
                count: Some(16),
                ..HandleRegion::default()
            }],
            cubature: CubatureRecipe {
                points: Some(120),
                ..CubatureRecipe::default()
            },
            ..Recipe::default()
        };
        bake(&finger.body().unwrap(), &recipe, &mut |_| {})
            .unwrap()
            .0
    })
}

/// The finger with a rough ball of 20 g that comes within its reach, and joints of 30° each way.
fn company() -> &'static Avatar {
    static COMPANY: OnceLock<Avatar> = OnceLock::new();
    COMPANY.get_or_init(|| {
        let ball = RigidBody {
            friction: 0.8,
            ..RigidBody::new("ball", Shape::Sphere { radius: BALL }, 1e3).unwrap()
        };
        let mut avatar = finger().clone().with_bodies([ball.of_mass(0.02).at(AWAY)]);
        let limits = &mut avatar.as_mut().unwrap().skeleton.limits;
        let most = DVec3::splat(0.5);
        let hinge = JointRange::Axes {
            axes: DMat3::IDENTITY,
            least: -most,
            most,
        };
        let cone = JointRange::Cone {
            axis: DVec3::X,
            swing: 0.5,
            twist: [-0.5, 0.5],
        };
        limits.extend([(1, hinge), (2, cone)]);
        avatar.unwrap()
    })
}

/// Radius of the ball, m.
const BALL: f64 = 0.012;

/// Where the ball touches nothing.
const AWAY: Frame = Frame {
    rotation: DMat3::IDENTITY,
    position: DVec3::new(0.0, 0.0, 1.0),
};

/// How rough a storm is.
struct Severity {
    /// How deep colliders appear inside the body, m.
    depth: f64,
    /// Shortest and longest time step, s.
    time_steps: [f64; 2],
    /// Weakest and strongest factor on springs and tissue; a map has both side by side.
    stiffness: [f64; 2],
    /// Gravity, m/s².
    gravity: f64,
    /// Steps.
    steps: usize,
}

/// What has to be recovered from.
const STATED: Severity = Severity {
    depth: 0.01,
    time_steps: [1e-3, 1.0 / 30.0],
    stiffness: [1e-2, 1e2],
    gravity: 10.0,
    steps: 30,
};

/// What has to be survived.
const BEYOND: Severity = Severity {
    depth: 0.2,
    time_steps: [1e-5, 0.1],
    stiffness: [1e-6, 1e6],
    gravity: 1e5,
    steps: 30,
};

/// Seeded trouble for one finger.
struct Storm {
    random: Random,
    severity: &'static Severity,
    rest: State,
    /// Whether there are friction, a body and limits, and tissue of both stiffnesses.
    company: bool,
    /// Longest displacement of a handle so far, m.
    bite: f64,
}

impl Storm {
    fn new(seed: u64, severity: &'static Severity) -> Self {
        Self {
            random: Random::new(seed),
            severity,
            rest: finger().rest_state(),
            company: false,
            bite: 0.0,
        }
    }

    fn in_company(seed: u64, severity: &'static Severity) -> Self {
        Self {
            rest: company().rest_state(),
            company: true,
            ..Self::new(seed, severity)
        }
    }

    /// Between the bounds, every order of magnitude alike.
    fn scaled(&mut self, [low, high]: [f64; 2]) -> f64 {
        self.random.uniform(low.ln(), high.ln()).exp()
    }

    /// The finger with tissue of a random stiffness: 300 Pa to 3 MPa within the stated bounds. In company the one is on
    /// one side of a random plane, and the other on the other.
    fn avatar(&mut self) -> Arc<Avatar> {
        if self.company {
            return Arc::new(self.patched(company().clone()));
        }
        let factor = self.scaled(self.severity.stiffness);
        Arc::new(Avatar {
            material: Material::StableNeoHookean(StableNeoHookean {
                youngs_modulus: 30e3 * factor,
                poissons_ratio: self.random.uniform(0.0, 0.45),
            }),
            ..finger().clone()
        })
    }

    /// `avatar` with a stiffness map of the widest ratio.
    fn patched(&mut self, mut avatar: Avatar) -> Avatar {
        let normal = self.random.rotation(3.0) * DVec3::X;
        let place = avatar.handles[self.random.index(avatar.handles.len())];
        let [soft, hard] = self.severity.stiffness;
        let tissue = |x: DVec3| LocalTissue {
            stiffness: if normal.dot(x - place) < 0.0 {
                soft
            } else {
                hard
            },
            ..LocalTissue::default()
        };
        avatar.tissue = avatar
            .cubature
            .position
            .iter()
            .map(|x| tissue(*x))
            .collect();
        let mesh = &avatar.layer.mesh;
        let centroid = |t: &[u32; 4]| t.map(|n| mesh.nodes[n as usize]).iter().sum::<DVec3>() / 4.0;
        avatar.layer.tissue = mesh.tets.iter().map(|t| tissue(centroid(t))).collect();
        avatar
    }

    fn drawn_to(&mut self, bone: usize, frame: Frame) -> Tracking {
        let stiffness = self.severity.stiffness;
        let mut spring = |k: f64| {
            let stiffness = k * self.scaled(stiffness);
            let damping = 0.01 * stiffness * self.random.uniform(0.0, 1.0);
            Some(Spring { stiffness, damping })
        };
        Tracking {
            rotation: spring(10.0),
            position: spring(1e4),
            ..Tracking::new(bone, frame)
        }
    }

    /// Something happens.
    fn strike(&mut self, skin: &Surface, instance: &mut Instance, time_step: f64) {
        // A body's collider stays.
        let kept = usize::from(self.company);
        match self.random.index(if self.company { 6 } else { 4 }) {
            0 => {
                let mut collider = self.inside(skin);
                if self.company {
                    collider.friction = self.random.uniform(0.0, 1.0);
                }
                instance.colliders.truncate(kept + 2);
                instance.colliders.insert(kept, collider);
            }
            1 => {
                instance.colliders.truncate(kept);
            }
            2 => {
                let axis = self.random.rotation(3.0) * DVec3::X;
                let flip = rotation_exp(std::f64::consts::PI * axis);
                let target = &mut instance.targets[self.random.index(3)];
                target.frame.rotation = flip * target.frame.rotation;
            }
            4 => {
                let (touched, normal) = self.within(skin);
                let at = Frame {
                    position: touched + BALL * normal,
                    ..Frame::IDENTITY
                };
                let velocity = self.random.vector(1.0) - normal;
                let spin = self.random.vector(30.0);
                instance.throw(3, at, velocity, spin, time_step);
            }
            5 => {
                let limit = self.random.index(2);
                instance.limits[limit].stiffness = 10.0 * self.scaled(self.severity.stiffness);
            }
            _ => {
                let bone = self.random.index(3);
                let target = self.drawn_to(bone, self.rest.frames[bone]);
                instance.targets[bone] = target;
                instance.bending[bone].stiffness = self.scaled(self.severity.stiffness);
                instance.gravity = self.random.vector(self.severity.gravity);
            }
        }
    }

    /// A place up to the stated depth below the skin, m, and the skin's normal there.
    fn within(&mut self, skin: &Surface) -> (DVec3, DVec3) {
        let v = self.random.index(skin.positions.len());
        let normal = skin.vertex_normals()[v];
        let depth = self.random.uniform(0.0, self.severity.depth);
        (skin.positions[v] - depth * normal, normal)
    }

    /// A solid that reaches up to the stated depth into the skin.
    fn inside(&mut self, skin: &Surface) -> Collider {
        let (touched, normal) = self.within(skin);
        let (shape, away) = match self.random.index(4) {
            0 => (Shape::Sphere { radius: 0.02 }, 0.02),
            1 => (Shape::HalfSpace, 0.0),
            2 => {
                let half_extents = [0.02, 0.03, 0.01];
                (Shape::Box { half_extents }, 0.01)
            }
            _ => {
                let (radius, half_length) = (0.01, 0.02);
                let cylinder = Shape::Cylinder {
                    radius,
                    half_length,
                };
                (cylinder, half_length)
            }
        };
        // Its z axis looks at the finger.
        let axis = DVec3::Z.cross(-normal);
        let angle = DVec3::Z.dot(-normal).clamp(-1.0, 1.0).acos();
        let frame = Frame {
            rotation: rotation_exp(angle * axis.normalize_or(DVec3::X)),
            position: touched + away * normal,
        };
        Collider::new(shape, frame)
    }

    /// Plays the storm and hands back what it left.
    fn rage<P: Potential>(
        &mut self,
        simulation: &mut Simulation<P>,
        mut check: impl FnMut(usize, supple::Result<()>),
    ) {
        let targets: Vec<_> = (0..3)
            .map(|bone| self.drawn_to(bone, self.rest.frames[bone]))
            .collect();
        simulation.instances_mut()[0].targets = targets;
        let (mut skin, mut normals) = (finger().skin.position.clone(), Vec::new());
        for step in 0..self.severity.steps {
            if self.random.index(3) == 0 {
                let surface = Surface {
                    // Without the ball's.
                    positions: skin[..finger().skin.len()].to_vec(),
                    triangles: finger().triangles.clone(),
                };
                let time_step = simulation.settings().time_step;
                self.strike(&surface, &mut simulation.instances_mut()[0], time_step);
            }
            if self.random.index(2) == 0 {
                let time_step = self.scaled(self.severity.time_steps);
                set_time_step(simulation, time_step);
            }
            let before = simulation.instances()[0].clone();
            let outcome = simulation.step_blocking().map(|_| ());
            let after = &simulation.instances()[0];
            assert!(after.state.is_finite(), "step {step}: {:?}", after.state);
            let bites = after.state.handles.iter().map(|x| x.length());
            self.bite = bites.fold(self.bite, f64::max);
            if outcome.is_err() {
                assert_eq!(before.state, after.state, "step {step}");
                assert_eq!(before.previous, after.previous, "step {step}");
            } else {
                simulation
                    .read_skin_blocking(0, &mut skin, &mut normals)
                    .unwrap();
                assert!(skin.iter().all(|x| x.is_finite()), "step {step}");
            }
            check(step, outcome);
        }
    }
}

fn modes() -> [SolverMode; 3] {
    [
        SolverMode::OneIteration,
        SolverMode::TWO_ITERATIONS,
        SolverMode::Converged {
            tolerance: 1e-6,
            max_iterations: 30,
        },
    ]
}

fn settings(solver: SolverMode) -> Settings {
    Settings {
        solver,
        bending_stiffness: 0.5,
        ..Settings::default()
    }
}

fn set_time_step<P: Potential>(simulation: &mut Simulation<P>, time_step: f64) {
    let settings = *simulation.settings();
    simulation
        .set_settings(Settings {
            time_step,
            ..settings
        })
        .unwrap();
}

fn cpu(avatar: &Arc<Avatar>, solver: SolverMode) -> Simulation<Reference> {
    let potential = Reference::new(avatar.clone(), 1, 5 * avatar.skin.len()).unwrap();
    Simulation::new(avatar, potential, settings(solver)).unwrap()
}

/// Two seconds of calm: nothing touches the finger, and its bones are drawn to where they were at first. What is left
/// of the storm: the skin's largest distance from rest (m), and the smallest det F.
fn calm<P: Potential>(simulation: &mut Simulation<P>) -> (f64, f64) {
    let rest = finger().rest_state();
    let instance = &mut simulation.instances_mut()[0];
    instance.colliders.retain(|c| c.carrier.is_some());
    for ball in instance.state.frames.iter_mut().skip(rest.frames.len()) {
        *ball = AWAY;
    }
    for ball in instance.previous.frames.iter_mut().skip(rest.frames.len()) {
        *ball = AWAY;
    }
    for limit in &mut instance.limits {
        // Weaker than what draws the bones: a stiff one between two bones that are half a turn off, one each way round,
        // keeps them there, a minimum of the energy.
        limit.stiffness = 1.0;
    }
    instance.gravity = DVec3::ZERO;
    for (bone, target) in instance.targets.iter_mut().enumerate() {
        let spring = |stiffness, damping| Some(Spring { stiffness, damping });
        *target = Tracking {
            rotation: spring(10.0, 0.1),
            position: spring(1e4, 10.0),
            ..Tracking::new(bone, rest.frames[bone])
        };
        instance.bending[bone].stiffness = 0.5;
    }
    set_time_step(simulation, 1.0 / 60.0);
    for _ in 0..120 {
        simulation.step_blocking().unwrap();
    }
    let (mut skin, mut normals) = (Vec::new(), Vec::new());
    simulation
        .read_skin_blocking(0, &mut skin, &mut normals)
        .unwrap();
    let pairs = skin.iter().zip(&finger().skin.position);
    let left = pairs.map(|(a, b)| a.distance(*b)).fold(0.0, f64::max);
    let state = &simulation.instances()[0].state;
    (left, min_det_f(&finger().layer, state))
}

#[test]
fn it_recovers_within_two_seconds() {
    recovers(0..40, Storm::new);
}

#[test]
fn in_rough_company_it_recovers_too() {
    recovers(0..20, Storm::in_company);
}

fn recovers(seeds: Range<u64>, storm: fn(u64, &'static Severity) -> Storm) {
    let (mut failures, mut bite) = (Vec::new(), 0.0f64);
    for seed in seeds {
        for mode in modes() {
            let mut storm = storm(seed, &STATED);
            let mut simulation = cpu(&storm.avatar(), mode);
            storm.rage(&mut simulation, |step, outcome| {
                if let Err(error) = outcome {
                    panic!("seed {seed}, {mode:?}, step {step}: {error}");
                }
            });
            bite = bite.max(storm.bite);
            let (left, det_f) = calm(&mut simulation);
            if !(left < 1e-4 && det_f > 0.9) {
                failures.push(format!("seed {seed}, {mode:?}: {left:e} m, det F {det_f}"));
            }
        }
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
    println!("handles were displaced by up to {bite} m");
    assert!(bite > 0.01, "{bite} m is no storm");
}

#[test]
fn beyond_its_bounds_it_stays_finite_or_refuses() {
    survives(100..140, Storm::new);
}

#[test]
fn in_rough_company_it_stays_finite_or_refuses() {
    survives(100..120, Storm::in_company);
}

fn survives(seeds: Range<u64>, storm: fn(u64, &'static Severity) -> Storm) {
    let mut refused = 0;
    for seed in seeds {
        for mode in modes() {
            let mut storm = storm(seed, &BEYOND);
            let mut simulation = cpu(&storm.avatar(), mode);
            storm.rage(&mut simulation, |step, outcome| match outcome {
                Ok(()) => {}
                Err(Error::NotFinite { .. } | Error::Solve { .. }) => refused += 1,
                Err(error) => panic!("seed {seed}, {mode:?}, step {step}: {error}"),
            });
        }
    }
    println!("{refused} steps were refused");
}

#[cfg(feature = "gpu")]
#[test]
fn a_gpu_recovers_too_and_survives() {
    use supple::GpuError;
    use supple::gpu::{AdapterChoice, GpuDevice};
    use supple::stage::{GpuOptions, GpuPotential};
    let gpu = pollster::block_on(GpuDevice::open(AdapterChoice::HardwareElseSoftware)).expect(
        "GPU tests need an adapter and never skip: install a Vulkan driver, for example the package \
         mesa-vulkan-drivers",
    );
    let simulation = |avatar: &Arc<Avatar>| {
        let (device, queue) = (&gpu.device, &gpu.queue);
        let options = GpuOptions {
            contacts: 4 * avatar.skin.len(),
            ..GpuOptions::default()
        };
        let potential = GpuPotential::new(device, queue, avatar.clone(), 1, options).unwrap();
        Simulation::new(avatar, potential, settings(SolverMode::OneIteration)).unwrap()
    };
    for seed in 0..3 {
        let mut storm = Storm::new(seed, &STATED);
        let mut simulation = simulation(&storm.avatar());
        storm.rage(&mut simulation, |step, outcome| {
            if let Err(error) = outcome {
                panic!("seed {seed}, step {step}: {error}");
            }
        });
        let (left, det_f) = calm(&mut simulation);
        assert!(
            left < 1e-4 && det_f > 0.9,
            "seed {seed}: {left:e} m, {det_f}"
        );
    }
    for seed in 100..103 {
        let mut storm = Storm::new(seed, &BEYOND);
        let mut simulation = simulation(&storm.avatar());
        storm.rage(&mut simulation, |step, outcome| match outcome {
            Ok(()) | Err(Error::NotFinite { .. } | Error::Solve { .. }) => {}
            Err(Error::Gpu(GpuError::DeviceLost(problem))) => panic!("seed {seed}: {problem}"),
            Err(error) => panic!("seed {seed}, step {step}: {error}"),
        });
    }
}
