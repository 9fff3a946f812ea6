//! The bones of each model, in the published order.

use super::SmplKind;

/// Bones of the body that all but MANO share.
const BODY: [&str; 22] = [
    "pelvis",
    "left_hip",
    "right_hip",
    "spine1",
    "left_knee",
    "right_knee",
    "spine2",
    "left_ankle",
    "right_ankle",
    "spine3",
    "left_foot",
    "right_foot",
    "neck",
    "left_collar",
    "right_collar",
    "head",
    "left_shoulder",
    "right_shoulder",
    "left_elbow",
    "right_elbow",
    "left_wrist",
    "right_wrist",
];

/// Bones of a hand beyond the wrist.
const FINGERS: [&str; 15] = [
    "index1", "index2", "index3", "middle1", "middle2", "middle3", "pinky1", "pinky2", "pinky3",
    "ring1", "ring2", "ring3", "thumb1", "thumb2", "thumb3",
];

/// SMPL-X's bones between body and hands.
const FACE: [&str; 3] = ["jaw", "left_eye_smplhf", "right_eye_smplhf"];

/// The model that has so many bones.
pub(super) fn kind(bones: usize) -> SmplKind {
    match bones {
        16 => SmplKind::Mano,
        24 => SmplKind::Smpl,
        52 => SmplKind::SmplH,
        55 => SmplKind::SmplX,
        _ => SmplKind::Other,
    }
}

/// The names of a model's bones; numbered ones where the model is not known.
pub(super) fn of(kind: SmplKind, bones: usize) -> Vec<String> {
    let side = |side: &str| FINGERS.map(|finger| format!("{side}_{finger}"));
    let body = BODY.map(String::from);
    match kind {
        SmplKind::Mano => [&["wrist".into()][..], &FINGERS.map(String::from)].concat(),
        SmplKind::Smpl => [&body[..], &["left_hand".into(), "right_hand".into()]].concat(),
        SmplKind::SmplH => [&body[..], &side("left"), &side("right")].concat(),
        SmplKind::SmplX => [
            &body[..],
            &FACE.map(String::from),
            &side("left"),
            &side("right"),
        ]
        .concat(),
        SmplKind::Other => (0..bones).map(|j| format!("bone_{j}")).collect(),
    }
}

/// First bone, in the file's order, of each hand's fifteen.
pub(super) fn first_fingers(kind: SmplKind) -> &'static [usize] {
    match kind {
        SmplKind::Mano => &[1],
        SmplKind::SmplH => &[22, 37],
        SmplKind::SmplX => &[25, 40],
        SmplKind::Smpl | SmplKind::Other => &[],
    }
}
