//! The generated body is a closed, symmetric, well-formed, well-behaved human body.

mod model;
mod shape;

use crate::SampleBody;
use std::sync::OnceLock;
use supple::glam::DVec3;
use supple::model::Surface;

/// About an edge's length, m.
const CELL: f64 = 0.02;

fn body() -> &'static SampleBody {
    static BODY: OnceLock<SampleBody> = OnceLock::new();
    BODY.get_or_init(|| crate::body().expect("the built-in body is made"))
}

fn surface_of(positions: Vec<DVec3>) -> Surface {
    Surface {
        positions,
        triangles: body().model.triangles.clone(),
    }
}

fn skin() -> Surface {
    surface_of(body().model.template.clone())
}

fn joint(name: &str) -> usize {
    let names = &body().model.names;
    names.iter().position(|n| n == name).expect("a bone's name")
}

/// The same bone of the other side.
fn other_side(name: &str) -> String {
    match name.split_once('_') {
        Some(("left", rest)) => format!("right_{rest}"),
        Some(("right", rest)) => format!("left_{rest}"),
        _ => name.into(),
    }
}

/// Only β_k, at `value`.
fn betas(k: usize, value: f64) -> [f64; 10] {
    let mut betas = [0.0; 10];
    betas[k] = value;
    betas
}
