//! The engine's errors as those of `errors.js`, with path, field and cure.

use supple::Error;
use wasm_bindgen::prelude::*;

#[wasm_bindgen(raw_module = "../errors.js")]
extern "C" {
    /// An error of the class that is called `kind`.
    fn made(
        kind: &str,
        message: &str,
        path: Option<String>,
        field: Option<String>,
        problem: Option<String>,
        cure: Option<String>,
    ) -> JsValue;

    /// Tells the console of a fault of this package's own.
    pub fn panicked(message: &str);
}

/// What is thrown.
pub type Thrown<T> = Result<T, JsValue>;

/// An argument that cannot be used.
pub fn invalid(field: &str, problem: impl Into<String>) -> JsValue {
    thrown(Error::invalid(field, problem))
}

/// What `error` is to JavaScript.
pub fn thrown(error: Error) -> JsValue {
    let message = error.to_string();
    let make = |kind: &str, path: Option<String>, field: Option<String>, problem: String| {
        let cure = cure(&problem);
        made(kind, &message, path, field, Some(problem), cure)
    };
    match error {
        Error::Io { path, source } => {
            let path = Some(path.display().to_string());
            let cure = "a page reads no other file: pack buffers and images into one .glb".into();
            let problem = Some(source.to_string());
            made("FileError", &message, path, None, problem, Some(cure))
        }
        Error::Format {
            path,
            field,
            problem,
        } => make(
            "FormatError",
            Some(path.display().to_string()),
            Some(field),
            problem,
        ),
        Error::Invalid { field, problem } => {
            make("InvalidError", None, Some(field.to_string()), problem)
        }
        Error::Solve { system, problem } => make("SolveError", None, Some(system.into()), problem),
        Error::NotFinite { quantity } => made(
            "NotFiniteError",
            &message,
            None,
            Some(quantity.into()),
            None,
            None,
        ),
        other => make("SuppleError", None, None, other.to_string()),
    }
}

/// What a message says after what is wrong: behind its first semicolon, else behind its first colon.
fn cure(problem: &str) -> Option<String> {
    let parts = (problem.split_once("; ")).or_else(|| problem.split_once(": "));
    parts.map(|(_, cure)| cure.to_string())
}

/// `?` on the engine's results.
pub trait OrThrow<T> {
    /// The value, or what is thrown.
    fn or_throw(self) -> Thrown<T>;
}

impl<T> OrThrow<T> for supple::Result<T> {
    fn or_throw(self) -> Thrown<T> {
        self.map_err(thrown)
    }
}
