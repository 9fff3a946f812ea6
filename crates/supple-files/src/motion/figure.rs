//! Whether a rest pose is a figure: a person that stands in it.

use glam::DVec3;
use supple_bake::{BodyPart, Part, Side, body_parts};

/// Greatest cosine between a leg and the trunk: legs go the other way, or at least aside.
const LEG: f64 = 0.25;
/// Greatest cosine between an arm and the trunk: arms hang, are held out, or rise a little.
const ARM: f64 = 0.9;

/// Whether somebody could stand as these `joints` are. Where local axes lie along the bones (x in many recorders'
/// files), turning no bone lays all of them in a line: legs point the way of the spine. What has no spine or limbs
/// by name is taken for a figure.
pub(crate) fn is_figure(names: &[String], joints: &[DVec3]) -> bool {
    let parts = body_parts(names);
    let first = |side: Option<Side>, part: Part| {
        let wanted = Some(BodyPart { side, part });
        let at = parts.iter().position(|p| *p == wanted)?;
        joints.get(at).copied()
    };
    let last = |part: Part| {
        let at = parts
            .iter()
            .rposition(|p| p.is_some_and(|p| p.part == part))?;
        joints.get(at).copied()
    };
    let pelvis = first(None, Part::Hips).or_else(|| first(None, Part::Spine));
    let top = [Part::Head, Part::Neck, Part::Spine]
        .into_iter()
        .find_map(last);
    let Some(trunk) = pelvis.zip(top).map(|(low, high)| high - low) else {
        return true;
    };
    let stands = |side: Side, from: Part, to: Part, most: f64| {
        let ends = first(Some(side), from).zip(first(Some(side), to));
        let Some(limb) = ends.map(|(from, to)| to - from) else {
            return true;
        };
        // No length has no direction: all offsets are channels.
        match (limb.try_normalize(), trunk.try_normalize()) {
            (Some(limb), Some(trunk)) => limb.dot(trunk) < most,
            _ => false,
        }
    };
    [Side::Left, Side::Right].into_iter().all(|side| {
        stands(side, Part::UpperLeg, Part::Foot, LEG)
            && stands(side, Part::UpperArm, Part::Hand, ARM)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::smpl::{BODY, rest_joint};

    /// SMPL's T pose, with the offset of every joint beyond the first of its limb changed.
    fn pose(change: impl Fn(&str, DVec3) -> DVec3) -> bool {
        let names: Vec<String> = BODY.iter().map(|(name, _)| name.to_string()).collect();
        let mut joints: Vec<DVec3> = Vec::new();
        for (name, parent) in BODY {
            let rest = |name: &str| rest_joint(name).unwrap();
            joints.push(match parent.map(|p| p as usize) {
                None => DVec3::ZERO,
                Some(p) => joints[p] + change(name, rest(name) - rest(BODY[p].0)),
            });
        }
        is_figure(&names, &joints)
    }

    #[test]
    fn people_stand_and_lines_do_not() {
        assert!(pose(|_, offset| offset), "T pose");
        assert!(pose(|_, v| DVec3::new(v.z, v.x, v.y)), "z up, facing x");
        let arms = |name: &str| name.contains("elbow") || name.contains("wrist");
        let hanging = |name: &str, v: DVec3| match arms(name) {
            true => -DVec3::Y * v.length(),
            false => v,
        };
        assert!(pose(hanging), "arms down");
        for axis in [DVec3::X, DVec3::Y, -DVec3::Z] {
            assert!(!pose(|_, v| axis * v.length()), "along {axis}");
        }
        let mirrored = |name: &str, v: DVec3| match name.starts_with("right") {
            true => -DVec3::X * v.length(),
            false => DVec3::X * v.length(),
        };
        assert!(!pose(mirrored), "sides along x and −x");
        assert!(!pose(|_, _| DVec3::ZERO), "offsets in channels");
    }

    #[test]
    fn what_has_no_limbs_is_taken_for_a_figure() {
        assert!(is_figure(&["a".into(), "b".into()], &[DVec3::ZERO; 2]));
    }
}
