//! What a bone is, told by its name: SMPL's, CMU's, Mixamo's, Unreal's, VRM's, 3ds Max's, Poser's and
//! WebXR's conventions.

use serde::{Deserialize, Serialize};
use supple::model::Skeleton;

/// Which side of the body.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Side {
    /// The body's left.
    Left,
    /// The body's right.
    Right,
}

impl Side {
    /// The other one.
    pub fn other(self) -> Self {
        match self {
            Self::Left => Self::Right,
            Self::Right => Self::Left,
        }
    }
}

/// A finger.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Finger {
    /// Three bones; its first is the metacarpal.
    Thumb,
    /// Index finger.
    Index,
    /// Middle finger.
    Middle,
    /// Ring finger.
    Ring,
    /// Little finger.
    Little,
}

/// A part of the body.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Part {
    /// The pelvis.
    Hips,
    /// One of the bones between pelvis and neck; their number differs from skeleton to skeleton.
    Spine,
    /// One of the neck's bones.
    Neck,
    /// The head.
    Head,
    /// The collar bone.
    Collar,
    /// From the shoulder to the elbow.
    UpperArm,
    /// From the elbow to the wrist.
    LowerArm,
    /// From the wrist on.
    Hand,
    /// From the hip to the knee.
    UpperLeg,
    /// From the knee to the ankle.
    LowerLeg,
    /// From the ankle on.
    Foot,
    /// From the ball of the foot on.
    Toes,
    /// A bone of a finger: 0 the metacarpal (not of the thumb), 1 to 3 from the knuckle on, 4 the tip.
    Finger(Finger, u8),
}

/// What a name says.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct BodyPart {
    /// Its side, where there are two.
    pub side: Option<Side>,
    /// What it is.
    pub part: Part,
}

/// A name in lower-case words: at separators, digits and capitals; what stands before `:` or `|` is a
/// namespace and left out.
fn words(name: &str) -> Vec<String> {
    let name = name.rsplit([':', '|']).next().unwrap_or(name);
    let chars: Vec<char> = name.chars().collect();
    let mut words = vec![String::new()];
    for (i, c) in chars.iter().enumerate() {
        if !c.is_alphanumeric() {
            words.push(String::new());
            continue;
        }
        let before = i.checked_sub(1).map(|i| chars[i]);
        let capital = c.is_uppercase()
            && (before.is_some_and(char::is_lowercase)
                || chars.get(i + 1).is_some_and(|next| next.is_lowercase()));
        let digit = before.is_some_and(|b| b.is_ascii_digit() != c.is_ascii_digit());
        if capital || digit {
            words.push(String::new());
        }
        if let Some(word) = words.last_mut() {
            word.extend(c.to_lowercase());
        }
    }
    words.retain(|w| !w.is_empty());
    words
}

/// The name without what separates its words, in lower case: `Left_Up-Leg` and `leftUpLeg` are alike.
pub fn plain_name(name: &str) -> String {
    words(name).concat()
}

/// A name taken apart: side, number, and the words that are left.
#[derive(Debug, Default)]
struct Spelling {
    side: Option<Side>,
    number: Option<u8>,
    finger: Option<Finger>,
    core: String,
}

/// Words that say nothing about what a bone is.
const NOISE: [&str; 12] = [
    "mixamorig",
    "bip",
    "def",
    "org",
    "j",
    "c",
    "bone",
    "valve",
    "biped",
    "cc",
    "sk",
    "smplx",
];

impl Spelling {
    fn of(name: &str) -> Self {
        let mut spelling = Self::default();
        let mut after_biped = false;
        for word in words(name) {
            let word = word.as_str();
            match word {
                "l" | "left" => spelling.side = Some(Side::Left),
                "r" | "right" => spelling.side = Some(Side::Right),
                "thumb" => spelling.finger = Some(Finger::Thumb),
                "index" => spelling.finger = Some(Finger::Index),
                "middle" | "mid" => spelling.finger = Some(Finger::Middle),
                "ring" => spelling.finger = Some(Finger::Ring),
                "pinky" | "little" => spelling.finger = Some(Finger::Little),
                _ => {
                    if let Ok(number) = word.parse() {
                        // `Bip01`: the biped's number, not the bone's.
                        if !after_biped {
                            spelling.number = Some(number);
                        }
                    } else if !NOISE.contains(&word) {
                        spelling.core.push_str(word);
                    }
                }
            }
            after_biped = word == "bip";
        }
        spelling
    }

    /// A finger's bone. `metacarpal_thumb`: the skeleton calls the thumb's first bone so.
    fn finger(&self, finger: Finger, metacarpal_thumb: bool) -> Option<Part> {
        let core = ["hand", "finger", "phalanx"]
            .iter()
            .fold(self.core.clone(), |core, word| core.replace(word, ""));
        let thumb = finger == Finger::Thumb;
        let level = match core.as_str() {
            "" => self.number.filter(|n| (1..=4).contains(n))?,
            "metacarpal" | "meta" | "in" => u8::from(thumb),
            "proximal" => 1 + u8::from(thumb && metacarpal_thumb),
            "intermediate" => 2,
            "distal" => 3,
            "tip" => 4,
            _ => return None,
        };
        Some(Part::Finger(finger, level))
    }
}

/// What the bones of `skeleton` are: its aliases (a VRM file's own word for it) go before its names.
pub fn skeleton_parts(skeleton: &Skeleton) -> Vec<Option<BodyPart>> {
    let mut parts = body_parts(&skeleton.names);
    let aliases: Vec<String> = skeleton.aliases.iter().map(|a| a.0.clone()).collect();
    for ((_, bone), part) in skeleton.aliases.iter().zip(body_parts(&aliases)) {
        if let (Some(slot), Some(part)) = (parts.get_mut(*bone as usize), part) {
            *slot = Some(part);
        }
    }
    parts
}

/// What each of a skeleton's bones is; `None` where the name does not tell. Names are judged together,
/// for some mean different bones in different conventions: SMPL's `left_shoulder` is Mixamo's `LeftArm`,
/// and Mixamo's `LeftShoulder` is SMPL's `left_collar`.
pub fn body_parts(names: &[String]) -> Vec<Option<BodyPart>> {
    let spellings: Vec<Spelling> = names.iter().map(|n| Spelling::of(n)).collect();
    let has = |cores: &[&str]| {
        let mut all = spellings.iter();
        all.any(|s| s.side.is_some() && cores.contains(&s.core.as_str()))
    };
    let collars = has(&["collar", "clavicle"]);
    let ankles = has(&["ankle"]);
    let wrists = has(&["wrist"]);
    let metacarpal_thumb = spellings
        .iter()
        .any(|s| s.finger == Some(Finger::Thumb) && s.core.contains("metacarpal"));
    let part = |s: &Spelling| {
        if let Some(finger) = s.finger {
            return s.finger(finger, metacarpal_thumb);
        }
        let central = match s.core.as_str() {
            "pelvis" | "hips" => Some(Part::Hips),
            "hip" if s.side.is_none() => Some(Part::Hips),
            "spine" | "lowerback" | "chest" | "upperchest" | "torso" | "abdomen" => {
                Some(Part::Spine)
            }
            "neck" => Some(Part::Neck),
            "head" => Some(Part::Head),
            // A hand alone has no sides.
            "wrist" => Some(Part::Hand),
            "hand" if !wrists => Some(Part::Hand),
            _ => None,
        };
        if central.is_some() {
            return central;
        }
        s.side?;
        Some(match s.core.as_str() {
            "collar" | "clavicle" => Part::Collar,
            "shoulder" | "shldr" if collars => Part::UpperArm,
            "shoulder" => Part::Collar,
            "upperarm" | "uparm" | "arm" => Part::UpperArm,
            "forearm" | "lowerarm" | "lowarm" | "elbow" => Part::LowerArm,
            "upperleg" | "upleg" | "thigh" | "hip" => Part::UpperLeg,
            "lowerleg" | "lowleg" | "leg" | "calf" | "shin" | "knee" => Part::LowerLeg,
            "ankle" => Part::Foot,
            "foot" if ankles => Part::Toes,
            "foot" => Part::Foot,
            "toe" | "toes" | "toebase" | "ball" => Part::Toes,
            _ => return None,
        })
    };
    let sided = |s: &Spelling| {
        let part = part(s)?;
        Some(BodyPart { side: s.side, part })
    };
    spellings.iter().map(sided).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The same bones as six conventions call them.
    const BODIES: [[&str; 12]; 6] = [
        [
            "pelvis",
            "spine1",
            "neck",
            "head",
            "left_collar",
            "left_shoulder",
            "left_elbow",
            "right_wrist",
            "left_hip",
            "right_knee",
            "left_ankle",
            "right_foot",
        ],
        [
            "Hips",
            "LowerBack",
            "Neck1",
            "Head",
            "LeftShoulder",
            "LeftArm",
            "LeftForeArm",
            "RightHand",
            "LeftUpLeg",
            "RightLeg",
            "LeftFoot",
            "RightToeBase",
        ],
        [
            "mixamorig:Hips",
            "mixamorig:Spine2",
            "mixamorig:Neck",
            "mixamorig:Head",
            "mixamorig:LeftShoulder",
            "mixamorig:LeftArm",
            "mixamorig:LeftForeArm",
            "mixamorig:RightHand",
            "mixamorig:LeftUpLeg",
            "mixamorig:RightLeg",
            "mixamorig:LeftFoot",
            "mixamorig:RightToeBase",
        ],
        [
            "pelvis",
            "spine_01",
            "neck_01",
            "head",
            "clavicle_l",
            "upperarm_l",
            "lowerarm_l",
            "hand_r",
            "thigh_l",
            "calf_r",
            "foot_l",
            "ball_r",
        ],
        [
            "hips",
            "upperChest",
            "neck",
            "head",
            "leftShoulder",
            "leftUpperArm",
            "leftLowerArm",
            "rightHand",
            "leftUpperLeg",
            "rightLowerLeg",
            "leftFoot",
            "rightToes",
        ],
        [
            "Bip01 Pelvis",
            "Bip01 Spine1",
            "Bip01 Neck",
            "Bip01 Head",
            "Bip01 L Clavicle",
            "Bip01 L UpperArm",
            "Bip01 L Forearm",
            "Bip01 R Hand",
            "Bip01 L Thigh",
            "Bip01 R Calf",
            "Bip01 L Foot",
            "Bip01 R Toe0",
        ],
    ];

    fn parts(names: &[&str]) -> Vec<Option<BodyPart>> {
        let names: Vec<String> = names.iter().map(ToString::to_string).collect();
        body_parts(&names)
    }

    #[test]
    fn conventions_agree() {
        let smpl = parts(&BODIES[0]);
        assert!(smpl.iter().all(Option::is_some));
        let side = Some(Side::Left);
        let part = Part::UpperArm;
        assert_eq!(smpl[5], Some(BodyPart { side, part }));
        for body in &BODIES[1..] {
            assert_eq!(parts(body), smpl, "{body:?}");
        }
    }

    #[test]
    fn fingers_agree() {
        let index = parts(&[
            "index1", "index2", "index3", "thumb1", "thumb2", "thumb3", "wrist",
        ]);
        let webxr = parts(&[
            "index-finger-phalanx-proximal",
            "index-finger-phalanx-intermediate",
            "index-finger-phalanx-distal",
            "thumb-metacarpal",
            "thumb-phalanx-proximal",
            "thumb-phalanx-distal",
            "wrist",
        ]);
        assert!(index.iter().all(Option::is_some));
        assert_eq!(index, webxr);
        let left = parts(&["left_index2", "left_thumb1", "left_wrist"]);
        assert_eq!(
            left,
            parts(&["LeftHandIndex2", "LeftHandThumb1", "LeftHand"])
        );
        assert_eq!(left, parts(&["index_02_l", "thumb_01_l", "hand_l"]));
        assert_eq!(
            left,
            parts(&["leftIndexIntermediate", "leftThumbProximal", "leftHand"])
        );
    }

    #[test]
    fn what_says_nothing_is_nothing() {
        for name in [
            "LHipJoint",
            "Cesium_Man",
            "",
            "::",
            "tail",
            "HeadTop_End",
            "42",
        ] {
            assert_eq!(parts(&[name]), [None], "{name}");
        }
    }
}
