//! What may be set on a simulation, by name.

use crate::arrays::numbers;
use crate::error::{OrRaise, invalid};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString};
use pythonize::{depythonize, pythonize};
use supple::glam::DVec3;
use supple::model::UpAxis;
use supple::potential::TissueFactors;
use supple::sim::Settings;

/// All that may be set.
#[derive(Clone, Debug)]
pub struct Options {
    pub settings: Settings,
    pub factors: TissueFactors,
    pub bounce: Option<f64>,
    pub gravity: DVec3,
}

impl Options {
    /// As it is with nothing said, in a world of this `up` and these settings.
    pub fn new(settings: Settings, up: UpAxis) -> Self {
        Self {
            settings,
            factors: TissueFactors::default(),
            bounce: None,
            gravity: -9.81 * up.direction(),
        }
    }

    /// The same with what is said in `given`.
    pub fn with(&self, given: Option<&Bound<'_, PyDict>>, up: UpAxis) -> PyResult<Self> {
        let mut out = self.clone();
        let Some(given) = given else {
            return Ok(out);
        };
        let py = given.py();
        let table = pythonize(py, &self.settings)
            .map_err(|e| invalid("settings", e.to_string()))?
            .cast_into::<PyDict>()?;
        let mut changed = false;
        let number = |key: &str, value: &Bound<'_, PyAny>| {
            let read = value.extract::<f64>();
            read.map_err(|_| invalid(key, "must be a number"))
        };
        for (key, value) in given {
            let key = key.extract::<String>()?;
            match key.as_str() {
                "softness" => {
                    let softness = number(&key, &value)?;
                    if !(softness > 0.0 && softness.is_finite()) {
                        let problem = format!(
                            "{softness}; must be positive (1 is as it was baked, 2 is twice as soft)"
                        );
                        return Err(invalid("softness", problem));
                    }
                    out.factors.stiffness = softness.recip();
                }
                "bounce" => {
                    let bounce = number(&key, &value)?;
                    out.factors.set_bounce(bounce).or_raise()?;
                    out.bounce = Some(bounce);
                }
                "tension" => out.factors.tension = number(&key, &value)?,
                "friction" => out.factors.friction = number(&key, &value)?,
                "tissue_gravity" => out.factors.gravity = number(&key, &value)?,
                "gravity" => out.gravity = gravity(&value, up)?,
                "solver" => {
                    changed = true;
                    table.set_item(&key, solver(&value)?)?;
                }
                "time_step" => {
                    let problem = "is what step() takes";
                    return Err(invalid("time_step", problem));
                }
                _ if table.contains(&key)? => {
                    changed = true;
                    table.set_item(&key, value)?;
                }
                _ => {
                    let known: Vec<String> = table.keys().extract()?;
                    let known = known.iter().filter(|k| *k != "time_step");
                    let known: Vec<&str> = [
                        "softness",
                        "bounce",
                        "tension",
                        "friction",
                        "gravity",
                        "tissue_gravity",
                    ]
                    .into_iter()
                    .chain(known.map(String::as_str))
                    .collect();
                    let problem = format!("is no setting; there are {}", known.join(", "));
                    return Err(invalid(&key, problem));
                }
            }
        }
        if changed {
            out.settings =
                depythonize(table.as_any()).map_err(|e| invalid("settings", e.to_string()))?;
        }
        out.settings.validate().or_raise()?;
        out.factors.validate().or_raise()?;
        Ok(out)
    }

    /// As a dictionary.
    pub fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let table = pythonize(py, &self.settings)
            .map_err(|e| invalid("settings", e.to_string()))?
            .cast_into::<PyDict>()?;
        table.del_item("time_step")?;
        table.set_item("softness", self.factors.stiffness.recip())?;
        table.set_item("bounce", self.bounce)?;
        table.set_item("tension", self.factors.tension)?;
        table.set_item("friction", self.factors.friction)?;
        table.set_item("tissue_gravity", self.factors.gravity)?;
        table.set_item("gravity", self.gravity.to_array())?;
        Ok(table)
    }
}

/// A number is how strong it is, against the world's up.
fn gravity(value: &Bound<'_, PyAny>, up: UpAxis) -> PyResult<DVec3> {
    if let Ok(strength) = value.extract::<f64>() {
        if !strength.is_finite() {
            return Err(invalid(
                "gravity",
                format!("{strength} is not finite (m/s²)"),
            ));
        }
        return Ok(-strength * up.direction());
    }
    let shape = numbers(value, "gravity")?.shape;
    if shape != [3] {
        let three: [(Option<usize>, &str); 1] = [(Some(3), "")];
        return Err(crate::arrays::wrong_shape("gravity", &shape, &[&three]));
    }
    crate::arrays::vector(value, "gravity")
}

/// A solver by its name, or a dictionary as a scene's `solver` table.
fn solver<'py>(value: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyDict>> {
    if let Ok(table) = value.cast::<PyDict>() {
        return Ok(table.clone());
    }
    let name = value.cast::<PyString>().map_err(|_| {
        let problem =
            "must be \"budgeted\", \"one_iteration\", \"converged\" or a dictionary with \"mode\"";
        invalid("solver", problem)
    })?;
    let table = PyDict::new(value.py());
    table.set_item("mode", name)?;
    Ok(table)
}
