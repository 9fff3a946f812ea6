//! What the skin touches.

use crate::arrays::{Length, finite, rotation, vector};
use crate::error::{OrRaise, invalid};
use crate::simulation::Simulation;
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;
use supple::collider::Shape;
use supple::glam::{DMat3, DQuat, DVec3};
use supple::model::{Frame, Surface};
use supple::world::ColliderId;

/// How a collider is touched.
#[derive(Clone, Copy, Debug)]
pub struct Contact {
    pub friction: f64,
    pub stiffness: Option<f64>,
    pub margin: f64,
}

impl Contact {
    pub fn new(friction: f64, stiffness: Option<f64>, margin: f64) -> Self {
        Self {
            friction,
            stiffness,
            margin,
        }
    }

    pub fn collider(self, shape: Shape, frame: Frame) -> supple::collider::Collider {
        supple::collider::Collider {
            friction: self.friction,
            stiffness: self.stiffness,
            margin: self.margin,
            ..supple::collider::Collider::new(shape, frame)
        }
    }
}

/// A placement.
pub fn frame(
    position: Option<&Bound<'_, PyAny>>,
    turn: Option<&Bound<'_, PyAny>>,
) -> PyResult<Frame> {
    let out = Frame {
        position: position.map_or(Ok(DVec3::ZERO), |p| vector(p, "position"))?,
        rotation: turn.map_or(Ok(DMat3::IDENTITY), |r| rotation(r, "rotation"))?,
    };
    if !out.is_rigid() {
        let problem = "scales, shears or mirrors; give a rotation vector or an orthonormal matrix";
        return Err(invalid("rotation", problem));
    }
    Ok(out)
}

/// Where z points along `normal`, at `point`.
pub fn facing(point: &Bound<'_, PyAny>, normal: &Bound<'_, PyAny>) -> PyResult<Frame> {
    let direction = vector(normal, "normal")?;
    along(vector(point, "point")?, direction, "normal")
}

/// Where z points from `start` to `end`, in their middle; and half of the way between them.
pub fn between(start: &Bound<'_, PyAny>, end: &Bound<'_, PyAny>) -> PyResult<(Frame, f64)> {
    let (start, end) = (vector(start, "start")?, vector(end, "end")?);
    let frame = along(0.5 * (start + end), end - start, "end")?;
    Ok((frame, 0.5 * (end - start).length()))
}

fn along(position: DVec3, direction: DVec3, field: &str) -> PyResult<Frame> {
    let unit = direction.try_normalize();
    let unit = unit.ok_or_else(|| invalid(field, "gives no direction: its length is 0"))?;
    Ok(Frame {
        position,
        rotation: DMat3::from_quat(DQuat::from_rotation_arc(DVec3::Z, unit)),
    })
}

/// A triangle mesh.
pub fn surface(vertices: &Bound<'_, PyAny>, faces: &Bound<'_, PyAny>) -> PyResult<Surface> {
    let three: Length<'_> = (Some(3), "");
    let vertices = finite(vertices, "vertices", &[(None, "V"), three])?;
    let faces = finite(faces, "faces", &[(None, "F"), three])?;
    let count = vertices.shape[0];
    let index = |v: &f64| match *v {
        v if v >= 0.0 && v < count as f64 && v.fract() == 0.0 => Ok(v as u32),
        v => Err(invalid(
            "faces",
            format!("vertex {v} of {count} is not there"),
        )),
    };
    let indices = faces
        .values
        .iter()
        .map(index)
        .collect::<PyResult<Vec<u32>>>()?;
    Ok(Surface {
        positions: (vertices.values.chunks_exact(3))
            .map(DVec3::from_slice)
            .collect(),
        triangles: indices
            .chunks_exact(3)
            .map(|t| [t[0], t[1], t[2]])
            .collect(),
    })
}

/// A collider of a simulation, to be moved between steps.
#[pyclass(module = "supple", frozen)]
pub struct Collider {
    simulation: Py<Simulation>,
    id: ColliderId,
}

impl Collider {
    pub fn new(simulation: Py<Simulation>, id: ColliderId) -> Self {
        Self { simulation, id }
    }

    /// What stands for it in the world.
    fn with<T>(
        &self,
        py: Python<'_>,
        then: impl FnOnce(&mut supple::collider::Collider) -> T,
    ) -> PyResult<T> {
        let mut simulation = self.simulation.bind(py).try_borrow_mut()?;
        simulation.world.collider_mut(self.id).or_raise().map(then)
    }

    fn placed(
        &self,
        py: Python<'_>,
        position: Option<&Bound<'_, PyAny>>,
        turn: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Frame> {
        let now = self.with(py, |c| c.frame)?;
        let asked = frame(position, turn)?;
        Ok(Frame {
            position: if position.is_some() {
                asked.position
            } else {
                now.position
            },
            rotation: if turn.is_some() {
                asked.rotation
            } else {
                now.rotation
            },
        })
    }
}

#[pymethods]
impl Collider {
    /// Where it is at the end of the next step: it moves there evenly.
    #[pyo3(signature = (position=None, rotation=None))]
    fn move_to(
        &self,
        py: Python<'_>,
        position: Option<&Bound<'_, PyAny>>,
        rotation: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<()> {
        let frame = self.placed(py, position, rotation)?;
        self.with(py, |c| c.frame = frame)
    }

    /// Puts it there at once.
    #[pyo3(signature = (position=None, rotation=None))]
    fn place_at(
        &self,
        py: Python<'_>,
        position: Option<&Bound<'_, PyAny>>,
        rotation: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<()> {
        let frame = self.placed(py, position, rotation)?;
        self.with(py, |c| (c.frame, c.previous) = (frame, frame))
    }

    /// Takes it out.
    fn remove(&self, py: Python<'_>) -> PyResult<()> {
        let mut simulation = self.simulation.bind(py).try_borrow_mut()?;
        simulation.world.remove_collider(self.id).or_raise()?;
        simulation.colliders.retain(|id| *id != self.id);
        Ok(())
    }

    /// 3, m: where it is at the end of the next step.
    #[getter]
    fn position<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let position = self.with(py, |c| c.frame.position.to_array())?;
        Ok(PyArray1::from_slice(py, &position))
    }

    /// 3 × 3: how it is turned there.
    #[getter]
    fn rotation<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let rows = self.with(py, |c| c.frame.rotation.transpose().to_cols_array())?;
        crate::arrays::matrix(py, rows.to_vec(), 3)
    }

    /// μ.
    #[getter]
    fn friction(&self, py: Python<'_>) -> PyResult<f64> {
        self.with(py, |c| c.friction)
    }
}
