//! The bones of each model, in the published order.

use super::SmplKind;
use crate::motion::smpl::{BODY, FINGERS};

/// Bones of the body that SMPL-H and SMPL-X share with SMPL.
const SHARED: usize = 22;

/// SMPL-X's bones between body and hands.
const FACE: [&str; 3] = ["jaw", "left_eye", "right_eye"];

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
    let fingers = |side: &str| -> Vec<String> {
        let joints = FINGERS
            .iter()
            .flat_map(|finger| [1, 2, 3].map(|k| format!("{side}{finger}{k}")));
        joints.collect()
    };
    let body = BODY.map(|(name, _)| name.to_string());
    let hands = [fingers("left_"), fingers("right_")].concat();
    match kind {
        SmplKind::Mano => [vec!["wrist".into()], fingers("")].concat(),
        SmplKind::Smpl => body.to_vec(),
        SmplKind::SmplH => [&body[..SHARED], &hands].concat(),
        SmplKind::SmplX => [&body[..SHARED], &FACE.map(String::from), &hands].concat(),
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
