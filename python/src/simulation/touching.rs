//! What the skin of an avatar in time touches.

use super::Simulation;
use crate::collider::{self, Collider, Contact};
use crate::error::{OrRaise, invalid, to_python};
use pyo3::prelude::*;
use supple::collider::Shape;
use supple::model::Frame;

impl Simulation {
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

#[pymethods]
impl Simulation {
    /// A ball of this radius (m). `friction` is μ, `stiffness` in Pa/m (none: 1e8, or what the tissue says), contact begins at
    /// the distance `margin` (m).
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
        let contact = Contact::new(friction, stiffness, margin);
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
        let shape = Shape::Capsule {
            radius,
            half_length,
        };
        Self::add(slf, shape, frame, Contact::new(friction, stiffness, margin))
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
        let shape = Shape::Cylinder {
            radius,
            half_length,
        };
        Self::add(slf, shape, frame, Contact::new(friction, stiffness, margin))
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
        let contact = Contact::new(friction, stiffness, margin);
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
        let contact = Contact::new(friction, stiffness, margin);
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
        let contact = Contact::new(friction, stiffness, margin);
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
        let contact = Contact::new(friction, stiffness, margin);
        Self::add(slf, Shape::Mesh(shape), frame, contact)
    }
}
