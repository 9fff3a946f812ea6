//! An avatar in time.

use crate::arrays::{Length, finite, matrix, triangles};
use crate::avatar::{Avatar, up_axis};
use crate::collider::{self, Collider};
use crate::error::{OrRaise, invalid, to_python};
use crate::motion::{Grip, Motion, drive};
use crate::potential::Potential;
use crate::result::{Clip, Kept, Snapshot, Stack, StepResult};
use crate::settings::Options;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString};
use std::path::PathBuf;
use supple::World;
use supple::collider::Shape;
use supple::glam::{DVec3, Mat4};
use supple::gpu::{AdapterChoice, GpuDevice};
use supple::model::{Frame, UpAxis};
use supple::skeleton::Spring;
use supple::world::{Backend, Character, ColliderId, InstanceId};
use supple_scene::TrackedMotion;

/// An avatar in time.
///
/// backend: "auto" takes a GPU if there is one, else the CPU; "cpu" (f64), "gpu", "software_gpu". up: the axis that points
/// up in the world, the avatar's own if not given; AMASS's arrays want "z". Settings are those of `configure`.
#[pyclass(module = "supple")]
pub struct Simulation {
    pub world: World,
    pub instance: InstanceId,
    avatar: Py<Avatar>,
    pub options: Options,
    up: UpAxis,
    /// Where it stands in its bind pose.
    bind: Vec<Frame>,
    motion: Motion,
    grip: Grip,
    /// Since the motion began, s.
    motion_time: f64,
    /// Since the start, s.
    time: f64,
    /// Whether no step was made since it was put where it is.
    at_rest: bool,
    pub colliders: Vec<ColliderId>,
}

impl Simulation {
    fn character(&self) -> PyResult<&Character> {
        self.world.instance(self.instance).or_raise()
    }

    fn character_mut(&mut self) -> PyResult<&mut Character> {
        self.world.instance_mut(self.instance).or_raise()
    }

    /// Follows `motion` from its start on.
    fn begin(&mut self, motion: Motion, grip: Grip) -> PyResult<()> {
        if let Some(frames) = motion.frames(0.0) {
            drive(self.character_mut()?, &frames, grip).or_raise()?;
        }
        (self.motion, self.grip) = (motion, grip);
        self.motion_time = 0.0;
        Ok(())
    }

    /// What `poses` are: a file's motion, or numbers.
    fn motion_of(
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
    fn drive(&mut self, py: Python<'_>, dt: f64) -> PyResult<()> {
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

    /// A step without the GIL.
    fn advance(&mut self, py: Python<'_>, dt: f64) -> PyResult<()> {
        if !(dt > 0.0 && dt.is_finite()) {
            return Err(invalid(
                "dt",
                format!("{dt} is not a positive number of seconds"),
            ));
        }
        self.drive(py, dt)?;
        let world = &mut self.world;
        py.detach(move || world.step_blocking(dt)).or_raise()?;
        self.at_rest = false;
        self.motion_time += self.motion.advance(dt);
        self.time += dt;
        Ok(())
    }

    /// What is there now.
    fn snapshot(&mut self, py: Python<'_>, kept: Kept) -> PyResult<Snapshot> {
        let (world, instance, time) = (&mut self.world, self.instance, self.time);
        let touches = !self.colliders.is_empty() && kept.contact_forces;
        let read = move || -> supple::Result<Snapshot> {
            let mut out = Snapshot {
                time,
                timings: world.timings(),
                ..Snapshot::default()
            };
            if kept.vertices {
                world.read_skin_blocking(instance, &mut out.vertices, &mut out.normals)?;
            }
            if touches {
                let (forces, pressures) = (&mut out.contact_forces, &mut out.pressures);
                world.read_contacts_blocking(instance, forces, pressures)?;
            } else if kept.contact_forces {
                let vertices = world.instance(instance)?.avatar().skin.len();
                out.contact_forces.resize(vertices, DVec3::ZERO);
                out.pressures.resize(vertices, 0.0);
            }
            let character = world.instance(instance)?;
            if kept.displacements {
                out.displacements = character.displacement();
            }
            out.frames = character.frames().to_vec();
            out.handles = character.handles().to_vec();
            out.report = character.report().clone();
            Ok(out)
        };
        py.detach(read).or_raise()
    }

    /// The factors and constants of `options`, in the world and its avatar.
    fn apply(&mut self, options: Options) -> PyResult<()> {
        self.world.set_settings(options.settings).or_raise()?;
        self.world.set_gravity(options.gravity);
        self.character_mut()?
            .set_factors(options.factors)
            .or_raise()?;
        self.options = options;
        Ok(())
    }

    /// Adds a collider, which a handle names.
    fn add(
        slf: &Bound<'_, Self>,
        shape: Shape,
        frame: Frame,
        contact: collider::Contact,
    ) -> PyResult<Collider> {
        let mut sim = slf.try_borrow_mut()?;
        let collider = contact.collider(shape, frame);
        let id = sim.world.add_collider(collider).or_raise()?;
        sim.colliders.push(id);
        drop(sim);
        Ok(Collider::new(slf.clone().unbind(), id))
    }
}

const ALL: Kept = Kept {
    vertices: true,
    displacements: true,
    contact_forces: true,
};

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

#[pymethods]
impl Simulation {
    #[new]
    #[pyo3(signature = (avatar, backend="auto", *, up=None, **settings))]
    fn new(
        py: Python<'_>,
        avatar: Py<Avatar>,
        backend: &str,
        up: Option<&str>,
        settings: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        let inner = avatar.get().inner.clone();
        let up = up.map_or(Ok(inner.up), up_axis)?;
        let gpu = |choice: AdapterChoice| {
            let opened = py.detach(|| pollster::block_on(GpuDevice::open(choice)));
            opened
                .map(|GpuDevice { device, queue, .. }| Backend::Gpu { device, queue })
                .or_raise()
        };
        let backend = match backend {
            "auto" => Backend::Auto,
            "cpu" => Backend::Cpu,
            "gpu" => gpu(AdapterChoice::Hardware)?,
            "software_gpu" => gpu(AdapterChoice::Software)?,
            other => {
                let problem = format!(
                    "{other:?} is none; give \"auto\", \"cpu\", \"gpu\" or \"software_gpu\""
                );
                return Err(invalid("backend", problem));
            }
        };
        let made = move || -> supple::Result<_> {
            let world = World::new(backend)?.with_up(up);
            Ok((world, inner))
        };
        let (world, inner) = py.detach(made).or_raise()?;
        let options = Options::new(*world.settings(), up).with(settings, up)?;
        let mut world = world.with_settings(options.settings).or_raise()?;
        let placed = py.detach(|| -> supple::Result<_> {
            let asset = world.add_avatar(inner)?;
            world.add_instance(asset)
        });
        let instance = placed.or_raise()?;
        let mut this = Self {
            bind: world.instance(instance).or_raise()?.frames().to_vec(),
            instance,
            world,
            avatar,
            options: options.clone(),
            up,
            motion: Motion::None,
            grip: Grip::Exact,
            motion_time: 0.0,
            time: 0.0,
            at_rest: true,
            colliders: Vec::new(),
        };
        this.apply(options)?;
        Ok(this)
    }

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

    /// Puts everything into equilibrium with what drives and touches it, at rest: tissue sags, springs give way, and nothing
    /// swings in the first step. How far its last iteration still moved anything, m.
    fn settle(&mut self, py: Python<'_>) -> PyResult<f64> {
        let world = &mut self.world;
        py.detach(move || world.settle_blocking()).or_raise()
    }

    /// One step of dt, s: what is followed, and colliders, move evenly through it; a long one is cut into several. Other
    /// threads of Python run meanwhile.
    #[pyo3(signature = (dt=1.0/60.0))]
    fn step(&mut self, py: Python<'_>, dt: f64) -> PyResult<StepResult> {
        self.advance(py, dt)?;
        self.snapshot(py, ALL).map(StepResult)
    }

    /// A whole clip as stacked arrays. It starts at rest in the first pose, which is frame 0, and makes a step a frame.
    ///
    /// poses, trans, fps, options: as for follow(); without them what is followed goes on, for `duration` (s). record: which of
    /// "vertices", "displacements" and "contact_forces" are kept, all if not given. substeps: steps a frame. progress is
    /// called with (frames done, of all).
    #[pyo3(signature = (
        poses=None, trans=None, fps=None, *, options=None, duration=None, record=None, substeps=1, progress=None
    ))]
    #[expect(clippy::too_many_arguments, reason = "they are keywords")]
    fn simulate(
        &mut self,
        py: Python<'_>,
        poses: Option<&Bound<'_, PyAny>>,
        trans: Option<&Bound<'_, PyAny>>,
        fps: Option<f64>,
        options: Option<&Bound<'_, PyDict>>,
        duration: Option<f64>,
        record: Option<Vec<String>>,
        substeps: usize,
        progress: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Clip> {
        let kept = kept(record)?;
        if let Some(poses) = poses {
            self.at_rest = true;
            let motion = self.motion_of(py, poses, trans, fps, options)?;
            self.begin(motion, self.grip)?;
            self.character_mut()?.reset();
            (self.time, self.at_rest) = (0.0, true);
        }
        if fps.is_none() && matches!(self.motion, Motion::Steps(_)) {
            let problem =
                "is needed: how many poses a second? files of AMASS have it as mocap_framerate";
            return Err(invalid("fps", problem));
        }
        let own = self.motion.extent();
        let frame_time = match (fps, own) {
            (Some(fps), _) => fps.recip(),
            (None, Some((frame_time, _))) => frame_time,
            (None, None) => 1.0 / 60.0,
        };
        let frames = match (duration, own) {
            (Some(duration), _) if duration > 0.0 && duration.is_finite() => {
                (duration / frame_time).round() as usize + 1
            }
            (Some(duration), _) => {
                let problem = format!("{duration} is not a positive number of seconds");
                return Err(invalid("duration", problem));
            }
            (None, Some((of_clip, frames))) => {
                ((frames - 1) as f64 * of_clip / frame_time).round() as usize + 1
            }
            (None, None) => {
                let problem = "is needed: nothing is followed that would end";
                return Err(invalid("duration", problem));
            }
        };
        if substeps == 0 {
            return Err(invalid("substeps", "0; must be at least 1"));
        }
        let avatar = self.avatar.get().inner.clone();
        let mut stack = Stack::new(kept, frames, avatar.skin.len());
        let skinned = Kept {
            vertices: kept.vertices,
            ..kept
        };
        stack.push(&self.snapshot(py, skinned)?);
        for frame in 1..frames {
            for _ in 0..substeps {
                self.advance(py, frame_time / substeps as f64)?;
            }
            stack.push(&self.snapshot(py, skinned)?);
            py.check_signals()?;
            if let Some(progress) = progress {
                progress.call1((frame, frames - 1))?;
            }
        }
        let faces = triangles(py, &avatar.triangles)?.into_any().unbind();
        let (vertices, bones) = (avatar.skin.len(), avatar.bones());
        stack.into_clip(py, vertices, bones, faces, avatar.skeleton.names.clone())
    }

    /// What is there now, without a step.
    fn state(&mut self, py: Python<'_>) -> PyResult<StepResult> {
        self.snapshot(py, ALL).map(StepResult)
    }

    /// E(q) of the step of dt (s) that would come next, at q where the avatar is; with its gradient and Hessian. A motion's
    /// next pose is where bones are prescribed.
    #[pyo3(signature = (dt=1.0/60.0))]
    fn potential(&mut self, py: Python<'_>, dt: f64) -> PyResult<Potential> {
        if !(dt > 0.0 && dt.is_finite()) {
            return Err(invalid(
                "dt",
                format!("{dt} is not a positive number of seconds"),
            ));
        }
        self.drive(py, dt)?;
        let mut settings = self.options.settings;
        settings.time_step = dt;
        let mut instance = self.character()?.instance().clone();
        instance.colliders.clear();
        for k in 0..self.colliders.len() {
            let collider = self.world.collider_mut(self.colliders[k]).or_raise()?;
            instance.colliders.push(collider.clone());
        }
        let avatar = self.avatar.get().inner.clone();
        Potential::new(py, avatar, instance, settings)
    }

    /// Sets what is named, from the next step on.
    ///
    /// Tissue, as factors on what was baked: softness, friction, tissue_gravity; bounce (0 creeps back, 0.5 as people, 1
    /// rings), tension of muscles (0 to 1). gravity: m/s², a number against up or a vector. solver: "budgeted",
    /// "one_iteration", "converged", or a dictionary with "mode". integrator: "bdf2" or "backward_euler". And longest_step,
    /// largest_acceleration, slip_speed, geometric_contact, joint_stiffness (N/m), report_at_end.
    #[pyo3(signature = (**settings))]
    fn configure<'py>(
        slf: &Bound<'py, Self>,
        settings: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Bound<'py, Self>> {
        let mut sim = slf.try_borrow_mut()?;
        let options = sim.options.with(settings, sim.up)?;
        sim.apply(options)?;
        drop(sim);
        Ok(slf.clone())
    }

    /// All that may be set, with its values.
    #[getter]
    fn settings<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        self.options.to_dict(py)
    }

    /// The avatar.
    #[getter]
    fn avatar(&self, py: Python<'_>) -> Py<Avatar> {
        self.avatar.clone_ref(py)
    }

    /// What evaluates the tissue: "cpu", or the adapter's name.
    #[getter]
    fn backend(&self) -> String {
        self.world.backend()
    }

    /// Since the start, s.
    #[getter]
    fn time(&self) -> f64 {
        self.time
    }

    /// The axis that points up in the world.
    #[getter]
    fn up(&self) -> &'static str {
        match self.up {
            UpAxis::X => "x",
            UpAxis::Y => "y",
            UpAxis::Z => "z",
        }
    }

    /// What was decided about the motion's file.
    #[getter]
    fn motion_notes(&self) -> Vec<String> {
        self.motion.notes()
    }

    /// A ball of this radius (m). `friction` is μ, `stiffness` in Pa/m (none: 1e8, or what the tissue says), contact begins at the distance `margin` (m).
    #[pyo3(signature = (radius, position, *, friction=0.0, stiffness=None, margin=0.0))]
    fn add_sphere(
        slf: &Bound<'_, Self>,
        radius: f64,
        position: &Bound<'_, PyAny>,
        friction: f64,
        stiffness: Option<f64>,
        margin: f64,
    ) -> PyResult<Collider> {
        let frame = collider::frame(Some(position), None)?;
        let contact = collider::Contact {
            friction,
            stiffness,
            margin,
        };
        Self::add(slf, Shape::Sphere { radius }, frame, contact)
    }

    /// A ball of this radius swept from `start` to `end` (m).
    #[pyo3(signature = (start, end, radius, *, friction=0.0, stiffness=None, margin=0.0))]
    fn add_capsule(
        slf: &Bound<'_, Self>,
        start: &Bound<'_, PyAny>,
        end: &Bound<'_, PyAny>,
        radius: f64,
        friction: f64,
        stiffness: Option<f64>,
        margin: f64,
    ) -> PyResult<Collider> {
        let (frame, half_length) = collider::between(start, end)?;
        let contact = collider::Contact {
            friction,
            stiffness,
            margin,
        };
        Self::add(
            slf,
            Shape::Capsule {
                radius,
                half_length,
            },
            frame,
            contact,
        )
    }

    /// A flat-ended cylinder from `start` to `end` (m).
    #[pyo3(signature = (start, end, radius, *, friction=0.0, stiffness=None, margin=0.0))]
    fn add_cylinder(
        slf: &Bound<'_, Self>,
        start: &Bound<'_, PyAny>,
        end: &Bound<'_, PyAny>,
        radius: f64,
        friction: f64,
        stiffness: Option<f64>,
        margin: f64,
    ) -> PyResult<Collider> {
        let (frame, half_length) = collider::between(start, end)?;
        let contact = collider::Contact {
            friction,
            stiffness,
            margin,
        };
        Self::add(
            slf,
            Shape::Cylinder {
                radius,
                half_length,
            },
            frame,
            contact,
        )
    }

    /// A box of this `size` (three extents, m). Rotations are matrices or rotation vectors (rad).
    #[pyo3(signature = (size, position, rotation=None, *, friction=0.0, stiffness=None, margin=0.0))]
    fn add_box(
        slf: &Bound<'_, Self>,
        size: &Bound<'_, PyAny>,
        position: &Bound<'_, PyAny>,
        rotation: Option<&Bound<'_, PyAny>>,
        friction: f64,
        stiffness: Option<f64>,
        margin: f64,
    ) -> PyResult<Collider> {
        let half_extents = (0.5 * crate::arrays::vector(size, "size")?).to_array();
        let frame = collider::frame(Some(position), rotation)?;
        let contact = collider::Contact {
            friction,
            stiffness,
            margin,
        };
        Self::add(slf, Shape::Box { half_extents }, frame, contact)
    }

    /// All that is below a plane: `normal` points out of it.
    #[pyo3(signature = (point, normal, *, friction=0.0, stiffness=None, margin=0.0))]
    fn add_half_space(
        slf: &Bound<'_, Self>,
        point: &Bound<'_, PyAny>,
        normal: &Bound<'_, PyAny>,
        friction: f64,
        stiffness: Option<f64>,
        margin: f64,
    ) -> PyResult<Collider> {
        let frame = collider::facing(point, normal)?;
        let contact = collider::Contact {
            friction,
            stiffness,
            margin,
        };
        Self::add(slf, Shape::HalfSpace, frame, contact)
    }

    /// All that is below this height (m), along the world's up.
    #[pyo3(signature = (height=0.0, *, friction=0.5, stiffness=None, margin=0.0))]
    fn add_ground(
        slf: &Bound<'_, Self>,
        height: f64,
        friction: f64,
        stiffness: Option<f64>,
        margin: f64,
    ) -> PyResult<Collider> {
        if !height.is_finite() {
            return Err(invalid("height", format!("{height} is not finite (m)")));
        }
        let up = slf.try_borrow()?.up;
        let ground = supple::collider::Collider::ground(up);
        let frame = Frame {
            position: height * up.direction(),
            ..ground.frame
        };
        let contact = collider::Contact {
            friction,
            stiffness,
            margin,
        };
        Self::add(slf, ground.shape, frame, contact)
    }

    /// A closed triangle mesh: V × 3 (m), F × 3, counter-clockwise seen from outside.
    #[pyo3(signature = (vertices, faces, position=None, rotation=None, *, friction=0.0, stiffness=None, margin=0.0))]
    #[expect(clippy::too_many_arguments, reason = "they are keywords")]
    fn add_mesh(
        slf: &Bound<'_, Self>,
        vertices: &Bound<'_, PyAny>,
        faces: &Bound<'_, PyAny>,
        position: Option<&Bound<'_, PyAny>>,
        rotation: Option<&Bound<'_, PyAny>>,
        friction: f64,
        stiffness: Option<f64>,
        margin: f64,
    ) -> PyResult<Collider> {
        let surface = collider::surface(vertices, faces)?;
        let shape = slf
            .py()
            .detach(|| supple::collider::MeshShape::new(&surface));
        let shape = shape.map_err(|e| to_python(e.within("vertices")))?;
        let frame = collider::frame(position, rotation)?;
        let contact = collider::Contact {
            friction,
            stiffness,
            margin,
        };
        Self::add(slf, Shape::Mesh(shape), frame, contact)
    }

    fn __repr__(&self) -> String {
        let avatar = &self.avatar.get().inner.name;
        format!(
            "<supple.Simulation of {avatar:?} on {}, {:.4} s>",
            self.backend(),
            self.time
        )
    }
}

/// Which arrays a clip keeps; all if nothing is said.
fn kept(record: Option<Vec<String>>) -> PyResult<Kept> {
    let Some(record) = record else {
        return Ok(ALL);
    };
    let mut kept = Kept::default();
    for name in record {
        match name.as_str() {
            "vertices" => kept.vertices = true,
            "displacements" => kept.displacements = true,
            "contact_forces" => kept.contact_forces = true,
            other => {
                let known = "\"vertices\", \"displacements\" and \"contact_forces\"";
                return Err(invalid(
                    "record",
                    format!("{other:?} is none; there are {known}"),
                ));
            }
        }
    }
    Ok(kept)
}
