//! Seeded trouble, step by step.

use super::avatars::{BALL, company, finger};
use std::sync::Arc;
use supple::collider::{Collider, Shape};
use supple::glam::{DQuat, DVec3};
use supple::internal::math::{Random, rotation_exp};
use supple::material::{LocalTissue, Material, StableNeoHookean};
use supple::model::{Avatar, Frame, State, Surface};
use supple::potential::Potential;
use supple::sim::{Instance, Settings, Simulation};
use supple::skeleton::{Spring, Tracking};

/// How rough a storm is.
pub struct Severity {
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
pub const STATED: Severity = Severity {
    depth: 0.01,
    time_steps: [1e-3, 1.0 / 30.0],
    stiffness: [1e-2, 1e2],
    gravity: 10.0,
    steps: 30,
};

/// What has to be survived.
pub const BEYOND: Severity = Severity {
    depth: 0.2,
    time_steps: [1e-5, 0.1],
    stiffness: [1e-6, 1e6],
    gravity: 1e5,
    steps: 30,
};

/// Seeded trouble for one finger.
pub struct Storm {
    random: Random,
    severity: &'static Severity,
    rest: State,
    /// Whether there are friction, a body and limits, and tissue of both stiffnesses.
    company: bool,
    /// Longest displacement of a handle so far, m.
    pub bite: f64,
}

impl Storm {
    pub fn new(seed: u64, severity: &'static Severity) -> Self {
        Self {
            random: Random::new(seed),
            severity,
            rest: finger().rest_state(),
            company: false,
            bite: 0.0,
        }
    }

    pub fn in_company(seed: u64, severity: &'static Severity) -> Self {
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
    pub fn avatar(&mut self) -> Arc<Avatar> {
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
        let stiffness = |x: DVec3| match normal.dot(x - place) < 0.0 {
            true => soft,
            false => hard,
        };
        let map = |tissue: &mut Vec<LocalTissue>, places: Vec<DVec3>| {
            tissue.resize(places.len(), LocalTissue::default());
            for (local, x) in tissue.iter_mut().zip(places) {
                (local.stiffness, local.axes) = (stiffness(x), DQuat::IDENTITY);
            }
        };
        let mesh = &avatar.layer.mesh;
        let centroids = (0..mesh.tets.len()).map(|t| mesh.centroid(t)).collect();
        map(&mut avatar.layer.tissue, centroids);
        map(&mut avatar.tissue, avatar.cubature.position.clone());
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
    fn strike(&mut self, skin: &Surface, instance: &mut Instance) {
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
                instance.set_motion(3, at, velocity, spin);
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
    pub fn rage<P: Potential>(
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
                self.strike(&surface, &mut simulation.instances_mut()[0]);
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
                assert_eq!(before.history, after.history, "step {step}");
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

pub fn set_time_step<P: Potential>(simulation: &mut Simulation<P>, time_step: f64) {
    let settings = *simulation.settings();
    simulation
        .set_settings(Settings {
            time_step,
            ..settings
        })
        .unwrap();
}
