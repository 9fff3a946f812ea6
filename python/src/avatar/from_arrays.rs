//! An avatar of a body that is there as arrays.

use super::{Avatar, baked, recipe_table, up_axis};
use crate::arrays::{Length, finite, numbers, wrong_shape};
use crate::error::{OrRaise, invalid};
use crate::interrupt::in_background;
use pyo3::prelude::*;
use supple_bake::Body;
use supple_files::{BodyArrays, PartNames};
use supple_scene::SourceBody;

#[pymethods]
impl Avatar {
    /// A skinned body of the program's own. V vertices, F triangles, J joints, S shapes.
    ///
    /// vertices: V × 3, m. faces: F × 3, counter-clockwise seen from outside. joints: J × 3, m, or None with a
    /// joint_regressor (J × V). parents: J, −1 of the root (SMPL's kintree_table does too). weights: V × J; V × any with
    /// weight_bones of the same shape. shape_directions: V × 3 × S, joint_directions: J × 3 × S, with betas. pose_offsets:
    /// V × 3 × 9(J−1), SMPL's posedirs; or a function that is given the pose (J × 3, rad) of each step and returns what it
    /// adds to the vertices (V × 3, m). tissue, rigid: names of parts that are so, against what is chosen.
    #[staticmethod]
    #[pyo3(signature = (
        vertices, faces, joints, parents, weights, *, names=None, shape_directions=None, joint_directions=None,
        joint_regressor=None, weight_bones=None, pose_offsets=None, betas=None, tissue=Vec::new(), rigid=Vec::new(),
        up="y", name="avatar", recipe=None, progress=None
    ))]
    #[expect(clippy::too_many_arguments, reason = "they are keywords")]
    fn from_arrays(
        py: Python<'_>,
        vertices: Bound<'_, PyAny>,
        faces: Bound<'_, PyAny>,
        joints: Option<Bound<'_, PyAny>>,
        parents: Bound<'_, PyAny>,
        weights: Bound<'_, PyAny>,
        names: Option<Vec<String>>,
        shape_directions: Option<Bound<'_, PyAny>>,
        joint_directions: Option<Bound<'_, PyAny>>,
        joint_regressor: Option<Bound<'_, PyAny>>,
        weight_bones: Option<Bound<'_, PyAny>>,
        pose_offsets: Option<Bound<'_, PyAny>>,
        betas: Option<Bound<'_, PyAny>>,
        tissue: Vec<String>,
        rigid: Vec<String>,
        up: &str,
        name: &str,
        recipe: Option<Bound<'_, PyAny>>,
        progress: Option<Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let three = (Some(3), "");
        let vertices = finite(&vertices, "vertices", &[(None, "V"), three])?;
        let count = (Some(vertices.shape[0]), "V");
        let faces = indices(&faces, "faces", &[(None, "F"), three])?;
        let parents = numbers(&parents, "parents")?;
        let bones = match parents.shape[..] {
            [bones] => (Some(bones), "J"),
            // SMPL's kintree_table: parents above, the bones' own numbers below.
            [2, bones] => (Some(bones), "J"),
            _ => return Err(wrong_shape("parents", &parents.shape, &[&[(None, "J")]])),
        };
        let parents = parents_of(&parents.values[..bones.0.unwrap_or(0)])?;
        let optional = |object: &Option<Bound<'_, PyAny>>, field: &str, shape: &[Length<'_>]| {
            let read = object.as_ref().map(|o| finite(o, field, shape));
            Ok::<_, PyErr>(read.transpose()?.map(|n| n.values).unwrap_or_default())
        };
        let joints = optional(&joints, "joints", &[bones, three])?;
        let joint_regressor = optional(&joint_regressor, "joint_regressor", &[bones, count])?;
        let columns = match weight_bones {
            Some(_) => (None, "W"),
            None => bones,
        };
        let weights = finite(&weights, "weights", &[count, columns])?;
        let columns = (Some(weights.shape[1]), "W");
        let weight_bones = match &weight_bones {
            Some(object) => indices(object, "weight_bones", &[count, columns])?,
            None => Vec::new(),
        };
        let shapes = [count, three, (None, "S")];
        let shape_directions = optional(&shape_directions, "shape_directions", &shapes)?;
        let shapes = [bones, three, (None, "S")];
        let joint_directions = optional(&joint_directions, "joint_directions", &shapes)?;
        let callable = pose_offsets
            .as_ref()
            .filter(|offsets| offsets.is_callable());
        let callable = callable.map(|offsets| offsets.clone().unbind());
        let directions = pose_offsets.filter(|_| callable.is_none());
        let features = 9 * (bones.0.unwrap_or(0).saturating_sub(1));
        let columns = [count, three, (Some(features), "9(J-1)")];
        let pose_directions = optional(&directions, "pose_offsets", &columns)?;
        let betas = match &betas {
            Some(betas) => numbers(betas, "betas")?.values,
            None => Vec::new(),
        };
        if let Some(names) = &names
            && Some(names.len()) != bones.0
        {
            let found = [names.len()];
            return Err(wrong_shape("names", &found, &[&[bones]]));
        }
        let names: Vec<&str> = names.iter().flatten().map(String::as_str).collect();
        let arrays = BodyArrays {
            vertices: &vertices.values,
            faces: &faces,
            joints: &joints,
            joint_regressor: &joint_regressor,
            parents: &parents,
            weights: &weights.values,
            weight_bones: &weight_bones,
            shape_directions: &shape_directions,
            joint_directions: &joint_directions,
            pose_directions: &pose_directions,
            names: &names,
            up: Some(up_axis(up)?),
        };
        let parts = PartNames { tissue, rigid };
        let file = arrays.character(name, &betas, &parts).or_raise()?;
        let body: Body = file.body;
        let recipe = recipe_table(recipe.as_ref())?.unwrap_or_default();
        let source = SourceBody {
            body,
            recipe,
            file_vertices: file.file_vertices,
            notes: file.notes,
        };
        let work = move |phases: &mut dyn FnMut(usize)| baked(source, None, phases);
        let read = in_background(py, progress.as_ref(), work)?;
        Ok(Self::new(read, callable))
    }
}

/// Whole numbers that are not negative.
fn indices(object: &Bound<'_, PyAny>, field: &str, shape: &[Length<'_>]) -> PyResult<Vec<u32>> {
    let found = finite(object, field, shape)?;
    let index = |(at, v): (usize, &f64)| match *v {
        v if v >= 0.0 && v <= f64::from(u32::MAX) && v.fract() == 0.0 => Ok(v as u32),
        v => {
            let width = found.shape.last().copied().unwrap_or(1).max(1);
            let field = format!("{field}[{}, {}]", at / width, at % width);
            Err(invalid(&field, format!("{v} is no index")))
        }
    };
    found.values.iter().enumerate().map(index).collect()
}

/// Parents by their place: a root's is −1, or what files of SMPL have for it.
fn parents_of(values: &[f64]) -> PyResult<Vec<i64>> {
    const ROOTS: [f64; 2] = [u32::MAX as f64, u64::MAX as f64];
    let parent = |(j, p): (usize, &f64)| match *p {
        p if ROOTS.contains(&p) => Ok(-1),
        p if p.fract() == 0.0 => Ok(p as i64),
        p => Err(invalid(
            &format!("parents[{j}]"),
            format!("{p} is no index"),
        )),
    };
    values.iter().enumerate().map(parent).collect()
}
