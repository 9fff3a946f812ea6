//! SMPL's joint tree, for poses that come without a model.

use glam::DVec3;

/// Name and parent of SMPL's 24 joints, in its order; SMPL-H and SMPL-X share the first 22.
pub const BODY: [(&str, Option<u32>); 24] = [
    ("pelvis", None),
    ("left_hip", Some(0)),
    ("right_hip", Some(0)),
    ("spine1", Some(0)),
    ("left_knee", Some(1)),
    ("right_knee", Some(2)),
    ("spine2", Some(3)),
    ("left_ankle", Some(4)),
    ("right_ankle", Some(5)),
    ("spine3", Some(6)),
    ("left_foot", Some(7)),
    ("right_foot", Some(8)),
    ("neck", Some(9)),
    ("left_collar", Some(9)),
    ("right_collar", Some(9)),
    ("head", Some(12)),
    ("left_shoulder", Some(13)),
    ("right_shoulder", Some(14)),
    ("left_elbow", Some(16)),
    ("right_elbow", Some(17)),
    ("left_wrist", Some(18)),
    ("right_wrist", Some(19)),
    ("left_hand", Some(20)),
    ("right_hand", Some(21)),
];

/// MANO's fingers, in its order; each has three joints.
pub const FINGERS: [&str; 5] = ["index", "middle", "pinky", "ring", "thumb"];

/// Where a joint of SMPL's T pose is in a person of 1.7 m, to a few centimetres; the pelvis at the origin,
/// y up, facing z. For skeletons whose rest pose is another, and whose size must be compared.
pub fn rest_joint(name: &str) -> Option<DVec3> {
    if let Some(right) = name.strip_prefix("right_") {
        let left = rest_joint(&format!("left_{right}"))?;
        return Some(DVec3::new(-left.x, left.y, left.z));
    }
    const WRIST: DVec3 = DVec3::new(0.67, 0.44, -0.03);
    let centimetres = |x: f64, y: f64, z: f64| 0.01 * DVec3::new(x, y, z);
    Some(match name {
        "pelvis" => DVec3::ZERO,
        "spine1" => centimetres(0.0, 11.0, -2.0),
        "spine2" => centimetres(0.0, 24.0, -1.0),
        "spine3" => centimetres(0.0, 30.0, 1.0),
        "neck" => centimetres(0.0, 51.0, -2.0),
        "head" => centimetres(0.0, 60.0, 2.0),
        "left_hip" => centimetres(6.0, -9.0, 0.0),
        "left_knee" => centimetres(9.0, -47.0, 0.0),
        "left_ankle" => centimetres(8.0, -88.0, -3.0),
        "left_foot" => centimetres(11.0, -94.0, 9.0),
        "left_collar" => centimetres(7.0, 42.0, -2.0),
        "left_shoulder" => centimetres(17.0, 44.0, -3.0),
        "left_elbow" => centimetres(43.0, 44.0, -4.0),
        "left_wrist" => WRIST,
        "left_hand" => WRIST + centimetres(8.0, -1.0, 0.0),
        _ => {
            let bone = name.strip_prefix("left_")?;
            let (finger, number) = bone.split_at_checked(bone.len().checked_sub(1)?)?;
            let (knuckle, along) = match finger {
                "index" => (centimetres(9.5, -0.5, 2.5), centimetres(2.8, -0.3, 0.3)),
                "middle" => (centimetres(10.0, 0.0, 0.0), centimetres(3.0, -0.3, -0.2)),
                "ring" => (centimetres(9.0, -0.3, -2.2), centimetres(2.8, -0.4, -0.4)),
                "pinky" => (centimetres(7.8, -0.8, -4.0), centimetres(1.9, -0.3, -0.6)),
                "thumb" => (centimetres(2.5, -1.5, 2.8), centimetres(2.6, -0.8, 2.0)),
                _ => return None,
            };
            WRIST + knuckle + along * (number.parse::<u8>().ok()?.checked_sub(1)? as f64)
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_joint_has_a_place_and_sides_mirror() {
        for (name, _) in BODY {
            assert!(rest_joint(name).is_some(), "{name}");
        }
        for finger in FINGERS {
            for k in 1..=3 {
                let side = |side: &str| rest_joint(&format!("{side}_{finger}{k}")).unwrap();
                assert_eq!(side("left") * DVec3::new(-1.0, 1.0, 1.0), side("right"));
                assert!(side("left").x > 0.67, "{finger}{k}");
            }
        }
        for name in [
            "jaw",
            "left_",
            "left_index",
            "left_indexx",
            "left_thumb0",
            "é",
            "left_é",
        ] {
            assert_eq!(rest_joint(name), None, "{name}");
        }
    }
}
