//! Places and rotations between recorded ones, at an even velocity through each of them.
//!
//! From b to c the curve is the cubic Bézier with control points b, b + ḃ/3, c − ċ/3, c, where ḃ = (c − a)/2 for the neighbour
//! a on the other side, and c − b at an end (Catmull and Rom 1974). Rotations have the same by great arcs in place of lines
//! (Shoemake 1985), with ḃ the mean of the rotation vectors of both sides.

use glam::{DQuat, DVec3};

/// The place `part` (0 to 1) of the way from the second of four to the third; the outer two may be missing.
pub fn place([before, from, to, after]: [Option<DVec3>; 4], part: f64) -> DVec3 {
    let (Some(from), Some(to)) = (from, to) else {
        return from.or(to).unwrap_or_default();
    };
    let chord = to - from;
    let leaving = before.map_or(chord, |before| 0.5 * (to - before));
    let arriving = after.map_or(chord, |after| 0.5 * (after - from));
    let controls = [from, from + leaving / 3.0, to - arriving / 3.0, to];
    bezier(controls, |a, b| a.lerp(b, part))
}

/// [`place`] of unit rotations.
pub fn rotation([before, from, to, after]: [Option<DQuat>; 4], part: f64) -> DQuat {
    let (Some(from), Some(to)) = (from, to) else {
        return from.or(to).unwrap_or_default();
    };
    let chord = turn(from, to);
    let leaving = before.map_or(chord, |before| 0.5 * (turn(before, from) + chord));
    let arriving = after.map_or(chord, |after| 0.5 * (chord + turn(to, after)));
    let controls = [
        from,
        from * DQuat::from_scaled_axis(leaving / 3.0),
        to * DQuat::from_scaled_axis(arriving / -3.0),
        to,
    ];
    bezier(controls, |a, b| a.slerp(b, part)).normalize()
}

/// De Casteljau's algorithm.
fn bezier<T: Copy>([a, b, c, d]: [T; 4], between: impl Fn(T, T) -> T) -> T {
    let (ab, bc, cd) = (between(a, b), between(b, c), between(c, d));
    between(between(ab, bc), between(bc, cd))
}

/// The rotation vector from `a` to `b` along the shorter arc, in axes of `a`.
fn turn(a: DQuat, b: DQuat) -> DVec3 {
    let between = a.inverse() * b;
    let shorter = if between.w < 0.0 { -between } else { between };
    shorter.to_scaled_axis()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What moves and turns evenly is met exactly, through an end too, whatever the signs of the quaternions.
    #[test]
    fn even_motion_is_met_exactly() {
        let axis = DVec3::new(0.6, 0.0, 0.8);
        let at = |t: f64| (DVec3::X * t, DQuat::from_axis_angle(axis, 0.7 * t));
        for missing in [None, Some(0), Some(3)] {
            let present = |k: usize| missing != Some(k);
            let places = [0, 1, 2, 3].map(|k| present(k).then(|| at(k as f64 - 1.0).0));
            let turns = [0, 1, 2, 3].map(|k| {
                let sign = if k % 2 == 0 { -1.0 } else { 1.0 };
                present(k).then(|| at(k as f64 - 1.0).1 * sign)
            });
            for u in [0.0, 0.3, 0.5, 1.0] {
                let (x, q) = at(u);
                assert!(place(places, u).distance(x) < 1e-15);
                assert!(turn(rotation(turns, u), q).length() < 1e-14);
            }
        }
    }

    /// Velocities are the same on both sides of a frame, of a walk's knee as of a place: along chords they jump.
    #[test]
    fn velocities_are_continuous() {
        let angles = [0.1, 0.5, 1.2, 0.9, 0.2];
        let places = angles.map(|a: f64| DVec3::new(a, a * a, 0.0));
        let turns = angles.map(|a| DQuat::from_euler(glam::EulerRot::XYZ, a, 0.3 * a * a, -a));
        let four = |i: usize| [i, i + 1, i + 2, i + 3].map(|k| Some(places[k]));
        let of_turns = |i: usize| [i, i + 1, i + 2, i + 3].map(|k| Some(turns[k]));
        const EPS: f64 = 1e-6;
        let before = (place(four(0), 1.0) - place(four(0), 1.0 - EPS)) / EPS;
        let after = (place(four(1), EPS) - place(four(1), 0.0)) / EPS;
        assert!(before.distance(after) < 1e-5);
        assert!((places[2] - places[1]).distance(places[3] - places[2]) > 0.5);
        let before = turn(rotation(of_turns(0), 1.0 - EPS), turns[2]) / EPS;
        let after = turn(turns[2], rotation(of_turns(1), EPS)) / EPS;
        assert!(before.distance(after) < 1e-5, "{before} {after}");
    }
}
