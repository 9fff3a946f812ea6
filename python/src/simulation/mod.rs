//! An avatar in time.

mod driving;
mod touching;

use crate::arrays::triangles;
use crate::avatar::{Avatar, up_axis};
use crate::error::{OrRaise, invalid};
use crate::motion::{Grip, Motion};
use crate::potential::Potential;
use crate::result::{Clip, Kept, Snapshot, Stack, StepResult};
use crate::settings::Options;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::sync::Arc;
use supple::World;
use supple::glam::DVec3;
use supple::gpu::{AdapterChoice, GpuDevice};
use supple::model::{Frame, UpAxis};
use supple::world::{Backend, Character, ColliderId, InstanceId};

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
}

const ALL: Kept = Kept {
    vertices: true,
    displacements: true,
    contact_forces: true,
};

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
        let avatar = self.world.instance(self.instance).or_raise()?.avatar();
        Potential::new(py, Arc::new(avatar.clone()), instance, settings)
    }

    /// Sets what is named, from the next step on.
    ///
    /// Tissue, as factors on what was baked: softness, friction, tissue_gravity; bounce (0 creeps back, 0.5 as people, 1
    /// rings), tension of muscles (0 to 1). gravity: m/s², a number against up or a vector. solver: "budgeted",
    /// "one_iteration", "converged", or a dictionary with "mode". integrator: "bdf2" or "backward_euler". And longest_step,
    /// largest_acceleration, slip_speed, geometric_contact, joint_stiffness (N/m), report_at_end,
    /// fine_handles (how many may be awake, of an avatar that was baked with some).
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
