//! What an avatar touches: one file a shape with its signed distance and outward normal in f64, and
//! the name of its kernel.

use crate::model::Frame;
use serde::{Deserialize, Serialize};

/// The shape of a collider, in its own frame, m. A new shape is one file, its kernel, and a line here.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "shape", rename_all = "snake_case")]
pub enum Shape {
    /// The solid below the plane z = 0.
    HalfSpace,
    /// A ball about the origin.
    Sphere {
        /// Radius.
        radius: f64,
    },
    /// A ball swept along z from −half_length to half_length.
    Capsule {
        /// Radius.
        radius: f64,
        /// Half the length of the axis, without the caps.
        half_length: f64,
    },
    /// A flat-ended cylinder along z.
    Cylinder {
        /// Radius.
        radius: f64,
        /// Half the height.
        half_length: f64,
    },
    /// A box about the origin.
    Box {
        /// Half the extents along x, y, z.
        half_extents: [f64; 3],
    },
}

/// A rigid solid that the skin cannot enter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Collider {
    /// Its shape.
    pub shape: Shape,
    /// Where it is at the end of the step.
    pub frame: Frame,
    /// Where it was at the start of the step.
    pub previous: Frame,
    /// Penalty stiffness k, Pa/m.
    pub stiffness: f64,
    /// d̂: distance at which contact begins, m.
    pub margin: f64,
}
