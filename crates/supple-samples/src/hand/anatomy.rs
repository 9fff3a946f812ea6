//! Dimensions of the hand: joints, digits and their frames. Lengths in mm.
//!
//! Frame: a right hand, wrist joint at the origin, fingers along +x, thumb side +y, back of the hand
//! +z (the palm faces −z). Distances between joint centres follow the ratios to hand length that
//! Buchholz, Armstrong and Goldstein (1992) give, for a hand of 190 mm; the pose is relaxed and flat.

use crate::field::Axes;
use glam::DVec3;

/// Bone names in MANO's order.
pub(super) const NAMES: [&str; 16] = [
    "wrist", "index1", "index2", "index3", "middle1", "middle2", "middle3", "pinky1", "pinky2",
    "pinky3", "ring1", "ring2", "ring3", "thumb1", "thumb2", "thumb3",
];

/// Parent of bone `j`: chains of three from the wrist.
pub(super) fn parent(j: usize) -> Option<u32> {
    match j {
        0 => None,
        _ if j % 3 == 1 => Some(0),
        _ => Some(j as u32 - 1),
    }
}

/// A finger or the thumb.
#[derive(Clone, Debug)]
pub(crate) struct Digit {
    /// The three joints, proximal first, and the skin's tip.
    pub joints: [DVec3; 4],
    /// Where the metacarpal begins (of the thumb: its first joint).
    pub base: DVec3,
    /// Dorsal direction of the digit.
    pub dorsal: DVec3,
    /// Thickness relative to the index finger.
    pub scale: f64,
}

/// What is measured of a finger: joint centre (MCP), start of the metacarpal, lengths of the three
/// segments, spread from +x and slopes below the horizontal (degrees), thickness.
struct Finger {
    mcp: [f64; 3],
    base: [f64; 3],
    lengths: [f64; 3],
    spread: f64,
    slopes: [f64; 3],
    scale: f64,
}

const FINGERS: [Finger; 4] = [
    Finger {
        mcp: [89.0, 25.5, 1.5],
        base: [25.0, 15.0, 1.5],
        lengths: [43.0, 26.0, 22.0],
        spread: 7.5,
        slopes: [6.0, 15.0, 20.0],
        scale: 1.0,
    },
    Finger {
        mcp: [90.5, 4.5, 3.5],
        base: [24.0, 4.0, 3.0],
        lengths: [47.0, 30.5, 23.5],
        spread: -0.5,
        slopes: [6.0, 16.0, 21.0],
        scale: 1.02,
    },
    Finger {
        mcp: [77.0, -32.5, -3.0],
        base: [22.0, -17.5, 0.0],
        lengths: [35.0, 21.0, 20.0],
        spread: -18.0,
        slopes: [8.0, 17.0, 22.0],
        scale: 0.84,
    },
    Finger {
        mcp: [85.0, -15.0, 1.5],
        base: [23.0, -7.0, 2.0],
        lengths: [43.5, 28.5, 22.5],
        spread: -8.5,
        slopes: [7.0, 17.0, 22.0],
        scale: 0.95,
    },
];

/// Index, middle, pinky, ring, thumb: MANO's order.
pub(crate) fn digits() -> [Digit; 5] {
    let finger = |f: &Finger| {
        let plan = f.spread.to_radians();
        let mut joints = [DVec3::from_array(f.mcp); 4];
        for k in 0..3 {
            let slope = f.slopes[k].to_radians();
            let direction = DVec3::new(
                slope.cos() * plan.cos(),
                slope.cos() * plan.sin(),
                -slope.sin(),
            );
            joints[k + 1] = joints[k] + f.lengths[k] * direction;
        }
        // The arch of the palm rolls the outer fingers a little towards its middle.
        let roll = 0.35 * plan;
        Digit {
            joints,
            base: DVec3::from_array(f.base),
            dorsal: DVec3::new(0.0, roll.sin(), roll.cos()),
            scale: f.scale,
        }
    };
    let [index, middle, pinky, ring] = FINGERS.each_ref().map(finger);
    [index, middle, pinky, ring, thumb()]
}

fn thumb() -> Digit {
    let cmc = DVec3::new(21.0, 23.0, -8.5);
    let steps = [
        (44.0, DVec3::new(0.75, 0.62, -0.19)),
        (34.0, DVec3::new(0.83, 0.53, -0.14)),
        (29.0, DVec3::new(0.90, 0.42, -0.10)),
    ];
    let mut joints = [cmc; 4];
    for (k, (length, direction)) in steps.into_iter().enumerate() {
        joints[k + 1] = joints[k] + length * direction.normalize();
    }
    Digit {
        joints,
        base: cmc,
        dorsal: DVec3::new(-0.45, 0.55, 0.70),
        scale: 1.12,
    }
}

impl Digit {
    /// Frame along the straight line from the first joint to the tip.
    pub fn axes(&self) -> Axes {
        Axes::new(self.joints[0], self.joints[3] - self.joints[0], self.dorsal)
    }

    /// Coordinates of the joints and the tip in [`Digit::axes`].
    pub fn local_joints(&self) -> [DVec3; 4] {
        let axes = self.axes();
        self.joints.map(|j| axes.local(j))
    }
}

/// All 16 joints.
pub(super) fn joints(digits: &[Digit; 5]) -> Vec<DVec3> {
    std::iter::once(DVec3::ZERO)
        .chain(digits.iter().flat_map(|d| d.joints[..3].iter().copied()))
        .collect()
}
