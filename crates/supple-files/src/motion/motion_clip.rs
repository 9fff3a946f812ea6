//! Recorded motion of a skeleton, before it is mapped onto an avatar's.

use super::cubic;
use glam::{DMat3, DQuat, DVec3};
use supple::model::{Frame, UpAxis};
use supple::{Error, Result};

/// A pose of a [`MotionClip`]'s bones.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MotionFrame {
    /// For each of [`MotionClip::translated`]: how far its joint is from its rest place, in its
    /// parent's axes (a root's: in the world's), m.
    pub translations: Vec<DVec3>,
    /// For each bone: its unit rotation relative to its parent (a root's: to the world), away from
    /// the rest pose: R_parentᵀ R, R being I for every bone at rest.
    pub rotations: Vec<DQuat>,
}

/// Recorded motion: frames at equal intervals.
///
/// Rotations are away from the rest pose and in the rest pose's axes, whatever rest rotations the
/// bones of the file have: a bone at rest rotation Q and now at W in the world has R = W Q⁻¹.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MotionClip {
    /// What it is called.
    pub name: String,
    /// Names of the bones, unique.
    pub bones: Vec<String>,
    /// Parent of each bone; parents come first. There may be several roots.
    pub parents: Vec<Option<u32>>,
    /// Each joint's place in the rest pose, m, if the file tells.
    pub rest_joints: Option<Vec<DVec3>>,
    /// The axis that points up in the rest pose.
    pub rest_up: UpAxis,
    /// The axis that points up in the world that roots move in.
    pub world_up: UpAxis,
    /// Time from one frame to the next, s.
    pub frame_time: f64,
    /// Bones whose joints move relative to their parents; rising. Usually the root alone.
    pub translated: Vec<u32>,
    /// At least one.
    pub frames: Vec<MotionFrame>,
    /// What was decided about its file, and what of it an avatar cannot follow; a sentence each.
    pub notes: Vec<String>,
}

impl MotionClip {
    /// Index of the bone called `name`.
    pub fn find(&self, name: &str) -> Option<usize> {
        self.bones.iter().position(|n| n == name)
    }

    /// Time from the first frame to the last, s.
    pub fn duration(&self) -> f64 {
        self.frame_time * self.frames.len().saturating_sub(1) as f64
    }

    /// At most 100 of its frames, spread over all of it.
    pub(crate) fn spread_frames(&self) -> impl Iterator<Item = &MotionFrame> {
        self.frames
            .iter()
            .step_by(self.frames.len().div_ceil(100).max(1))
    }

    /// The pose at `time`, s from the first frame: cubic in between, since a body that is drawn along
    /// chords is struck at each frame and its tissue rings. It stands still before the first frame and after the last.
    pub fn sample(&self, time: f64) -> MotionFrame {
        let last = self.frames.len().saturating_sub(1);
        // NaN becomes 0.
        let at = (time / self.frame_time).max(0.0).min(last as f64);
        let before = (at.floor() as usize).min(last);
        let part = at - before as f64;
        let a = &self.frames[before];
        if part == 0.0 {
            return a.clone();
        }
        // The frames around, without one beyond an end.
        let around = [
            before.checked_sub(1).map(|i| &self.frames[i]),
            Some(a),
            Some(&self.frames[before + 1]),
            self.frames.get(before + 2),
        ];
        let place = |k: usize| around.map(|frame| frame.map(|f| f.translations[k]));
        let turn = |j: usize| around.map(|frame| frame.map(|f| f.rotations[j]));
        MotionFrame {
            translations: (0..a.translations.len())
                .map(|k| cubic::place(place(k), part))
                .collect(),
            rotations: (0..a.rotations.len())
                .map(|j| cubic::rotation(turn(j), part))
                .collect(),
        }
    }

    /// World rotation R of each bone away from its rest pose.
    pub fn world_rotations(&self, frame: &MotionFrame) -> Vec<DQuat> {
        let mut world: Vec<DQuat> = Vec::with_capacity(self.bones.len());
        for (parent, local) in self.parents.iter().zip(&frame.rotations) {
            world.push(match parent {
                None => *local,
                Some(p) => (world[*p as usize] * *local).normalize(),
            });
        }
        world
    }

    /// World frame of each bone: c = c_p + R_p (J − J_p + t). Without rest joints, J = 0.
    pub fn world_frames(&self, frame: &MotionFrame) -> Vec<Frame> {
        let rest = |j: usize| self.rest_joints.as_ref().map_or(DVec3::ZERO, |r| r[j]);
        let mut shift = vec![DVec3::ZERO; self.bones.len()];
        for (bone, t) in self.translated.iter().zip(&frame.translations) {
            shift[*bone as usize] = *t;
        }
        let mut frames: Vec<Frame> = Vec::with_capacity(self.bones.len());
        for (j, rotation) in self.world_rotations(frame).into_iter().enumerate() {
            let position = match self.parents[j] {
                None => rest(j) + shift[j],
                Some(p) => frames[p as usize].transform(rest(j) - rest(p as usize) + shift[j]),
            };
            frames.push(Frame {
                rotation: DMat3::from_quat(rotation),
                position,
            });
        }
        frames
    }

    /// Checks lengths, indices and numbers.
    ///
    /// # Errors
    /// [`Error::Invalid`] naming the field and, where there is one, the frame.
    pub fn validate(&self) -> Result<()> {
        let count = self.bones.len();
        let check = |ok: bool, field: &str, problem: &str| {
            ok.then_some(())
                .ok_or_else(|| Error::invalid(format!("motion.{field}"), problem))
        };
        check(count > 0, "bones", "there is none")?;
        let mut names: Vec<&String> = self.bones.iter().collect();
        names.sort();
        check(
            names.windows(2).all(|pair| pair[0] != pair[1]),
            "bones",
            "two bones share a name",
        )?;
        let mut parents = self.parents.iter().enumerate();
        check(
            self.parents.len() == count && parents.all(|(j, p)| p.is_none_or(|p| (p as usize) < j)),
            "parents",
            "one that stands before its child is needed for each bone",
        )?;
        check(
            (self.rest_joints.as_ref())
                .is_none_or(|r| r.len() == count && r.iter().all(|j| j.is_finite())),
            "rest_joints",
            "a finite place is needed for each bone",
        )?;
        check(
            self.frame_time > 0.0 && self.frame_time.is_finite(),
            "frame_time",
            "must be positive (s)",
        )?;
        check(
            self.translated.is_sorted_by(|a, b| a < b)
                && self.translated.iter().all(|&j| (j as usize) < count),
            "translated",
            "bones must exist and rise",
        )?;
        check(!self.frames.is_empty(), "frames", "there is none")?;
        for (i, frame) in self.frames.iter().enumerate() {
            check(
                frame.translations.len() == self.translated.len()
                    && frame.translations.iter().all(|t| t.is_finite()),
                &format!("frames[{i}].translations"),
                "a finite one is needed for each translated bone",
            )?;
            // Comparisons with NaN are false.
            let unit = |q: &DQuat| (q.length_squared() - 1.0).abs() < 1e-6;
            check(
                frame.rotations.len() == count && frame.rotations.iter().all(unit),
                &format!("frames[{i}].rotations"),
                "a unit quaternion is needed for each bone",
            )?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use std::f64::consts::FRAC_PI_2;

    /// Two bones along x; the root turns by 90° about z and the tip by −90° in one frame.
    fn clip() -> MotionClip {
        let frame = |angle: f64, x: f64| MotionFrame {
            translations: vec![DVec3::X * x],
            rotations: vec![
                DQuat::from_rotation_z(angle),
                DQuat::from_rotation_z(-angle),
            ],
        };
        MotionClip {
            name: "turn".into(),
            bones: vec!["root".into(), "tip".into()],
            parents: vec![None, Some(0)],
            rest_joints: Some(vec![DVec3::Z, DVec3::new(2.0, 0.0, 1.0)]),
            frame_time: 0.5,
            translated: vec![0],
            frames: vec![frame(0.0, 0.0), frame(FRAC_PI_2, 1.0)],
            ..MotionClip::default()
        }
    }

    #[test]
    fn half_way_is_half_the_angle_and_half_the_way() {
        let clip = clip();
        clip.validate().unwrap();
        assert_eq!(clip.duration(), 0.5);
        let half = clip.world_frames(&clip.sample(0.25));
        let tip = DVec3::new(0.5 + 2f64.sqrt(), 2f64.sqrt(), 1.0);
        assert_relative_eq!((half[1].position - tip).length(), 0.0, epsilon = 1e-15);
        let turn = half[1].rotation - DMat3::IDENTITY;
        assert!(turn.to_cols_array().iter().all(|d| d.abs() < 1e-15));
    }

    #[test]
    fn outside_its_time_it_stands_still() {
        let clip = clip();
        assert_eq!(clip.sample(-1.0), clip.frames[0]);
        assert_eq!(clip.sample(f64::NAN), clip.frames[0]);
        assert_eq!(clip.sample(f64::INFINITY), clip.frames[1]);
    }

    #[test]
    fn what_is_unusable_is_named() {
        let wrong = |change: &dyn Fn(&mut MotionClip), field: &str| {
            let mut bad = clip();
            change(&mut bad);
            let message = bad.validate().unwrap_err().to_string();
            assert!(
                message.starts_with(&format!("motion.{field}:")),
                "{message}"
            );
        };
        wrong(&|c| c.bones[1] = "root".into(), "bones");
        wrong(&|c| c.parents[1] = Some(1), "parents");
        wrong(&|c| c.rest_joints = Some(vec![DVec3::ZERO]), "rest_joints");
        wrong(&|c| c.frame_time = f64::NAN, "frame_time");
        wrong(&|c| c.translated = vec![2], "translated");
        wrong(&|c| c.frames.clear(), "frames");
        wrong(
            &|c| c.frames[1].translations[0].y = f64::NAN,
            "frames[1].translations",
        );
        wrong(
            &|c| c.frames[0].rotations[1] = DQuat::from_xyzw(0.0, 0.0, 0.0, 2.0),
            "frames[0].rotations",
        );
    }
}
