//! A walk made by the crate itself: SMPL's joint tree, two strides of a second each.
//!
//! Feet are led, and legs follow: a foot comes down on its heel, stands flat, rolls over its ball and swings
//! on, so that what stands does not slide; hip and knee are where a leg of two bones must have them. The
//! pelvis sways over the standing leg, drops on the other side and turns with the leg that swings; the arms
//! and the chest turn against it. Proportions and angles are usual ones (Perry, *Gait Analysis*, 1992).

use glam::{DMat3, DQuat, DVec3};
use std::f64::consts::TAU;
use supple::internal::math::rotation_exp;
use supple::model::UpAxis;
use supple_files::motion::smpl::{BODY, rest_joint};
use supple_files::{MotionClip, MotionFrame};

/// Time of one stride (a step of each leg), s.
const STRIDE_TIME: f64 = 1.0;
/// Way of one stride, m.
const STRIDE: f64 = 1.2;
/// Strides of the clip.
const STRIDES: usize = 2;
/// Frames a stride.
const FRAMES: usize = 30;

/// Parts of the stride, from a heel's strike: flat on the ground, heel off, toe off.
const FLAT: f64 = 0.08;
const HEEL_OFF: f64 = 0.36;
const TOE_OFF: f64 = 0.62;

/// From the ankle, foot flat: where the heel and the ball touch the ground, m.
const HEEL: DVec3 = DVec3::new(0.0, -0.075, -0.05);
const BALL: DVec3 = DVec3::new(0.0, -0.075, 0.12);

/// The walk, along z, y up; its last pose is its first, two strides on.
pub fn walk() -> MotionClip {
    let rest: Vec<DVec3> = (BODY.iter())
        .map(|(name, _)| rest_joint(name).unwrap_or(DVec3::ZERO))
        .collect();
    let gait = Gait {
        pelvis_height: pelvis_height(&rest),
        rest: &rest,
    };
    let frame = |k: usize| gait.frame(k as f64 / FRAMES as f64);
    MotionClip {
        name: "walk".into(),
        bones: BODY.iter().map(|(name, _)| name.to_string()).collect(),
        parents: BODY.iter().map(|(_, parent)| *parent).collect(),
        frames: (0..=STRIDES * FRAMES).map(frame).collect(),
        rest_joints: Some(rest),
        rest_up: UpAxis::Y,
        world_up: UpAxis::Y,
        frame_time: STRIDE_TIME / FRAMES as f64,
        translated: vec![0],
        notes: Vec::new(),
    }
}

/// A leg's joints in [`BODY`].
struct Leg {
    hip: usize,
    knee: usize,
    ankle: usize,
    toes: usize,
    /// Part of the stride by which it is ahead of the left one.
    ahead: f64,
    /// +1 on the left.
    side: f64,
}

const LEGS: [Leg; 2] = [
    Leg {
        hip: 1,
        knee: 4,
        ankle: 7,
        toes: 10,
        ahead: 0.0,
        side: 1.0,
    },
    Leg {
        hip: 2,
        knee: 5,
        ankle: 8,
        toes: 11,
        ahead: 0.5,
        side: -1.0,
    },
];

/// The highest pelvis with which no leg is straighter than knees in a walk are.
fn pelvis_height(rest: &[DVec3]) -> f64 {
    const STRAIGHTEST: f64 = 0.992;
    let reached = |height: f64| {
        let gait = Gait {
            pelvis_height: height,
            rest,
        };
        (0..200).all(|k| {
            let time = f64::from(k) / 200.0;
            LEGS.iter().all(|leg| {
                let length = (rest[leg.knee] - rest[leg.hip]).length()
                    + (rest[leg.ankle] - rest[leg.knee]).length();
                (gait.hip(leg, time) - foot(leg, time).ankle).length() < STRAIGHTEST * length
            })
        })
    };
    let (mut low, mut high) = (0.5, 1.2);
    for _ in 0..40 {
        let middle = 0.5 * (low + high);
        if reached(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    low
}

/// Where a foot is.
struct Foot {
    ankle: DVec3,
    /// Toes up, rad.
    pitch: f64,
    /// How far toes are bent up against the foot, rad.
    toes: f64,
}

/// u² (3 − 2u) from 0 at `from` to 1 at `to`.
fn smooth(from: f64, to: f64, at: f64) -> f64 {
    let u = ((at - from) / (to - from)).clamp(0.0, 1.0);
    u * u * (3.0 - 2.0 * u)
}

/// Toes up, rad, at a part of the stride.
fn foot_pitch(phase: f64) -> f64 {
    const STRIKE: f64 = 0.32;
    const PUSH: f64 = -0.85;
    let down = STRIKE * (1.0 - smooth(0.0, FLAT, phase));
    let push =
        PUSH * (smooth(HEEL_OFF, TOE_OFF + 0.03, phase) - smooth(TOE_OFF + 0.03, 0.86, phase));
    down + push + STRIKE * smooth(0.78, 1.0, phase)
}

/// Foot of `leg` at `time`, in strides; the ground is y = 0.
fn foot(leg: &Leg, time: f64) -> Foot {
    let at = time + leg.ahead;
    let (stride, phase) = (at.floor(), at.fract());
    let pitch = foot_pitch(phase);
    // Standing, the foot's flat place under the hip half way through; x next to the body's middle.
    let middle = |stride: f64| {
        DVec3::new(
            0.075 * leg.side,
            0.0,
            STRIDE * (stride - leg.ahead + 0.27) - 0.03,
        )
    };
    let standing = |phase: f64| {
        let pitch = foot_pitch(phase);
        let pivot = if phase < HEEL_OFF { HEEL } else { BALL };
        middle(stride) - DVec3::Y * HEEL.y + pivot - tilt(pitch) * pivot
    };
    let ankle = if phase < TOE_OFF {
        standing(phase)
    } else {
        let duration = 1.0 - TOE_OFF;
        let u = (phase - TOE_OFF) / duration;
        let from = standing(TOE_OFF);
        let speed = (from - standing(TOE_OFF - 1e-4)) / 1e-4 * duration;
        let to = middle(stride + 1.0) - DVec3::Y * HEEL.y + HEEL - tilt(foot_pitch(0.0)) * HEEL;
        let hermite = from * (1.0 + 2.0 * u) * (1.0 - u).powi(2)
            + speed * u * (1.0 - u).powi(2)
            + to * u * u * (3.0 - 2.0 * u);
        let bump = (u * (1.0 - u)).powi(2) * 16.0;
        hermite + DVec3::Y * 0.04 * bump
    };
    let rolling = smooth(HEEL_OFF, TOE_OFF, phase) - smooth(TOE_OFF, 0.75, phase);
    Foot {
        ankle,
        pitch,
        toes: -pitch.min(0.0) * rolling,
    }
}

/// Turns about x so that toes go up by `pitch`.
fn tilt(pitch: f64) -> DMat3 {
    rotation_exp(DVec3::X * -pitch)
}

struct Gait<'a> {
    /// Of the pelvis's joint over the ground, on average, m.
    pelvis_height: f64,
    rest: &'a [DVec3],
}

impl Gait<'_> {
    /// Place and rotation of the pelvis at `time`, in strides.
    fn pelvis(&self, time: f64) -> (DVec3, DMat3) {
        let wave = |cycles: f64, at: f64| (TAU * cycles * (time - at)).cos();
        let place = DVec3::new(
            0.022 * wave(1.0, 0.32),
            self.pelvis_height + 0.016 * wave(2.0, 0.31),
            STRIDE * time + 0.01 * wave(2.0, 0.05),
        );
        // The left hip is ahead at the left strike, and the side of the leg that swings hangs.
        let (turn, drop, lean) = (-0.09 * wave(1.0, 0.0), 0.06 * wave(1.0, 0.15), 0.05);
        let rotation = rotation_exp(DVec3::Y * turn)
            * rotation_exp(DVec3::Z * drop)
            * rotation_exp(DVec3::X * lean);
        (place, rotation)
    }

    fn hip(&self, leg: &Leg, time: f64) -> DVec3 {
        let (place, rotation) = self.pelvis(time);
        place + rotation * self.rest[leg.hip]
    }

    /// The pose at `time`, in strides.
    fn frame(&self, time: f64) -> MotionFrame {
        let (place, pelvis) = self.pelvis(time);
        let mut local = vec![DMat3::IDENTITY; BODY.len()];
        local[0] = pelvis;
        for leg in &LEGS {
            self.pose_leg(leg, time, pelvis, &mut local);
        }
        let wave = |at: f64| (TAU * (time - at)).cos();
        let (spine, head) = ([3, 6, 9], [12, 15]);
        for joint in spine {
            let turn = rotation_exp(DVec3::new(-0.015, 0.06 * wave(0.02), -0.022 * wave(0.15)));
            local[joint] = turn;
        }
        // The head looks ahead whatever chest and pelvis do.
        let chest = pelvis * local[spine[0]] * local[spine[1]] * local[spine[2]];
        let back = rotation_exp(-0.5 * supple::internal::math::rotation_log(chest));
        head.iter().for_each(|&joint| local[joint] = back);
        for (arm, ahead, side) in [([13, 16, 18, 20], 0.5, 1.0), ([14, 17, 19, 21], 0.0, -1.0)] {
            let [collar, shoulder, elbow, wrist] = arm;
            // The left arm is ahead half a stride after the left leg.
            let swing = (TAU * (time + ahead - 0.04)).cos();
            local[collar] = rotation_exp(DVec3::new(0.0, -0.06 * side * swing, -0.05 * side));
            local[shoulder] = rotation_exp(DVec3::X * (0.04 - 0.38 * swing))
                * rotation_exp(DVec3::Z * (-1.27 * side))
                * rotation_exp(DVec3::X * -0.15);
            local[elbow] = rotation_exp(DVec3::Y * (-side * (0.38 + 0.2 * swing)));
            local[wrist] = rotation_exp(DVec3::new(0.0, -0.06 * side, -0.08 * side));
        }
        MotionFrame {
            translations: vec![place - self.rest[0]],
            rotations: local
                .iter()
                .map(|r| DQuat::from_mat3(r).normalize())
                .collect(),
        }
    }

    /// Hip, knee and ankle by the law of cosines; the knee forward of the line from hip to ankle.
    fn pose_leg(&self, leg: &Leg, time: f64, pelvis: DMat3, local: &mut [DMat3]) {
        let rest = self.rest;
        let (hip, foot) = (self.hip(leg, time), foot(leg, time));
        let (thigh, shin) = (
            rest[leg.knee] - rest[leg.hip],
            rest[leg.ankle] - rest[leg.knee],
        );
        let (a, b) = (thigh.length(), shin.length());
        let reach = foot.ankle - hip;
        let c = reach.length().min(0.9999 * (a + b));
        let along = reach.normalize_or(-DVec3::Y);
        // Knees and toes point outwards a little.
        let outward = DVec3::new(0.12 * leg.side, 0.0, 1.0);
        let forward = (outward - along * along.dot(outward)).normalize_or(DVec3::Z);
        let part = (a * a + c * c - b * b) / (2.0 * c);
        let knee = hip + along * part + forward * (a * a - part * part).max(0.0).sqrt();
        let side = forward.cross(-along);
        let side = if side.x < 0.0 { -side } else { side };
        let thigh = frame(knee - hip, side) * frame(thigh, DVec3::X).transpose();
        let shin = frame(foot.ankle - knee, side) * frame(shin, DVec3::X).transpose();
        let sole = rotation_exp(DVec3::Y * 0.1 * leg.side) * tilt(foot.pitch);
        local[leg.hip] = pelvis.transpose() * thigh;
        local[leg.knee] = thigh.transpose() * shin;
        local[leg.ankle] = shin.transpose() * sole;
        local[leg.toes] = tilt(foot.toes);
    }
}

/// Columns: a bone's direction, its side at a right angle, and what is square to both.
fn frame(direction: DVec3, side: DVec3) -> DMat3 {
    let along = direction.normalize_or(-DVec3::Y);
    let side = (side - along * along.dot(side)).normalize_or(DVec3::X);
    DMat3::from_cols(along, side, along.cross(side))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Places of a point fixed to a bone, through the clip.
    fn path(clip: &MotionClip, bone: usize, point: DVec3) -> Vec<DVec3> {
        let frames = clip.frames.iter().map(|f| clip.world_frames(f)[bone]);
        frames.map(|f| f.transform(point)).collect()
    }

    #[test]
    fn what_stands_does_not_slide_and_nothing_sinks() {
        let clip = walk();
        clip.validate().unwrap();
        for leg in &LEGS {
            let (ball, heel) = (path(&clip, leg.ankle, BALL), path(&clip, leg.ankle, HEEL));
            let mut standing = 0;
            for k in 0..ball.len() {
                let phase = (k as f64 / FRAMES as f64 + leg.ahead).fract();
                assert!(
                    ball[k].y > -1e-3 && heel[k].y > -1e-3,
                    "frame {k}: {} {}",
                    ball[k].y,
                    heel[k].y
                );
                let next = (k + 1).min(ball.len() - 1);
                if phase > FLAT && phase + 1.0 / (FRAMES as f64) < TOE_OFF && next > k {
                    standing += 1;
                    let slid = (ball[next] - ball[k]).length();
                    assert!(slid < 0.002, "frame {k} slides {slid}");
                }
            }
            assert!(standing >= FRAMES, "{standing}");
        }
    }

    #[test]
    fn a_stride_later_it_is_the_same_pose_further_on() {
        let clip = walk();
        let (a, b) = (&clip.frames[3], &clip.frames[3 + FRAMES]);
        let way = b.translations[0] - a.translations[0];
        assert!((way - DVec3::Z * STRIDE).length() < 1e-12, "{way}");
        for (a, b) in a.rotations.iter().zip(&b.rotations) {
            assert!(a.angle_between(*b) < 1e-6);
        }
    }

    #[test]
    fn knees_bend_and_arms_swing_against_legs() {
        let clip = walk();
        let knee = |f: &MotionFrame| DVec3::X.dot(f.rotations[4].to_scaled_axis()).to_degrees();
        let bends: Vec<f64> = clip.frames.iter().map(knee).collect();
        let most = bends.iter().fold(0.0, |a: f64, b| a.max(*b));
        assert!((50.0..75.0).contains(&most), "{most}");
        assert!(bends.iter().all(|b| *b > 2.0), "no knee bends backwards");
        let at = |bone: usize, k: usize| clip.world_frames(&clip.frames[k])[bone].position.z;
        for k in [0, FRAMES] {
            assert!(at(7, k) - at(8, k) > 0.4, "the left foot is ahead");
            assert!(at(21, k) - at(20, k) > 0.15, "the right hand is ahead");
        }
    }
}
