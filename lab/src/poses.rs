//! Poses of the sample hand and body, as rotations relative to the parent bones.

use glam::{DMat3, DVec3};
use supple::internal::math::{Random, rotation_exp};
use supple::model::{JointRange, Skeleton};

/// A named pose.
pub(super) struct Pose {
    pub name: &'static str,
    /// R_parentᵀ R of each bone.
    pub local: Vec<DMat3>,
}

const DIGITS: [&str; 5] = ["index", "middle", "pinky", "ring", "thumb"];

/// Flexion of a digit's three joints and its abduction, degrees.
type Digit = [f64; 4];

/// The hand's poses: digits in the order of [`DIGITS`].
pub(super) fn hand_poses(skeleton: &Skeleton) -> Vec<Pose> {
    let poses: [(&str, [Digit; 5]); 4] = [
        (
            "spread",
            [
                [-5.0, 0.0, 0.0, 12.0],
                [-5.0, 0.0, 0.0, 0.0],
                [-5.0, 0.0, 0.0, -14.0],
                [-5.0, 0.0, 0.0, -7.0],
                [-5.0, 0.0, 0.0, 15.0],
            ],
        ),
        (
            "relaxed",
            [
                [20.0, 30.0, 15.0, 0.0],
                [28.0, 35.0, 18.0, 0.0],
                [40.0, 42.0, 22.0, 0.0],
                [34.0, 38.0, 20.0, 0.0],
                [10.0, 15.0, 20.0, 0.0],
            ],
        ),
        (
            "pointing",
            [
                [0.0, 5.0, 0.0, 0.0],
                [75.0, 90.0, 50.0, 0.0],
                [75.0, 85.0, 50.0, 0.0],
                [75.0, 90.0, 50.0, 0.0],
                [15.0, 40.0, 45.0, 0.0],
            ],
        ),
        (
            "fist",
            [
                [80.0, 95.0, 60.0, 0.0],
                [80.0, 97.0, 60.0, 0.0],
                [78.0, 90.0, 60.0, 0.0],
                [80.0, 95.0, 60.0, 0.0],
                [15.0, 45.0, 55.0, 0.0],
            ],
        ),
    ];
    let pose = |(name, digits): (&'static str, [Digit; 5])| Pose {
        name,
        local: hand_pose(skeleton, &digits),
    };
    poses.into_iter().map(pose).collect()
}

/// A pose anywhere within the joints' ranges; the root, and joints without a range, turn by up to half a radian.
pub(super) fn random_pose(skeleton: &Skeleton, random: &mut Random) -> Vec<DMat3> {
    // Springs keep joints within their ranges: at the edge, rounding would decide whether they act.
    const INSIDE: f64 = 0.95;
    let mut within = |range: Option<&JointRange>| match range {
        None => random.rotation(0.5),
        Some(JointRange::Axes { axes, least, most }) => {
            let angle = |k: usize| {
                let (middle, half) = (0.5 * (least[k] + most[k]), 0.5 * (most[k] - least[k]));
                (middle, INSIDE * half)
            };
            let turns = [0, 1, 2].map(angle).map(|(m, h)| m + random.uniform(-h, h));
            rotation_exp(*axes * DVec3::from_array(turns))
        }
        Some(JointRange::Cone { axis, swing, .. }) => {
            let about = random.vector(1.0).reject_from(*axis).normalize_or_zero();
            rotation_exp(about * random.uniform(0.0, INSIDE * swing))
        }
    };
    let range_of = |j: usize| {
        let mut limits = skeleton.limits.iter();
        limits
            .find(|(bone, _)| *bone as usize == j)
            .map(|(_, range)| range)
    };
    (0..skeleton.len()).map(|j| within(range_of(j))).collect()
}

/// Flexion turns towards the palm (−z), abduction about z.
fn hand_pose(skeleton: &Skeleton, digits: &[Digit; 5]) -> Vec<DMat3> {
    let mut local = vec![DMat3::IDENTITY; skeleton.len()];
    for (name, [first, second, third, abduction]) in DIGITS.iter().zip(digits) {
        let joints: Vec<usize> = (1..=3)
            .filter_map(|k| skeleton.find(&format!("{name}{k}")))
            .collect();
        let [a, b, c] = joints[..] else { continue };
        let along = (skeleton.joints[c] - skeleton.joints[a]).normalize_or(DVec3::X);
        // The thumb's back looks to its own side.
        let back = if *name == "thumb" {
            DVec3::new(-0.3, 0.7, 0.6)
        } else {
            DVec3::Z
        };
        let axis = back.cross(along).normalize_or(DVec3::Y);
        for (joint, flexion) in [(a, first), (b, second), (c, third)] {
            local[joint] = rotation_exp(axis * flexion.to_radians());
        }
        local[a] = rotation_exp(DVec3::Z * abduction.to_radians()) * local[a];
    }
    local
}

/// A bone and its rotation vector, degrees; of the left side, the right one being its mirror image, where the name
/// has no side.
type Bend = (&'static str, [f64; 3]);

/// The body's poses.
pub(super) fn body_poses(skeleton: &Skeleton) -> Vec<Pose> {
    let poses: [(&str, &[Bend]); 4] = [
        ("bind pose", &[]),
        (
            "flexed arms",
            &[
                ("shoulder", [0.0, 0.0, 10.0]),
                ("elbow", [0.0, -115.0, 0.0]),
                ("left_hip", [-10.0, 0.0, 4.0]),
                ("right_hip", [5.0, 0.0, -4.0]),
            ],
        ),
        (
            "squat",
            &[
                ("hip", [-95.0, 0.0, 12.0]),
                ("knee", [110.0, 0.0, 0.0]),
                ("ankle", [-25.0, 0.0, 0.0]),
                ("spine1", [18.0, 0.0, 0.0]),
                ("spine2", [12.0, 0.0, 0.0]),
                ("shoulder", [0.0, -70.0, -10.0]),
                ("elbow", [0.0, -20.0, 0.0]),
            ],
        ),
        (
            "stride",
            &[
                ("left_hip", [-45.0, 0.0, 0.0]),
                ("left_knee", [25.0, 0.0, 0.0]),
                ("right_hip", [22.0, 0.0, 0.0]),
                ("right_knee", [35.0, 0.0, 0.0]),
                ("spine1", [5.0, 12.0, 0.0]),
                ("spine3", [0.0, 12.0, 0.0]),
                ("shoulder", [0.0, 0.0, -65.0]),
                ("elbow", [0.0, -70.0, 0.0]),
            ],
        ),
    ];
    let pose = |(name, bends): (&'static str, &[Bend])| {
        let mut local = vec![DMat3::IDENTITY; skeleton.len()];
        for &(bone, degrees) in bends {
            for (side, sign) in [("", 1.0), ("left_", 1.0), ("right_", -1.0)] {
                if let Some(j) = skeleton.find(&format!("{side}{bone}")) {
                    let [x, y, z] = degrees.map(f64::to_radians);
                    // A rotation's mirror image keeps the part about x.
                    local[j] = rotation_exp(DVec3::new(x, sign * y, sign * z));
                }
            }
        }
        Pose { name, local }
    };
    poses.into_iter().map(pose).collect()
}
