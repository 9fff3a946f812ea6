//! What a step and a clip give.

use crate::arrays::{matrix, vectors};
use numpy::{PyArray1, PyArray2, PyArray3, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use std::path::PathBuf;
use supple::glam::{DMat3, DVec3};
use supple::model::Frame;
use supple::sim::{InstanceReport, StepEnergies, Stop, Timings};
use supple_files::{ENERGY_NAMES, ENERGY_TERMS, energy_terms, loads_by_bone};

/// What a step ended with, copied out of the simulation.
#[derive(Clone, Default)]
pub struct Snapshot {
    pub time: f64,
    pub vertices: Vec<DVec3>,
    pub normals: Vec<DVec3>,
    pub displacements: Vec<DVec3>,
    pub contact_forces: Vec<DVec3>,
    pub pressures: Vec<f64>,
    pub frames: Vec<Frame>,
    pub handles: Vec<DVec3>,
    pub report: InstanceReport,
    pub timings: Timings,
}

impl Snapshot {
    /// Force and torque on each bone.
    pub fn loads(&self) -> Vec<[f64; 6]> {
        loads_by_bone(&self.report.loads, self.frames.len())
    }

    /// In the order of [`ENERGY_NAMES`].
    pub fn energies(&self) -> [f64; ENERGY_TERMS] {
        energy_terms(&StepEnergies {
            tissue: self.report.energies,
            skeleton: self.report.skeleton_energies,
        })
    }
}

/// A step's result; it stays as it is when the simulation goes on.
#[pyclass(module = "supple", frozen)]
pub struct StepResult(pub Snapshot);

#[pymethods]
impl StepResult {
    /// Since the start, s.
    #[getter]
    fn time(&self) -> f64 {
        self.0.time
    }

    /// V × 3, m: the posed skin, in the world.
    #[getter]
    fn vertices<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        vectors(py, &self.0.vertices)
    }

    /// V × 3: its normals.
    #[getter]
    fn normals<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        vectors(py, &self.0.normals)
    }

    /// V × 3, m: how far the tissue is off the skinned shape, in the axes of the bind pose.
    #[getter]
    fn displacements<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        vectors(py, &self.0.displacements)
    }

    /// V × 3, N: contact and friction on each vertex, in world axes.
    #[getter]
    fn contact_forces<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        vectors(py, &self.0.contact_forces)
    }

    /// V, Pa: the normal force on each vertex by its area.
    #[getter]
    fn pressures<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, &self.0.pressures)
    }

    /// 3, N: the sum of `contact_forces`.
    #[getter]
    fn contact_force<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        let sum: DVec3 = self.0.contact_forces.iter().sum();
        PyArray1::from_slice(py, &sum.to_array())
    }

    /// B × 3, m: joints of the bones in the world.
    #[getter]
    fn positions<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let places: Vec<DVec3> = self.0.frames.iter().map(|f| f.position).collect();
        vectors(py, &places)
    }

    /// B × 3 × 3: rotations of the bones from the bind pose.
    #[getter]
    fn rotations<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray3<f64>>> {
        let frames = &self.0.frames;
        rotations(py, frames.iter().map(|f| f.rotation))
    }

    /// H × 3, m: displacements φ of the handles.
    #[getter]
    fn handles<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        vectors(py, &self.0.handles)
    }

    /// B × 6: force (N) and torque (N·m) that drives each bone, in world axes; 0 of bones that nothing drives.
    #[getter]
    fn loads<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        matrix(py, self.0.loads().into_flattened(), 6)
    }

    /// J, by name: what each term of E has changed by in the step.
    #[getter]
    fn energies<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let energies = PyDict::new(py);
        for (name, energy) in ENERGY_NAMES.iter().zip(self.0.energies()) {
            energies.set_item(name, energy)?;
        }
        Ok(energies)
    }

    /// How the step went: stop, iterations, contacts, largest gap of a joint (m), weight (N), and ms of its parts.
    #[getter]
    fn report<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let (report, timings) = (&self.0.report, &self.0.timings);
        let out = PyDict::new(py);
        out.set_item("stop", stop_name(report.stop))?;
        out.set_item("iterations", report.iterations)?;
        out.set_item("contacts", report.contacts)?;
        out.set_item("contacts_left_out", report.contacts_left_out)?;
        out.set_item("max_joint_gap", report.max_joint_gap)?;
        out.set_item("decrement", report.decrement)?;
        out.set_item("step_length", report.step_length)?;
        out.set_item("weight", report.weight.to_array())?;
        let ms = PyDict::new(py);
        for (name, value) in [
            ("step", timings.step),
            ("evaluation", timings.evaluation),
            ("force", timings.force),
            ("hessian", timings.hessian),
            ("readback", timings.readback),
            ("solve", timings.solve),
            ("skeleton", timings.skeleton),
            ("skin", timings.skin),
        ] {
            ms.set_item(name, value)?;
        }
        out.set_item("ms", ms)?;
        Ok(out)
    }

    fn __repr__(&self) -> String {
        let force: DVec3 = self.0.contact_forces.iter().sum();
        let longest = self.0.displacements.iter().map(|d| d.length());
        format!(
            "<supple.StepResult at {:.4} s: displaced by {:.3} mm at most, {} contacts, {:.3} N>",
            self.0.time,
            1e3 * longest.fold(0.0, f64::max),
            self.0.report.contacts,
            force.length()
        )
    }
}

fn rotations<'py>(
    py: Python<'py>,
    all: impl ExactSizeIterator<Item = DMat3>,
) -> PyResult<Bound<'py, PyArray3<f64>>> {
    let count = all.len();
    // numpy's rows are glam's columns of the transpose.
    let flat = all.flat_map(|r| r.transpose().to_cols_array());
    PyArray1::from_vec(py, flat.collect()).reshape([count, 3, 3])
}

fn stop_name(stop: Stop) -> &'static str {
    match stop {
        Stop::OneIteration => "one_iteration",
        Stop::AsModelled => "as_modelled",
        Stop::Converged => "converged",
        Stop::LineSearchStalled => "line_search_stalled",
        Stop::IterationLimit => "iteration_limit",
        Stop::Inactive => "inactive",
        _ => "other",
    }
}

/// Which large arrays of a clip are kept.
#[derive(Clone, Copy, Debug, Default)]
pub struct Kept {
    pub vertices: bool,
    pub displacements: bool,
    pub contact_forces: bool,
}

/// Arrays that grow step by step.
#[derive(Default)]
pub struct Stack {
    kept: Kept,
    time: Vec<f64>,
    vertices: Vec<f64>,
    displacements: Vec<f64>,
    contact_forces: Vec<f64>,
    positions: Vec<f64>,
    rotations: Vec<f64>,
    loads: Vec<f64>,
    energies: Vec<f64>,
}

impl Stack {
    /// Room for `steps` of so many vertices.
    pub fn new(kept: Kept, steps: usize, vertices: usize) -> Self {
        let room = |wanted: bool| match wanted {
            true => Vec::with_capacity(3 * steps * vertices),
            false => Vec::new(),
        };
        Self {
            vertices: room(kept.vertices),
            displacements: room(kept.displacements),
            contact_forces: room(kept.contact_forces),
            kept,
            ..Self::default()
        }
    }

    pub fn push(&mut self, step: &Snapshot) {
        let add = |wanted: bool, to: &mut Vec<f64>, from: &[DVec3]| {
            if wanted {
                to.extend(from.iter().flat_map(DVec3::to_array));
            }
        };
        self.time.push(step.time);
        add(self.kept.vertices, &mut self.vertices, &step.vertices);
        add(
            self.kept.displacements,
            &mut self.displacements,
            &step.displacements,
        );
        add(
            self.kept.contact_forces,
            &mut self.contact_forces,
            &step.contact_forces,
        );
        for frame in &step.frames {
            self.positions.extend(frame.position.to_array());
            self.rotations
                .extend(frame.rotation.transpose().to_cols_array());
        }
        self.loads.extend(step.loads().as_flattened());
        self.energies.extend(step.energies());
    }

    /// As numpy arrays.
    pub fn into_clip(
        self,
        py: Python<'_>,
        vertices: usize,
        bones: usize,
        faces: Py<PyAny>,
        bone_names: Vec<String>,
    ) -> PyResult<Clip> {
        let steps = self.time.len();
        let stacked = |flat: Vec<f64>, shape: &[usize]| -> PyResult<Py<PyAny>> {
            let array = PyArray1::from_vec(py, flat).reshape(shape)?;
            Ok(array.into_any().unbind())
        };
        let kept = |wanted: bool, flat: Vec<f64>| {
            let shape = [steps, vertices, 3];
            wanted.then(|| stacked(flat, &shape)).transpose()
        };
        let energies = PyDict::new(py);
        for (k, name) in ENERGY_NAMES.iter().enumerate() {
            let of_term = self.energies.iter().skip(k).step_by(ENERGY_NAMES.len());
            energies.set_item(name, PyArray1::from_vec(py, of_term.copied().collect()))?;
        }
        Ok(Clip {
            vertices: kept(self.kept.vertices, self.vertices)?,
            displacements: kept(self.kept.displacements, self.displacements)?,
            contact_forces: kept(self.kept.contact_forces, self.contact_forces)?,
            positions: stacked(self.positions, &[steps, bones, 3])?,
            rotations: stacked(self.rotations, &[steps, bones, 3, 3])?,
            loads: stacked(self.loads, &[steps, bones, 6])?,
            all_energies: stacked(self.energies, &[steps, ENERGY_NAMES.len()])?,
            energies: energies.unbind(),
            time: stacked(self.time, &[steps])?,
            faces,
            bone_names,
        })
    }
}

/// A whole clip as stacked arrays.
#[pyclass(module = "supple", frozen)]
pub struct Clip {
    /// T, s.
    #[pyo3(get)]
    time: Py<PyAny>,
    /// T × V × 3, m: the posed skin; None where it was not to be recorded, as the next two.
    #[pyo3(get)]
    vertices: Option<Py<PyAny>>,
    /// T × V × 3, m: how far the tissue is off the skinned shape.
    #[pyo3(get)]
    displacements: Option<Py<PyAny>>,
    /// T × V × 3, N: contact and friction on each vertex.
    #[pyo3(get)]
    contact_forces: Option<Py<PyAny>>,
    /// T × B × 3, m: joints of the bones.
    #[pyo3(get)]
    positions: Py<PyAny>,
    /// T × B × 3 × 3: rotations of the bones from the bind pose.
    #[pyo3(get)]
    rotations: Py<PyAny>,
    /// T × B × 6: force (N) and torque (N·m) that drives each bone.
    #[pyo3(get)]
    loads: Py<PyAny>,
    /// J: T of each term, by name.
    #[pyo3(get)]
    energies: Py<PyDict>,
    /// F × 3: triangles of the skin.
    #[pyo3(get)]
    faces: Py<PyAny>,
    /// B names.
    #[pyo3(get)]
    bone_names: Vec<String>,
    all_energies: Py<PyAny>,
}

#[pymethods]
impl Clip {
    /// Writes it with the arrays of `supple simulate --series`, by numpy.
    fn save(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        let arrays = PyDict::new(py);
        let large = [
            ("vertices", &self.vertices),
            ("displacement", &self.displacements),
            ("contact_force", &self.contact_forces),
        ];
        for (name, array) in large {
            if let Some(array) = array {
                arrays.set_item(name, array)?;
            }
        }
        arrays.set_item("time", &self.time)?;
        arrays.set_item("loads", &self.loads)?;
        arrays.set_item("energies", &self.all_energies)?;
        arrays.set_item("energy_names", PyList::new(py, ENERGY_NAMES)?)?;
        arrays.set_item("faces", &self.faces)?;
        arrays.set_item("bone_names", PyList::new(py, &self.bone_names)?)?;
        py.import("numpy")?
            .call_method("savez", (path,), Some(&arrays))?;
        Ok(())
    }

    fn __len__(&self, py: Python<'_>) -> PyResult<usize> {
        self.time.bind(py).len()
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        Ok(format!("<supple.Clip of {} frames>", self.__len__(py)?))
    }
}
