//! E of a step with its derivatives, as numpy and scipy have them.

use crate::arrays::{Length, finite, vectors};
use crate::error::{OrRaise, invalid};
use crate::simulation::Simulation;
use numpy::{PyArray1, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use supple::glam::DVec3;
use supple::model::{Avatar, State};
use supple::potential::{Evaluation, HessianForm};
use supple::sim::{Instance, Settings, StepPotential};
use supple_files::{ENERGY_NAMES, energy_terms};

/// E(q) − E(qⁿ) of the step that comes next, at a state q. It does not change when the simulation goes on.
///
/// Degrees of freedom, n in all: for each bone three of its place (m) and three of its rotation (R ← exp([δω]) R, rad), then
/// three for each handle (m). Derivatives are by these increments at q.
#[pyclass(module = "supple", frozen)]
pub struct Potential {
    inner: Arc<Mutex<StepPotential>>,
    state: State,
}

impl Potential {
    pub fn new(
        py: Python<'_>,
        avatar: Arc<Avatar>,
        instance: Instance,
        settings: Settings,
    ) -> PyResult<Self> {
        let made = py.detach(|| StepPotential::new(avatar, &instance, &settings));
        Ok(Self {
            inner: Arc::new(Mutex::new(made.or_raise()?)),
            state: instance.state,
        })
    }

    /// Nothing is half done in it where a call before has panicked: each starts from the state it is given.
    fn locked(inner: &Mutex<StepPotential>) -> MutexGuard<'_, StepPotential> {
        inner.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn dofs(&self) -> usize {
        self.state.space().dofs()
    }

    fn evaluated(&self, py: Python<'_>, form: HessianForm) -> PyResult<Evaluation> {
        let evaluate = || {
            let mut out = Evaluation::default();
            Self::locked(&self.inner)
                .evaluate(&self.state, form, &mut out)
                .map(|_| out)
        };
        py.detach(evaluate).or_raise()
    }
}

#[pymethods]
impl Potential {
    /// Number of degrees of freedom n: 6 a bone, 3 a handle.
    #[getter(dofs)]
    fn py_dofs(&self) -> usize {
        self.dofs()
    }

    /// n: which degrees of freedom a step leaves to what prescribes them.
    #[getter]
    fn fixed<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<bool>> {
        PyArray1::from_slice(py, Self::locked(&self.inner).fixed())
    }

    /// B × 3, m: joints of the bones at q.
    #[getter]
    fn positions<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let places: Vec<DVec3> = self.state.frames.iter().map(|f| f.position).collect();
        Ok(vectors(py, &places)?.into_any())
    }

    /// H × 3, m: displacements of the handles at q.
    #[getter]
    fn handles<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        Ok(vectors(py, &self.state.handles)?.into_any())
    }

    /// The same potential at q moved by `delta` (n).
    fn moved(&self, delta: &Bound<'_, PyAny>) -> PyResult<Self> {
        let shape: [Length<'_>; 1] = [(Some(self.dofs()), "dofs")];
        let delta = finite(delta, "delta", &shape)?;
        Ok(Self {
            inner: self.inner.clone(),
            state: self.state.moved(&delta.values, 1.0),
        })
    }

    /// The same potential where the simulation is now.
    fn at_state_of(&self, simulation: &Bound<'_, Simulation>) -> PyResult<Self> {
        let simulation = simulation.try_borrow()?;
        let character = simulation.world.instance(simulation.instance).or_raise()?;
        let state = character.state().clone();
        if state.space() != self.state.space() {
            return Err(invalid("simulation", "is of another avatar"));
        }
        Ok(Self {
            inner: self.inner.clone(),
            state,
        })
    }

    /// E(q) − E(qⁿ), J.
    fn energy(&self, py: Python<'_>) -> PyResult<f64> {
        let energies = py.detach(|| Self::locked(&self.inner).energies(&self.state));
        Ok(energies.or_raise()?.total())
    }

    /// The same term by term.
    fn energies<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let energies = py.detach(|| Self::locked(&self.inner).energies(&self.state));
        let terms = energy_terms(&energies.or_raise()?);
        let out = PyDict::new(py);
        for (name, energy) in ENERGY_NAMES.iter().zip(terms) {
            out.set_item(name, energy)?;
        }
        Ok(out)
    }

    /// n: ∂E/∂q, N and N·m.
    fn gradient<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let evaluation = self.evaluated(py, HessianForm::Solver)?;
        Ok(PyArray1::from_vec(py, evaluation.gradient))
    }

    /// n × n: a `scipy.sparse.csr_array`, or an array where it is to be dense. "solver": Newton's, convex; "exact": all second
    /// derivatives, symmetrised.
    #[pyo3(signature = (form="solver", *, dense=false))]
    fn hessian<'py>(
        &self,
        py: Python<'py>,
        form: &str,
        dense: bool,
    ) -> PyResult<Bound<'py, PyAny>> {
        let form = match form {
            "solver" => HessianForm::Solver,
            "exact" => HessianForm::Exact,
            other => {
                let problem = format!("{other:?} is none; give \"solver\" or \"exact\"");
                return Err(invalid("form", problem));
            }
        };
        let blocks = self.evaluated(py, form)?.hessian;
        let n = self.dofs();
        let inner = Self::locked(&self.inner);
        // Blocks of the lower triangle, column by column: each stands for its transpose too.
        let (mut rows, mut columns, mut values) = (Vec::new(), Vec::new(), Vec::new());
        for (block, (row, column)) in blocks.iter().zip(inner.pattern().blocks()) {
            for (k, &value) in block.iter().enumerate() {
                let (i, j) = ((3 * row + k % 3) as i32, (3 * column + k / 3) as i32);
                let mut add = |i: i32, j: i32| {
                    rows.push(i);
                    columns.push(j);
                    values.push(value);
                };
                add(i, j);
                if row != column {
                    add(j, i);
                }
            }
        }
        drop(inner);
        if dense {
            let mut full = vec![0.0; n * n];
            for ((i, j), value) in rows.iter().zip(&columns).zip(values) {
                full[*i as usize * n + *j as usize] = value;
            }
            return Ok(PyArray1::from_vec(py, full).reshape([n, n])?.into_any());
        }
        let sparse = py.import("scipy.sparse").map_err(|_| {
            invalid(
                "hessian",
                "scipy is not installed: pip install scipy, or ask for dense=True",
            )
        })?;
        let triplets = (
            PyArray1::from_vec(py, values),
            (
                PyArray1::from_vec(py, rows),
                PyArray1::from_vec(py, columns),
            ),
        );
        let coo = sparse.call_method1("coo_array", (triplets, (n, n)))?;
        coo.call_method0("tocsr")
    }

    fn __repr__(&self) -> String {
        format!("<supple.Potential of {} degrees of freedom>", self.dofs())
    }
}
