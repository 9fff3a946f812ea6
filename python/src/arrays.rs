//! numpy arrays in and out.

use crate::error::invalid;
use numpy::{PyArray1, PyArray2, PyArrayDyn, PyArrayMethods, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use supple::glam::{DMat3, DVec3};

/// Numbers in C order, and the shape that they have.
pub struct Numbers {
    pub shape: Vec<usize>,
    pub values: Vec<f64>,
}

/// A length that an array may have: any, or so many of something.
pub type Length<'a> = (Option<usize>, &'a str);

/// What `numpy.asarray` makes of `object`, which may be a list, a sparse matrix, or what another library has.
pub fn numbers(object: &Bound<'_, PyAny>, field: &str) -> PyResult<Numbers> {
    let py = object.py();
    let unreadable = |_| {
        let kind = object.get_type().name().map(|n| n.to_string());
        let kind = kind.unwrap_or_default();
        invalid(
            field,
            format!("a {kind} holds no numbers: give an array of floats"),
        )
    };
    // A regressor of SMPL's own files is a sparse matrix.
    let dense = match object.getattr_opt("toarray")? {
        Some(to_array) => to_array.call0()?,
        None => object.clone(),
    };
    let kwargs = PyDict::new(py);
    kwargs.set_item("dtype", "float64")?;
    let array = py
        .import("numpy")?
        .call_method("ascontiguousarray", (&dense,), Some(&kwargs));
    let array = array.map_err(unreadable)?;
    // `ascontiguousarray` makes a single number a list of one.
    let array = array.cast_into::<PyArrayDyn<f64>>()?;
    let read = array.readonly();
    let values = read.as_slice().map_err(|e| invalid(field, e.to_string()))?;
    Ok(Numbers {
        shape: array.shape().to_vec(),
        values: values.to_vec(),
    })
}

/// [`numbers`] of this shape, all of them finite.
pub fn finite(object: &Bound<'_, PyAny>, field: &str, shape: &[Length<'_>]) -> PyResult<Numbers> {
    let found = numbers(object, field)?;
    let fits = found.shape.len() == shape.len()
        && (found.shape.iter().zip(shape)).all(|(n, (wanted, _))| wanted.is_none_or(|w| w == *n));
    if !fits {
        return Err(wrong_shape(field, &found.shape, &[shape]));
    }
    check_finite(field, &found)?;
    Ok(found)
}

/// An error unless all are finite; it names the first that is not.
pub fn check_finite(field: &str, numbers: &Numbers) -> PyResult<()> {
    let Some(at) = numbers.values.iter().position(|v| !v.is_finite()) else {
        return Ok(());
    };
    let mut index = Vec::new();
    let mut rest = at;
    for n in numbers.shape.iter().rev() {
        index.insert(0, (rest % n).to_string());
        rest /= n;
    }
    let field = format!("{field}[{}]", index.join(", "));
    // As Python writes it: nan, inf.
    let value = numbers.values[at].to_string().to_lowercase();
    Err(invalid(&field, format!("{value} is not finite")))
}

/// The error of a shape that is none of those `expected`.
pub fn wrong_shape(field: &str, found: &[usize], expected: &[&[Length<'_>]]) -> PyErr {
    let one = |shape: &&[Length<'_>]| {
        let lengths = shape.iter().map(|(length, name)| match length {
            Some(n) if name.is_empty() => n.to_string(),
            Some(n) => format!("{name}={n}"),
            None => name.to_string(),
        });
        let lengths: Vec<String> = lengths.collect();
        match &lengths[..] {
            [only] => format!("({only},)"),
            several => format!("({})", several.join(", ")),
        }
    };
    let expected: Vec<String> = expected.iter().map(one).collect();
    let found = one(&&found.iter().map(|n| (Some(*n), "")).collect::<Vec<_>>()[..]);
    let problem = format!("has the shape {found}; expected {}", expected.join(" or "));
    invalid(field, problem)
}

/// A finite vector.
pub fn vector(object: &Bound<'_, PyAny>, field: &str) -> PyResult<DVec3> {
    let found = finite(object, field, &[(Some(3), "")])?;
    Ok(DVec3::from_slice(&found.values))
}

/// A rotation: a matrix, or a rotation vector (rad).
pub fn rotation(object: &Bound<'_, PyAny>, field: &str) -> PyResult<DMat3> {
    let found = numbers(object, field)?;
    check_finite(field, &found)?;
    match found.shape[..] {
        [3] => Ok(supple::internal::math::rotation_exp(DVec3::from_slice(
            &found.values,
        ))),
        // numpy's rows are glam's columns of the transpose.
        [3, 3] => Ok(DMat3::from_cols_slice(&found.values).transpose()),
        _ => {
            let expected: [&[Length<'_>]; 2] = [&[(Some(3), "")], &[(Some(3), ""), (Some(3), "")]];
            Err(wrong_shape(field, &found.shape, &expected))
        }
    }
}

/// Rows of `width` numbers.
pub fn matrix<'py>(
    py: Python<'py>,
    values: Vec<f64>,
    width: usize,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let rows = values.len() / width.max(1);
    PyArray1::from_vec(py, values).reshape([rows, width])
}

/// n × 3 numbers.
pub fn vectors<'py>(py: Python<'py>, points: &[DVec3]) -> PyResult<Bound<'py, PyArray2<f64>>> {
    matrix(py, flat(points), 3)
}

/// The components one after the other.
pub fn flat(points: &[DVec3]) -> Vec<f64> {
    points.iter().flat_map(DVec3::to_array).collect()
}

/// n × 3 indices.
pub fn triangles<'py>(
    py: Python<'py>,
    triangles: &[[u32; 3]],
) -> PyResult<Bound<'py, PyArray2<i64>>> {
    let indices: Vec<i64> = triangles.iter().flatten().map(|i| i64::from(*i)).collect();
    PyArray1::from_vec(py, indices).reshape([triangles.len(), 3])
}
