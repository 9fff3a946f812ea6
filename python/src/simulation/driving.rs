//! What moves an avatar in time.

use super::Simulation;
use crate::arrays::{Length, finite, matrix};
use crate::error::{OrRaise, invalid};
use crate::motion::{Grip, Motion, drive};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString};
use std::path::PathBuf;
use supple::glam::Mat4;
use supple::skeleton::Spring;
use supple_scene::TrackedMotion;

/// A spring of a pair (stiffness, damping).
fn spring(pair: Option<(f64, f64)>, default: Spring, field: &str) -> PyResult<Spring> {
    let Some((stiffness, damping)) = pair else {
        return Ok(default);
    };
    if !(stiffness >= 0.0 && damping >= 0.0 && (stiffness + damping).is_finite()) {
        return Err(invalid(
            field,
            "stiffness and damping must be zero or positive",
        ));
    }
    Ok(Spring { stiffness, damping })
}

impl Simulation {
    /// Follows `motion` from its start on.
    pub(super) fn begin(&mut self, motion: Motion, grip: Grip) -> PyResult<()> {
        if let Some(frames) = motion.frames(0.0) {
            drive(self.character_mut()?, &frames, grip).or_raise()?;
        }
        (self.motion, self.grip) = (motion, grip);
        self.motion_time = 0.0;
        Ok(())
    }

    /// What `poses` are: a file's motion, or numbers.
    pub(super) fn motion_of(
        &self,
        py: Python<'_>,
        poses: &Bound<'_, PyAny>,
        trans: Option<&Bound<'_, PyAny>>,
        fps: Option<f64>,
        options: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Motion> {
        if let Some(fps) = fps.filter(|f| !(*f > 0.0 && f.is_finite())) {
            return Err(invalid(
                "fps",
                format!("{fps}; must be positive (frames a second)"),
            ));
        }
        let character = self.character()?;
        let is_path = poses.is_instance_of::<PyString>() || poses.hasattr("__fspath__")?;
        if is_path {
            if trans.is_some() {
                return Err(invalid("trans", "is in the file: leave it out"));
            }
            let path: PathBuf = poses.extract()?;
            let standing = match self.at_rest {
                true => &self.bind[..],
                false => character.frames(),
            };
            return Motion::open(path, fps, options, character.avatar(), self.up, standing);
        }
        if options.is_some() {
            return Err(invalid("options", "are for files of motions"));
        }
        let order = &self.avatar.get().order;
        let (poses, frames, single) = order.read(poses, "poses")?;
        let trans = order.read_trans(trans, frames, single)?;
        let clip = py.detach(|| {
            let rate = fps.unwrap_or(1.0);
            order.clip(character.avatar(), &poses, &trans, rate.recip())
        })?;
        Ok(match (single, fps) {
            (true, _) => Motion::Frames(clip.world_frames(&clip.sample(0.0))),
            (false, Some(_)) => Motion::Poses(Box::new(clip)),
            (false, None) => Motion::Steps(Box::new(clip)),
        })
    }

    /// Says where the bones go in the step to come, and what the pose adds to the skin.
    pub(super) fn drive(&mut self, py: Python<'_>, dt: f64) -> PyResult<()> {
        let (started, time) = (self.at_rest, self.motion_time + self.motion.advance(dt));
        let frames = self.motion.frames(time);
        let (instance, grip) = (self.instance, self.grip);
        if let Some(frames) = &frames {
            // On the way from the first moment on, as the motion is: a start from rest would be a blow.
            let begins = started && self.motion.moves();
            let character = self.world.instance_mut(instance).or_raise()?;
            match begins {
                true => character.begin_moving(frames, dt).or_raise()?,
                false => drive(character, frames, grip).or_raise()?,
            }
        }
        let avatar = self.avatar.get();
        let Some(offsets) = &avatar.pose_offsets else {
            return Ok(());
        };
        let character = self.character()?;
        let posed = frames.as_deref().unwrap_or_else(|| character.frames());
        let pose = avatar.order.pose_of(&avatar.inner, posed);
        let given = offsets.bind(py).call1((matrix(py, pose, 3)?,))?;
        let count = avatar.inner.offset_vertices();
        let shape: [Length<'_>; 2] = [(Some(count), "V"), (Some(3), "")];
        let given = finite(&given, "pose_offsets", &shape)?.values;
        let offset = |v: usize| {
            let at = 3 * avatar.file_vertex(v);
            [given[at] as f32, given[at + 1] as f32, given[at + 2] as f32]
        };
        let offsets: Vec<[f32; 3]> = (0..count).map(offset).collect();
        self.character_mut()?.set_pose_offsets(&offsets).or_raise()
    }
}

#[pymethods]
impl Simulation {
    /// All bones follow poses exactly. Returns the simulation itself.
    ///
    /// poses: rotation vectors (rad) of the joints of `avatar.pose_names` relative to their parents, as SMPL has them: T × J × 3
    /// or T × 3J of a clip with fps poses a second (without fps each step takes the next pose); J × 3 or 3J of one pose, where
    /// the bones are at the end of the next step. trans: T × 3 or 3, m, of the root from its place in the bind pose. Or the path
    /// of a motion (.npz of AMASS, .bvh, .glb, .vrma), whose bones are mapped by their names; options are then keys of a
    /// scene's [motion], as {"map": {"LeftUpLeg": "thigh_l"}, "clip": "walk"}. What is followed before the
    /// first step, or after reset(), is where it starts.
    #[pyo3(signature = (poses, trans=None, *, fps=None, options=None))]
    fn follow<'py>(
        slf: &Bound<'py, Self>,
        poses: &Bound<'_, PyAny>,
        trans: Option<&Bound<'_, PyAny>>,
        fps: Option<f64>,
        options: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Bound<'py, Self>> {
        let mut sim = slf.try_borrow_mut()?;
        let motion = sim.motion_of(slf.py(), poses, trans, fps, options)?;
        sim.begin(motion, Grip::Exact)?;
        drop(sim);
        Ok(slf.clone())
    }

    /// Springs draw all bones to poses, which give way to what they meet. Poses are as for follow(); rotation: stiffness and
    /// damping, N·m/rad and N·m·s; position: N/m and N·s/m.
    #[pyo3(signature = (poses, trans=None, *, fps=None, options=None, rotation=None, position=None))]
    fn track<'py>(
        slf: &Bound<'py, Self>,
        poses: &Bound<'_, PyAny>,
        trans: Option<&Bound<'_, PyAny>>,
        fps: Option<f64>,
        options: Option<&Bound<'_, PyDict>>,
        rotation: Option<(f64, f64)>,
        position: Option<(f64, f64)>,
    ) -> PyResult<Bound<'py, Self>> {
        let mut sim = slf.try_borrow_mut()?;
        let usual = TrackedMotion::default();
        let rotation = spring(rotation, usual.rotation, "rotation")?;
        let position = spring(position, usual.position, "position")?;
        let motion = sim.motion_of(slf.py(), poses, trans, fps, options)?;
        sim.begin(motion, Grip::Springs(rotation, position))?;
        drop(sim);
        Ok(slf.clone())
    }

    /// All bones follow 4 × 4 world matrices (acting on columns) of the file's joints, one for each of the file: what a game
    /// has. They are where the bones are at the end of the next step.
    fn follow_matrices<'py>(
        slf: &Bound<'py, Self>,
        matrices: &Bound<'_, PyAny>,
    ) -> PyResult<Bound<'py, Self>> {
        let mut sim = slf.try_borrow_mut()?;
        let avatar = sim.avatar.get().inner.clone();
        let four = (Some(4), "");
        let shape = [(Some(avatar.joints.len()), "J"), four, four];
        let found = finite(matrices, "matrices", &shape)?;
        // numpy's rows are glam's columns of the transpose.
        let of_rows = |m: &[f64]| Mat4::from_cols_array(&std::array::from_fn(|k| m[k] as f32));
        let joints = found
            .values
            .chunks_exact(16)
            .map(|m| of_rows(m).transpose());
        let joints: Vec<Mat4> = joints.collect();
        let mut frames = Vec::new();
        let skeleton = &avatar.skeleton;
        (avatar.joints)
            .frames_from_world(skeleton, &joints, &mut frames)
            .or_raise()?;
        sim.begin(Motion::Frames(frames), Grip::Exact)?;
        drop(sim);
        Ok(slf.clone())
    }

    /// The root is held, springs keep the bind pose: what is done where nothing is said.
    fn hold<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, Self>> {
        let mut sim = slf.try_borrow_mut()?;
        sim.motion = Motion::None;
        sim.character_mut()?.hold();
        drop(sim);
        Ok(slf.clone())
    }

    /// Nothing drives it: it falls. Joints bend against springs of this stiffness, N·m/rad.
    #[pyo3(signature = (bending_stiffness=10.0))]
    fn ragdoll<'py>(slf: &Bound<'py, Self>, bending_stiffness: f64) -> PyResult<Bound<'py, Self>> {
        let mut sim = slf.try_borrow_mut()?;
        (sim.character_mut()?.ragdoll(bending_stiffness)).or_raise()?;
        sim.motion = Motion::None;
        drop(sim);
        Ok(slf.clone())
    }

    /// Back to the start of what it follows, at rest.
    fn reset<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, Self>> {
        let mut sim = slf.try_borrow_mut()?;
        let grip = sim.grip;
        if let Some(frames) = sim.motion.frames(0.0) {
            drive(sim.character_mut()?, &frames, grip).or_raise()?;
        }
        sim.character_mut()?.reset();
        (sim.time, sim.motion_time, sim.at_rest) = (0.0, 0.0, true);
        drop(sim);
        Ok(slf.clone())
    }
}
