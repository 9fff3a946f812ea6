//! The engine's errors as Python's: classes of `supple._errors`, with path, field and cure.

use pyo3::prelude::*;
use pyo3::types::PyDict;
use supple::{Error, GpuError};

/// A Python error of class `class` of `supple._errors`.
fn raise(class: &str, message: &str, details: &[(&str, Option<String>)]) -> PyErr {
    Python::attach(|py| {
        let made = || -> PyResult<PyErr> {
            let kwargs = PyDict::new(py);
            for (key, value) in details {
                kwargs.set_item(key, value)?;
            }
            let class = py.import("supple._errors")?.getattr(class)?;
            Ok(PyErr::from_value(class.call((message,), Some(&kwargs))?))
        };
        made().unwrap_or_else(|error| error)
    })
}

/// An argument that cannot be used.
pub fn invalid(field: &str, problem: impl Into<String>) -> PyErr {
    to_python(Error::invalid(field, problem))
}

/// The Python error of `error`.
pub fn to_python(error: Error) -> PyErr {
    let message = error.to_string();
    let text = |value: &dyn ToString| Some(value.to_string());
    match &error {
        Error::Io { path, source } => {
            // What Python's own `open` raises besides, so that `except FileNotFoundError` catches it.
            let class = match source.kind() {
                std::io::ErrorKind::NotFound => "MissingFileError",
                _ => "FileError",
            };
            let path = ("path", text(&path.display()));
            raise(class, &message, &[path, ("problem", text(source))])
        }
        Error::Format {
            path,
            field,
            problem,
        } => raise(
            "FormatError",
            &message,
            &[
                ("path", text(&path.display())),
                ("field", text(field)),
                ("problem", text(problem)),
                ("cure", cure(problem)),
            ],
        ),
        Error::Invalid { field, problem } => raise(
            "InvalidError",
            &message,
            &[
                ("field", text(field)),
                ("problem", text(problem)),
                ("cure", cure(problem)),
            ],
        ),
        Error::Solve { system, problem } => raise(
            "SolveError",
            &message,
            &[
                ("field", text(system)),
                ("problem", text(problem)),
                ("cure", cure(problem)),
            ],
        ),
        Error::NotFinite { quantity } => {
            raise("NotFiniteError", &message, &[("field", text(quantity))])
        }
        Error::Gpu(GpuError::Limit { what, cure, .. }) => raise(
            "GpuError",
            &message,
            &[("field", text(what)), ("cure", text(cure))],
        ),
        Error::Gpu(problem) => raise(
            "GpuError",
            &message,
            &[
                ("problem", text(problem)),
                ("cure", cure(&problem.to_string())),
            ],
        ),
        _ => raise("Error", &message, &[]),
    }
}

/// What a message says after what is wrong: behind its first semicolon, else behind its first colon.
fn cure(problem: &str) -> Option<String> {
    let parts = problem
        .split_once("; ")
        .or_else(|| problem.split_once(": "));
    parts.map(|(_, cure)| cure.to_string())
}

/// `?` on the engine's results.
pub trait OrRaise<T> {
    /// The value, or the Python error.
    fn or_raise(self) -> PyResult<T>;
}

impl<T> OrRaise<T> for supple::Result<T> {
    fn or_raise(self) -> PyResult<T> {
        self.map_err(to_python)
    }
}
