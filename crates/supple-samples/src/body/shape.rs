//! The skin as one implicit function: trunk, head, arms and legs, blended where flesh is continuous.

use super::anatomy::mirrored;
use super::arm::Arm;
use super::head::Head;
use super::leg::Leg;
use super::trunk::Trunk;
use crate::field::{smooth_min, smoothstep};
use crate::remesh::Implicit;
use glam::DVec3;

/// The implicit body; symmetric in x.
#[derive(Clone, Debug)]
pub(super) struct BodyShape {
    trunk: Trunk,
    head: Head,
    pub arm: Arm,
    leg: Leg,
}

impl BodyShape {
    pub fn new() -> Self {
        Self {
            trunk: Trunk::new(),
            head: Head::new(),
            arm: Arm::new(),
            leg: Leg::new(),
        }
    }

    /// The field of the half x ≥ 0, each part only where it can matter.
    fn of_half(&self, p: DVec3) -> f64 {
        let mut body = f64::MAX;
        if p.y > 700.0 && p.x < 360.0 {
            body = self.trunk.distance(p);
        }
        if p.y > 1340.0 && p.x < 260.0 {
            body = smooth_min(body, self.head.distance(p), 30.0);
        }
        if p.x > 60.0 && p.y > 1180.0 {
            body = smooth_min(body, self.arm.distance(p), 34.0);
        }
        if p.y < 1100.0 {
            let mut legs = self.leg.distance(p);
            if p.x < 60.0 {
                // The other leg, for the fork.
                legs = smooth_min(legs, self.leg.distance(mirrored(p)), 10.0);
            }
            body = if body == f64::MAX {
                legs
            } else {
                smooth_min(body, legs, 48.0)
            };
        }
        if body == f64::MAX { 200.0 } else { body }
    }
}

impl Implicit for BodyShape {
    fn distance(&self, p: DVec3) -> f64 {
        self.of_half(DVec3::new(p.x.abs(), p.y, p.z))
    }

    fn edge_length(&self, p: DVec3) -> f64 {
        let p = DVec3::new(p.x.abs(), p.y, p.z);
        let blend = |a: f64, b: f64, t: f64| a + (b - a) * smoothstep(t);
        let trunk = self.trunk.edge_length(p);
        if p.y > 1380.0 && p.x < 150.0 {
            return blend(trunk, self.head.edge_length(p), (p.y - 1400.0) / 110.0);
        }
        if p.y > 1150.0 {
            return blend(trunk, self.arm.edge_length(p), (p.x - 150.0) / 80.0);
        }
        blend(self.leg.edge_length(p), trunk, (p.y - 780.0) / 120.0)
    }
}
