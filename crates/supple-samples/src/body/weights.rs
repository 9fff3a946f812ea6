//! Skin weights: which bone carries each place of the skin, and heat that blends them.

use super::anatomy::{self, BONES, mirrored_bone};
use super::leg::foot_axes;
use super::shape::BodyShape;
use super::skin::Skin;
use crate::field::smoothstep;
use crate::heat_weights::heat_weights;
use glam::DVec3;
use supple::Result;
use supple::internal::math::Rows;
use supple::model::SkinWeight;

/// SMPL's numbers of the bones of the midline and of the left side.
const PELVIS: usize = 0;
const HIP: usize = 1;
const SPINE: [usize; 3] = [3, 6, 9];
const KNEE: usize = 4;
const ANKLE: usize = 7;
const FOOT: usize = 10;
const NECK: usize = 12;
const COLLAR: usize = 13;
const HEAD: usize = 15;
const SHOULDER: usize = 16;
const ELBOW: usize = 18;
const WRIST: usize = 20;
const HAND: usize = 22;

/// Across this width at the fork one leg's weights give way to the other's, mm.
const FORK: f64 = 44.0;

/// The bone that carries a place with x ≥ 0, and the radius of the blend there (mm).
fn segment(shape: &BodyShape, joints: &[DVec3], p: DVec3) -> (usize, f64) {
    let station = anatomy::arm().local(p).x;
    // The folds of the armpit belong to the chest.
    let begin = -8.0 + 0.35 * (joints[SHOULDER].y - p.y).clamp(0.0, 70.0);
    if station > begin && p.y > 1230.0 {
        return of_arm(shape, station, p);
    }
    // The neck begins higher at its back and towards the shoulders, the head under chin and skull.
    let neck = joints[NECK].y - 0.35 * (p.z - joints[NECK].z) + 0.8 * (p.x - 45.0).max(0.0);
    let head = joints[HEAD].y - 0.55 * (p.z - joints[HEAD].z);
    if p.y > neck {
        return (if p.y > head { HEAD } else { NECK }, 19.0);
    }
    // The groin rises outward, less so at the buttock.
    let front = smoothstep((p.z + 50.0) / 80.0);
    let groin = 822.0 + (0.42 + 0.24 * front) * p.x;
    if p.y < groin {
        return of_leg(joints, p);
    }
    if p.y > 1345.0 + 0.5 * (110.0 - p.x) && p.x > 40.0 {
        return (COLLAR, 36.0);
    }
    let above = SPINE.iter().rev().find(|&&j| p.y > joints[j].y);
    (above.copied().unwrap_or(PELVIS), 40.0)
}

fn of_arm(shape: &BodyShape, station: f64, p: DVec3) -> (usize, f64) {
    let [elbow, wrist, fingers] = anatomy::arm_stations();
    let fall = |from: f64, to: f64, t: f64| from + (to - from) * smoothstep(t);
    let radius = fall(38.0, 22.0, station / 160.0);
    let radius = fall(radius, 15.0, (station - elbow - 60.0) / 120.0);
    let radius = fall(radius, 8.0, (station - wrist - 20.0) / 40.0);
    let bone = if station > fingers && !shape.arm.is_thumb(p) {
        HAND
    } else if station > wrist {
        WRIST
    } else if station > elbow {
        ELBOW
    } else {
        SHOULDER
    };
    (bone, radius)
}

fn of_leg(joints: &[DVec3], p: DVec3) -> (usize, f64) {
    let fall = |from: f64, to: f64, t: f64| from + (to - from) * smoothstep(t);
    let toes = foot_axes().local(joints[FOOT]).x;
    let radius = fall(38.0, 27.0, (780.0 - p.y) / 150.0);
    let radius = fall(radius, 16.0, (380.0 - p.y) / 200.0);
    if p.y > joints[KNEE].y {
        (HIP, radius)
    } else if p.y > joints[ANKLE].y + 0.25 * (p.z - joints[ANKLE].z) {
        (KNEE, radius)
    } else if foot_axes().local(p).x > toes {
        (FOOT, 10.0)
    } else {
        (ANKLE, fall(10.0, radius, (p.y - 30.0) / 30.0))
    }
}

/// At most four bones for each vertex, with Σ w = 1; a vertex and its twin have each other's.
pub(super) fn weights(
    shape: &BodyShape,
    joints: &[DVec3],
    skin: &Skin,
) -> Result<Rows<SkinWeight>> {
    let (bone, radius): (Vec<usize>, Vec<f64>) = (skin.surface.positions.iter())
        .map(|&p| {
            let (bone, radius) = segment(shape, joints, DVec3::new(p.x.abs(), p.y, p.z));
            let bone = if p.x < 0.0 { mirrored_bone(bone) } else { bone };
            (bone, radius)
        })
        .unzip();
    let rows = heat_weights(&skin.surface, BONES, &bone, &radius)?;
    Ok((0..rows.len())
        .map(|v| symmetric_row(&rows, skin, v))
        .collect())
}

/// The mean of a vertex's row and its twin's, which differ by rounding only. Heat that came from one leg
/// to the other across the fork goes to the pelvis.
fn symmetric_row(rows: &Rows<SkinWeight>, skin: &Skin, v: usize) -> Vec<SkinWeight> {
    let of_bone = |v: usize, bone: usize| {
        let row = rows.row(v).iter();
        row.filter(|w| w.bone as usize == bone)
            .map(|w| w.weight)
            .sum::<f64>()
    };
    let twin = skin.twin[v] as usize;
    let mut row: Vec<f64> = (0..BONES)
        .map(|bone| 0.5 * (of_bone(v, bone) + of_bone(twin, mirrored_bone(bone))))
        .collect();
    let left = smoothstep(0.5 + skin.surface.positions[v].x / FORK);
    for (bone, share) in [(HIP, left), (mirrored_bone(HIP), 1.0 - left)] {
        row[PELVIS] += (1.0 - share) * row[bone];
        row[bone] *= share;
    }
    let row = row.into_iter().zip(0..);
    row.filter(|(weight, _)| *weight > 0.0)
        .map(|(weight, bone)| SkinWeight { bone, weight })
        .collect()
}
