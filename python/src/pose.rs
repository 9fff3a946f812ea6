//! Poses as SMPL has them: a rotation vector for each joint relative to its parent, and where the root is.

use crate::arrays::{Length, Numbers, check_finite, finite, numbers, wrong_shape};
use crate::error::OrRaise;
use pyo3::prelude::*;
use supple::glam::{DAffine3, DMat3, DQuat, DVec3};
use supple::internal::math::rotation_log;
use supple::model::{Avatar, Frame, JointBone};
use supple_files::{MotionClip, MotionFrame};

/// The joints that a pose has rotations of, in its order.
#[derive(Clone, Debug, PartialEq)]
pub struct PoseOrder {
    pub names: Vec<String>,
    /// The bone that each is; none of a joint that rides on another one's.
    pub bones: Vec<Option<usize>>,
}

impl PoseOrder {
    /// The file's own order where its joints are placed as SMPL's are, without rest rotations; else that of the bones.
    pub fn of(avatar: &Avatar) -> Self {
        let joints = avatar.joints.joints();
        let plain = joints.iter().all(|j| j.bind.matrix3 == DMat3::IDENTITY);
        let placed = joints.iter().all(|j| match j.bone {
            JointBone::Is(_) => j.bind == DAffine3::IDENTITY,
            JointBone::RidesOn(_) => true,
        });
        let of_file = || {
            let bone = |j: &supple::model::Joint| match j.bone {
                JointBone::Is(bone) => Some(bone as usize),
                JointBone::RidesOn(_) => None,
            };
            let mut bones: Vec<usize> = joints.iter().filter_map(bone).collect();
            bones.sort_unstable();
            let all = bones.into_iter().eq(0..avatar.bones());
            all.then(|| Self {
                names: joints.iter().map(|j| j.name.clone()).collect(),
                bones: joints.iter().map(bone).collect(),
            })
        };
        let found = (plain && placed).then(of_file).flatten();
        found.unwrap_or_else(|| Self {
            names: avatar.skeleton.names[..avatar.bones()].to_vec(),
            bones: (0..avatar.bones()).map(Some).collect(),
        })
    }

    pub fn len(&self) -> usize {
        self.names.len()
    }

    /// Poses, frame after frame: (T, J, 3), (T, 3J), (J, 3) or (3J,). Whether it was one pose alone.
    pub fn read(
        &self,
        object: &Bound<'_, PyAny>,
        field: &str,
    ) -> PyResult<(Vec<f64>, usize, bool)> {
        let Numbers { shape, values } = numbers(object, field)?;
        let joints = self.len();
        let (frames, single) = match shape[..] {
            [t, j, 3] if j == joints => (t, false),
            [j, 3] if j == joints => (1, true),
            [t, n] if n == 3 * joints => (t, false),
            [n] if n == 3 * joints => (1, true),
            _ => {
                let j = (Some(joints), "J");
                let flat = (Some(3 * joints), "3J");
                let expected: [&[Length<'_>]; 4] = [
                    &[(None, "T"), j, (Some(3), "")],
                    &[(None, "T"), flat],
                    &[j, (Some(3), "")],
                    &[flat],
                ];
                return Err(wrong_shape(field, &shape, &expected));
            }
        };
        if frames == 0 {
            return Err(crate::error::invalid(field, "holds no frame"));
        }
        check_finite(
            field,
            &Numbers {
                shape,
                values: values.clone(),
            },
        )?;
        Ok((values, frames, single))
    }

    /// Where the root goes in each of `frames`: (T, 3) or (3,); where it stands in the bind pose if nothing is given.
    pub fn read_trans(
        &self,
        object: Option<&Bound<'_, PyAny>>,
        frames: usize,
        single: bool,
    ) -> PyResult<Vec<DVec3>> {
        let Some(object) = object else {
            return Ok(vec![DVec3::ZERO; frames]);
        };
        let of_one: &[Length<'_>] = &[(Some(3), "")];
        let of_all: &[Length<'_>] = &[(Some(frames), "T"), (Some(3), "")];
        let shape = numbers(object, "trans")?.shape;
        let found = finite(
            object,
            "trans",
            if single && shape.len() == 1 {
                of_one
            } else {
                of_all
            },
        )?;
        Ok(found
            .values
            .chunks_exact(3)
            .map(DVec3::from_slice)
            .collect())
    }

    /// The clip of these poses for `avatar`: its bones are the avatar's.
    pub fn clip(
        &self,
        avatar: &Avatar,
        poses: &[f64],
        trans: &[DVec3],
        frame_time: f64,
    ) -> PyResult<MotionClip> {
        let skeleton = avatar.character();
        let count = skeleton.len();
        let frame = |(pose, &translation): (&[f64], &DVec3)| {
            let mut rotations = vec![DQuat::IDENTITY; count];
            for (vector, bone) in pose.chunks_exact(3).zip(&self.bones) {
                if let Some(bone) = bone {
                    rotations[*bone] = DQuat::from_scaled_axis(DVec3::from_slice(vector));
                }
            }
            MotionFrame {
                translations: vec![translation],
                rotations,
            }
        };
        let frames = poses.chunks_exact(3 * self.len()).zip(trans).map(frame);
        let clip = MotionClip {
            name: "poses".into(),
            bones: skeleton.names.clone(),
            parents: skeleton.parents.clone(),
            rest_joints: Some(skeleton.joints.clone()),
            rest_up: avatar.up,
            world_up: avatar.up,
            frame_time,
            translated: vec![0],
            frames: frames.collect(),
            notes: Vec::new(),
        };
        clip.validate().or_raise()?;
        Ok(clip)
    }

    /// The pose of `frames`: a rotation vector for each joint, 0 of those that ride.
    pub fn pose_of(&self, avatar: &Avatar, frames: &[Frame]) -> Vec<f64> {
        let parents = &avatar.skeleton.parents;
        let local = |bone: usize| match parents[bone] {
            None => frames[bone].rotation,
            Some(p) => frames[p as usize].rotation.transpose() * frames[bone].rotation,
        };
        let vector = |bone: &Option<usize>| bone.map_or(DVec3::ZERO, |b| rotation_log(local(b)));
        (self.bones.iter())
            .flat_map(|b| vector(b).to_array())
            .collect()
    }
}
