//! Rotations of bones from places of joints.

use glam::{DMat3, DQuat, DVec3};
use supple::internal::math::singular_values;
use supple::model::Skeleton;

/// How a bone's rotation is found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Rule {
    /// From where its children are.
    Directions,
    /// As its parent's; I for a root.
    Inherit,
    /// As at rest.
    Rest,
}

/// What is seen of one bone.
#[derive(Clone, Copy, Debug)]
pub(super) struct Seen {
    /// Its joint's place.
    pub place: Option<DVec3>,
    /// The place of what follows a bone that has no child: a finger's tip.
    pub end: Option<DVec3>,
    /// How it is turned.
    pub rule: Rule,
}

/// A joint nearer to its parent's has no direction from there (CMU's fingers lie in the wrist), m.
const SHORTEST: f64 = 1e-4;

/// World rotations (away from the bind pose) of `skeleton`'s bones that bring its joints' directions to
/// those seen. A bone with several children, not all in one line, is turned as they fit best; one with a
/// single child turns with its parent and then by the smallest angle; any other turns with its parent.
pub(super) fn fit_rotations(skeleton: &Skeleton, seen: &[Seen]) -> Vec<DMat3> {
    let children = seen_children(skeleton, seen);
    let mut rotations: Vec<DMat3> = Vec::with_capacity(skeleton.len());
    for (j, bone) in seen.iter().enumerate() {
        let parent = skeleton.parents[j].map(|p| p as usize);
        let inherited = parent.map_or(DMat3::IDENTITY, |p| rotations[p]);
        let joint = skeleton.joints[j];
        let rotation = match (bone.rule, bone.place) {
            (Rule::Rest, _) => DMat3::IDENTITY,
            (Rule::Directions, Some(place)) => {
                let mut pairs: Vec<(DVec3, DVec3)> = children[j]
                    .iter()
                    .filter_map(|&c| Some((skeleton.joints[c] - joint, seen[c].place? - place)))
                    .filter(|(rest, now)| rest.length() > SHORTEST && now.length() > SHORTEST)
                    .collect();
                if let ([], Some(end), Some(p)) = (&pairs[..], bone.end, parent) {
                    // At rest the tip goes on as its bone's parent does.
                    pairs.push((joint - skeleton.joints[p], end - place));
                }
                match pairs[..] {
                    [(rest, now)] => swing(inherited * rest, now) * inherited,
                    _ => best_rotation(&pairs).unwrap_or(inherited),
                }
            }
            _ => inherited,
        };
        rotations.push(rotation);
    }
    rotations
}

/// The nearest bones below each that are seen.
fn seen_children(skeleton: &Skeleton, seen: &[Seen]) -> Vec<Vec<usize>> {
    let mut children = vec![Vec::new(); skeleton.len()];
    for j in (0..skeleton.len()).filter(|&j| seen[j].place.is_some()) {
        let mut above = skeleton.parents[j];
        while let Some(p) = above {
            if seen[p as usize].place.is_some() {
                children[p as usize].push(j);
                break;
            }
            above = skeleton.parents[p as usize];
        }
    }
    children
}

/// The smallest rotation that takes the direction of `from` to that of `to`; I where one has none.
pub(super) fn swing(from: DVec3, to: DVec3) -> DMat3 {
    match (from.try_normalize(), to.try_normalize()) {
        (Some(from), Some(to)) => DMat3::from_quat(DQuat::from_rotation_arc(from, to)),
        _ => DMat3::IDENTITY,
    }
}

/// The rotation R that maximises Σ to · R from (Kabsch 1976): R = U Vᵀ of Σ to fromᵀ = U Σ Vᵀ. `None`
/// where the vectors leave it undetermined: all in one line.
pub(super) fn best_rotation(pairs: &[(DVec3, DVec3)]) -> Option<DMat3> {
    let outer =
        |(from, to): &(DVec3, DVec3)| DMat3::from_cols(*to * from.x, *to * from.y, *to * from.z);
    let correlation = pairs.iter().map(outer).fold(DMat3::ZERO, |a, b| a + b);
    let s = singular_values(correlation);
    // An angle about the first axis is determined by σ₁ + σ₂ (signed).
    (s.sigma.y + s.sigma.z > 1e-4 * s.sigma.x).then(|| s.u * s.v.transpose())
}

/// The nearest of the 24 rotations that take axes to axes, if it is within 30° of `r`.
pub(super) fn snapped(r: DMat3) -> DMat3 {
    let axes = [
        DVec3::X,
        -DVec3::X,
        DVec3::Y,
        -DVec3::Y,
        DVec3::Z,
        -DVec3::Z,
    ];
    let nearest = |v: DVec3| {
        let mut best = axes[0];
        for a in axes {
            if a.dot(v) > best.dot(v) {
                best = a;
            }
        }
        best
    };
    let (x, y) = (nearest(r.x_axis), nearest(r.y_axis));
    let candidate = DMat3::from_cols(x, y, x.cross(y));
    let product = candidate.transpose() * r;
    let cosine = 0.5 * (product.x_axis.x + product.y_axis.y + product.z_axis.z - 1.0);
    if x.dot(y) == 0.0 && cosine > 30f64.to_radians().cos() {
        candidate
    } else {
        r
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use supple::internal::math::{Random, rotation_exp};

    fn near(a: DMat3, b: DMat3) -> f64 {
        (a - b)
            .to_cols_array()
            .iter()
            .fold(0.0, |m: f64, d| m.max(d.abs()))
    }

    /// Chain, fork and leaf: from places alone, every rotation but the twist of a single bone.
    #[test]
    fn rotations_are_found_from_places() {
        let skeleton = Skeleton {
            aliases: Vec::new(),
            limits: Vec::new(),
            names: ["hand", "a1", "a2", "b1", "c1"].map(Into::into).to_vec(),
            parents: vec![None, Some(0), Some(1), Some(0), Some(0)],
            joints: vec![
                DVec3::new(0.1, 0.2, 0.3),
                DVec3::new(0.2, 0.2, 0.3),
                DVec3::new(0.25, 0.22, 0.3),
                DVec3::new(0.19, 0.24, 0.31),
                DVec3::new(0.18, 0.16, 0.33),
            ],
        };
        let hand = rotation_exp(DVec3::new(0.4, -1.2, 2.0));
        // No twist about the bone: it is not seen.
        let bend = rotation_exp(DVec3::new(0.05, 0.02, 0.0).cross(DVec3::Z) * 9.0);
        let local = [
            hand,
            bend,
            DMat3::IDENTITY,
            DMat3::IDENTITY,
            DMat3::IDENTITY,
        ];
        let frames = skeleton.forward_kinematics(&local, DVec3::new(1.0, 2.0, 3.0));
        let seen: Vec<Seen> = (frames.iter())
            .map(|f| Seen {
                place: Some(f.position),
                end: None,
                rule: Rule::Directions,
            })
            .collect();
        let fitted = fit_rotations(&skeleton, &seen);
        for j in 0..3 {
            assert!(near(fitted[j], frames[j].rotation) < 1e-12, "bone {j}");
        }
    }

    #[test]
    fn a_line_does_not_determine_a_rotation() {
        let along = |t: f64| (DVec3::X * t, DVec3::Y * t);
        assert!(best_rotation(&[along(1.0), along(-2.0)]).is_none());
        assert!(best_rotation(&[]).is_none());
        assert!(best_rotation(&[along(1.0), (DVec3::Y, -DVec3::X)]).is_some());
    }

    #[test]
    fn rotations_near_the_axes_snap_to_them() {
        let mut random = Random::new(7);
        let mut tilt = || {
            let mut x = || random.uniform(-0.25, 0.25);
            rotation_exp(DVec3::new(x(), x(), x()))
        };
        let turn = rotation_exp(DVec3::X * std::f64::consts::FRAC_PI_2);
        for _ in 0..20 {
            assert!(near(snapped(tilt() * turn), turn) < 1e-15);
        }
        let far = rotation_exp(DVec3::Z * 0.7);
        assert_eq!(snapped(far), far);
    }
}
