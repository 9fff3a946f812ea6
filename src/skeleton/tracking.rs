//! Springs and dampers that draw a bone to a moving target.

use super::log_derivative::{inverse_left_jacobian, log_curvature};
use super::term::{FrameHessian, FrameTerm, Residual};
use crate::math::rotation_log;
use crate::model::{Frame, InertialTarget};
use glam::{DMat3, DVec3};
use serde::{Deserialize, Serialize};

/// A spring and a damper of its velocity.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Spring {
    /// k, N/m or N·m/rad.
    pub stiffness: f64,
    /// d, N·s/m or N·m·s.
    #[serde(default)]
    pub damping: f64,
}

/// A bone's target.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Tracking {
    /// Which bone.
    pub bone: usize,
    /// Target at the end of the step.
    pub frame: Frame,
    /// Target at its start.
    pub previous: Frame,
    /// Target at the start of the step before.
    #[serde(skip, default = "nowhere")]
    pub earlier: Frame,
    /// How the rotation is drawn to the target's; N·m/rad, N·m·s.
    pub rotation: Option<Spring>,
    /// How the joint is drawn to the target's position; N/m, N·s/m.
    pub position: Option<Spring>,
}

impl Tracking {
    /// A target at rest at `frame`, for rotation (1000 N·m/rad) and position (1e5 N/m), undamped:
    /// stiff enough for a hand's weight to sag less than 0.1 mm and 0.1°.
    pub fn new(bone: usize, frame: Frame) -> Self {
        let spring = |stiffness| {
            Some(Spring {
                stiffness,
                damping: 0.0,
            })
        };
        Self {
            bone,
            frame,
            previous: frame,
            earlier: frame,
            rotation: spring(1e3),
            position: spring(1e5),
        }
    }

    /// A step is done: where the target is now is where it was.
    pub(crate) fn advance(&mut self) {
        self.earlier = self.previous;
        self.previous = self.frame;
    }

    /// It has been here all the time.
    pub(crate) fn rest(&mut self) {
        self.previous = self.frame;
        self.earlier = self.frame;
    }
}

/// What is read from where no earlier place is kept; see [`Tracking::earlier`].
fn nowhere() -> Frame {
    Frame::IDENTITY
}

/// E = ½ k |r|² + ½ d/h̃ |r − r̃|² for the rotation, r = log(R̂ᵀR), and the same for the position,
/// r = c − ĉ. R̂, ĉ are the target's at the step's end, and r̃ = a₀ rⁿ − a₁ rⁿ⁻¹, each r against the target
/// of its time, so that the damper sees the velocity relative to the target's.
///
/// With R ← exp(\[δω\]) R: δr = J_l⁻¹(r) R̂ᵀ δω.
#[derive(Clone, Copy, Debug)]
pub struct TrackingSpring {
    target: Tracking,
    /// h̃, s.
    step: f64,
    /// r̃ of rotation and position.
    start: (DVec3, DVec3),
}

impl TrackingSpring {
    /// The term of `target` in a step that starts from `current`.
    pub fn new(target: Tracking, current: &[Frame], inertia: &InertialTarget<'_>) -> Self {
        let mut start = residuals(&target.previous, &current[target.bone]);
        if let ([before, ..], true) = (inertia.past, inertia.drift != 0.0) {
            let earlier = residuals(&target.earlier, &before.frames[target.bone]);
            start.0 += inertia.drift * (start.0 - earlier.0);
            start.1 += inertia.drift * (start.1 - earlier.1);
        }
        Self {
            target,
            step: inertia.step,
            start,
        }
    }

    /// Which bone.
    pub fn bone(&self) -> usize {
        self.target.bone
    }

    /// The force and the torque about the joint that the target exerts on the bone, N and N·m.
    pub fn load(&self, frames: &[Frame]) -> (DVec3, DVec3) {
        let mut force = [DVec3::ZERO; 2];
        for (load, (spring, r, start, slope)) in force.iter_mut().zip(self.parts(frames)) {
            if let Some(spring) = spring {
                *load = -(slope.transpose() * self.slope_of_energy(spring, r, start));
            }
        }
        (force[1], force[0])
    }

    /// For rotation, then position: the spring, r, r̃ and ∂r/∂(ω or c).
    fn parts(&self, frames: &[Frame]) -> [(Option<Spring>, DVec3, DVec3, DMat3); 2] {
        let target = &self.target;
        let (rotation, position) = residuals(&target.frame, &frames[target.bone]);
        let slope = inverse_left_jacobian(rotation) * target.frame.rotation.transpose();
        [
            (target.rotation, rotation, self.start.0, slope),
            (target.position, position, self.start.1, DMat3::IDENTITY),
        ]
    }

    /// ∂E/∂r.
    fn slope_of_energy(&self, spring: Spring, r: DVec3, start: DVec3) -> DVec3 {
        spring.stiffness * r + spring.damping / self.step * (r - start)
    }
}

/// log(R̂ᵀR) and c − ĉ.
fn residuals(target: &Frame, frame: &Frame) -> (DVec3, DVec3) {
    (
        rotation_log(target.rotation.transpose() * frame.rotation),
        frame.position - target.position,
    )
}

impl FrameTerm for TrackingSpring {
    fn difference(&self, base: &[Frame], frames: &[Frame]) -> f64 {
        let (from, to) = (self.parts(base), self.parts(frames));
        from.into_iter()
            .zip(to)
            .filter_map(|((spring, r0, start, _), (_, r, _, _))| {
                // ½k(|r|² − |r₀|²) is half the step times the sum of the slopes at both ends.
                let slopes = self.slope_of_energy(spring?, r, start)
                    + self.slope_of_energy(spring?, r0, start);
                Some(0.5 * (r - r0).dot(slopes))
            })
            .sum()
    }

    fn add_derivatives(
        &self,
        frames: &[Frame],
        gradient: &mut [f64],
        hessian: &mut FrameHessian<'_>,
    ) {
        let (translation, rotation) = (2 * self.target.bone, 2 * self.target.bone + 1);
        for (block, part) in [rotation, translation].into_iter().zip(self.parts(frames)) {
            let (Some(spring), r, start, slope) = part else {
                continue;
            };
            let residual = Residual {
                jacobian: [(block, slope)],
            };
            residual.add_gradient(self.slope_of_energy(spring, r, start), gradient);
            residual.add_hessian(spring.stiffness + spring.damping / self.step, hessian);
        }
    }

    fn add_geometric(&self, frames: &[Frame], hessian: &mut FrameHessian<'_>) {
        // The position's residual is linear.
        let [(Some(spring), r, start, _), _] = self.parts(frames) else {
            return;
        };
        let force = self.slope_of_energy(spring, r, start);
        let target = &self.target.frame.rotation;
        let curvature = *target * log_curvature(r, force) * target.transpose();
        let rotation = 2 * self.target.bone + 1;
        hessian.add(rotation, rotation, curvature);
    }
}
