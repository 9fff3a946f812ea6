//! The hierarchy of a WebXR hand, whose joints files list side by side.

use std::collections::BTreeSet;

/// Joints of a finger from the wrist outward (WebXR Hand Input, §4.2); thumbs have no intermediate one.
const FINGERS: [&str; 5] = [
    "thumb",
    "index-finger",
    "middle-finger",
    "ring-finger",
    "pinky-finger",
];
const JOINTS: [&str; 5] = [
    "metacarpal",
    "phalanx-proximal",
    "phalanx-intermediate",
    "phalanx-distal",
    "tip",
];

/// Pairs (child, parent) of the nodes among `joints` that are called as WebXR calls a hand's joints.
pub(super) fn parents(names: &[Option<&str>], joints: &BTreeSet<usize>) -> Vec<(usize, usize)> {
    let find = |name: &str| joints.iter().copied().find(|&n| names[n] == Some(name));
    let mut pairs = Vec::new();
    let Some(wrist) = find("wrist") else {
        return pairs;
    };
    for finger in FINGERS {
        let mut parent = wrist;
        for joint in JOINTS.iter().filter_map(|j| find(&format!("{finger}-{j}"))) {
            pairs.push((joint, parent));
            parent = joint;
        }
    }
    pairs
}
