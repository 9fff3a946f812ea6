//! An avatar: loaded, sampled, or made from arrays.

mod from_arrays;

use crate::arrays::{check_finite, matrix, numbers, triangles, vectors};
use crate::error::{OrRaise, invalid};
use crate::interrupt::in_background;
use crate::pose::PoseOrder;
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;
use pythonize::{depythonize, pythonize};
use std::path::PathBuf;
use std::sync::Arc;
use supple::file::Parts;
use supple::model::UpAxis;
use supple::{Error, Result};
use supple_bake::{BakeReport, Recipe, bake, baked_file, read_baked};
use supple_samples::Sample;
use supple_scene::{AvatarSource, SourceBody, avatar_source_of, read_recipe_for};

/// A baked avatar, which does not change.
#[pyclass(module = "supple", frozen)]
pub struct Avatar {
    pub inner: Arc<supple::model::Avatar>,
    pub order: PoseOrder,
    report: Option<BakeReport>,
    notes: Vec<String>,
    /// The file's own vertex that each skin vertex is; empty where nothing is known of it.
    file_vertices: Vec<u32>,
    /// What adds to the skin's rest shape by the pose.
    pub pose_offsets: Option<Py<PyAny>>,
}

impl Avatar {
    fn new(baked: Baked, pose_offsets: Option<Py<PyAny>>) -> Self {
        Self {
            order: PoseOrder::of(&baked.avatar),
            inner: Arc::new(baked.avatar),
            report: baked.report,
            notes: baked.notes,
            file_vertices: baked.file_vertices,
            pose_offsets,
        }
    }

    /// The file's vertex that skin vertex `v` is.
    pub fn file_vertex(&self, v: usize) -> usize {
        self.file_vertices.get(v).map_or(v, |v| *v as usize)
    }
}

/// What a bake, or a baked file, gives.
struct Baked {
    avatar: supple::model::Avatar,
    report: Option<BakeReport>,
    notes: Vec<String>,
    file_vertices: Vec<u32>,
}

/// An axis by its name.
pub fn up_axis(name: &str) -> PyResult<UpAxis> {
    match name {
        "x" => Ok(UpAxis::X),
        "y" => Ok(UpAxis::Y),
        "z" => Ok(UpAxis::Z),
        other => Err(invalid(
            "up",
            format!("{other:?} is no axis; give \"x\", \"y\" or \"z\""),
        )),
    }
}

/// A recipe: a file, or a dictionary as a file's `[bake]` table.
enum RecipeArgument {
    File(PathBuf),
    Table(Box<Recipe>),
}

fn recipe_argument(recipe: Option<&Bound<'_, PyAny>>) -> PyResult<Option<RecipeArgument>> {
    let Some(recipe) = recipe else {
        return Ok(None);
    };
    if let Ok(path) = recipe.extract::<PathBuf>() {
        return Ok(Some(RecipeArgument::File(path)));
    }
    let table = depythonize::<Recipe>(recipe).map_err(|e| {
        invalid(
            "recipe",
            format!("{e}; see docs/recipes.md for the keys of [bake]"),
        )
    })?;
    Ok(Some(RecipeArgument::Table(Box::new(table))))
}

/// A recipe where the body is known: a dictionary.
fn recipe_table(recipe: Option<&Bound<'_, PyAny>>) -> PyResult<Option<Recipe>> {
    match recipe_argument(recipe)? {
        None => Ok(None),
        Some(RecipeArgument::Table(recipe)) => Ok(Some(*recipe)),
        Some(RecipeArgument::File(_)) => {
            let problem = "a recipe file names its own body; give a dictionary of its [bake] keys";
            Err(invalid("recipe", problem))
        }
    }
}

/// Bakes `body`; an error that is not the recipe's is the file's.
fn baked(
    source: SourceBody,
    path: Option<&PathBuf>,
    progress: &mut dyn FnMut(usize),
) -> Result<Baked> {
    let SourceBody {
        body,
        recipe,
        file_vertices,
        mut notes,
    } = source;
    let named = |error: Error| match (&error, path) {
        (Error::Invalid { field, .. }, Some(path)) if field.inside("recipe").is_none() => {
            error.of_file(path)
        }
        _ => error,
    };
    let (avatar, report) = bake(&body, &recipe, &mut |phase| progress(phase)).map_err(named)?;
    notes.extend(report.notes.iter().cloned());
    Ok(Baked {
        avatar,
        report: Some(report),
        notes,
        file_vertices,
    })
}

/// Reads or bakes `source`.
fn read_source(
    source: AvatarSource,
    path: Option<PathBuf>,
    progress: &mut dyn FnMut(usize),
) -> Result<Baked> {
    if let AvatarSource::Baked(path) = &source {
        let read = read_baked(path)?;
        return Ok(Baked {
            notes: (read.report.iter()).flat_map(|r| r.notes.clone()).collect(),
            avatar: read.avatar,
            report: read.report,
            file_vertices: Vec::new(),
        });
    }
    let of_file = |e: Error| match &path {
        Some(path) => e.of_file(path),
        None => e,
    };
    baked(source.read().map_err(of_file)?, path.as_ref(), progress)
}

#[pymethods]
impl Avatar {
    /// Reads a character file (.pkl and .npz of SMPL, SMPL-H, SMPL-X and MANO, .glb, .gltf, .vrm, .obj, a recipe .toml) and
    /// bakes it, which takes seconds; or reads a baked .supple.
    ///
    /// betas: amounts of the model's shapes. betas_of: a motion of AMASS whose person's shape it takes. recipe: a TOML file,
    /// or a dictionary as its [bake] table. scale: m a unit of the file. up: the axis that points up in it. progress is
    /// called with (phases done, of all, name of the next).
    #[staticmethod]
    #[pyo3(signature = (path, betas=None, *, betas_of=None, recipe=None, scale=None, up=None, progress=None))]
    #[expect(clippy::too_many_arguments, reason = "they are keywords")]
    fn load(
        py: Python<'_>,
        path: PathBuf,
        betas: Option<Bound<'_, PyAny>>,
        betas_of: Option<PathBuf>,
        recipe: Option<Bound<'_, PyAny>>,
        scale: Option<f64>,
        up: Option<&str>,
        progress: Option<Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let of_file = |e: Error| e.of_file(&path);
        let mut source = match recipe_argument(recipe.as_ref())? {
            None => avatar_source_of(&path),
            Some(RecipeArgument::File(recipe)) => read_recipe_for(recipe, &path),
            Some(RecipeArgument::Table(recipe)) => {
                avatar_source_of(&path).and_then(|source| source.baked_by(*recipe).map_err(of_file))
            }
        }
        .or_raise()?;
        if let Some(betas) = betas {
            let betas = numbers(&betas, "betas")?.values;
            source.set_shape(&betas).map_err(of_file).or_raise()?;
        }
        if let Some(motion) = betas_of {
            source.set_shape_of(&motion).map_err(of_file).or_raise()?;
        }
        if let Some(scale) = scale {
            source.set_scale(scale).map_err(of_file).or_raise()?;
        }
        if let Some(up) = up {
            source.set_up(up_axis(up)?).map_err(of_file).or_raise()?;
        }
        let work = move |phases: &mut dyn FnMut(usize)| read_source(source, Some(path), phases);
        let read = in_background(py, progress.as_ref(), work)?;
        Ok(Self::new(read, None))
    }

    /// A body that the package makes itself: "hand", "body", "finger", "limb_s", "limb_m".
    #[staticmethod]
    #[pyo3(signature = (name="hand", betas=None, *, recipe=None, progress=None))]
    fn sample(
        py: Python<'_>,
        name: &str,
        betas: Option<Bound<'_, PyAny>>,
        recipe: Option<Bound<'_, PyAny>>,
        progress: Option<Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let sample = match name {
            "hand" => Sample::Hand,
            "body" => Sample::Body,
            "finger" => Sample::Finger,
            "limb_s" => Sample::LimbS,
            "limb_m" => Sample::LimbM,
            other => {
                let known = "\"hand\", \"body\", \"finger\", \"limb_s\" and \"limb_m\"";
                return Err(invalid(
                    "name",
                    format!("no sample is called {other:?}; there are {known}"),
                ));
            }
        };
        let mut source = AvatarSource::of_sample(sample);
        if let Some(betas) = betas {
            let betas = numbers(&betas, "betas")?;
            check_finite("betas", &betas)?;
            source.set_shape(&betas.values).or_raise()?;
        }
        if let Some(recipe) = recipe_table(recipe.as_ref())? {
            source = source.baked_by(recipe).or_raise()?;
        }
        let work = move |phases: &mut dyn FnMut(usize)| read_source(source, None, phases);
        let read = in_background(py, progress.as_ref(), work)?;
        Ok(Self::new(read, None))
    }

    /// Writes it as a baked file.
    #[pyo3(signature = (path, *, layer=true))]
    fn save(&self, py: Python<'_>, path: PathBuf, layer: bool) -> PyResult<()> {
        let parts = if layer { Parts::All } else { Parts::Step };
        py.detach(|| baked_file(&self.inner, self.report.as_ref())?.write(parts, &path))
            .or_raise()
    }

    /// What it is called.
    #[getter]
    fn name(&self) -> &str {
        &self.inner.name
    }

    /// The axis that points up in its file: "x", "y" or "z".
    #[getter]
    fn up(&self) -> &'static str {
        match self.inner.up {
            UpAxis::X => "x",
            UpAxis::Y => "y",
            UpAxis::Z => "z",
        }
    }

    /// V × 3, m: the skin in the bind pose, its shape in it. Vertices are in the order of the file, but where parts of it are no
    /// tissue or, of glTF files, seams are welded: see `file_vertices`.
    #[getter]
    fn skin<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        vectors(py, &self.inner.skin.position)
    }

    /// F × 3: triangles of the skin.
    #[getter]
    fn faces<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<i64>>> {
        triangles(py, &self.inner.triangles)
    }

    /// V, m²: the area of each vertex; 0 of what is merely attached.
    #[getter]
    fn areas<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, &self.inner.skin.measure)
    }

    /// B × 3, m: joints of the bones in the bind pose.
    #[getter]
    fn joints<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        vectors(py, &self.inner.skeleton.joints)
    }

    /// B: each bone's parent; −1 of a root.
    #[getter]
    fn parents<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<i64>> {
        let parents = self.inner.skeleton.parents.iter();
        let parents: Vec<i64> = parents.map(|p| p.map_or(-1, i64::from)).collect();
        PyArray1::from_vec(py, parents)
    }

    /// B names of bones: of `joints`, `parents`, `weights`, loads and frames.
    #[getter]
    fn bone_names(&self) -> Vec<String> {
        self.inner.skeleton.names.clone()
    }

    /// J names: the joints that poses have rotations of, in their order. It is the file's own order where that has no rest
    /// rotations (SMPL's files, `from_arrays`), and that of the bones else (glTF).
    #[getter]
    fn pose_names(&self) -> Vec<String> {
        self.order.names.clone()
    }

    /// V × B: skin weights.
    #[getter]
    fn weights<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let (skin, bones) = (&self.inner.skin, self.inner.skeleton.len());
        let mut dense = vec![0.0; skin.len() * bones];
        for (v, row) in skin.skinning.iter().enumerate() {
            row.iter()
                .for_each(|w| dense[v * bones + w.bone as usize] += w.weight);
        }
        matrix(py, dense, bones)
    }

    /// H × 3, m: where the handles of the tissue are.
    #[getter]
    fn handles<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        vectors(py, &self.inner.handles)
    }

    /// C × 3, m: points of the tissue that carry mass and elasticity.
    #[getter]
    fn cubature_points<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        vectors(py, &self.inner.cubature.position)
    }

    /// C, m³: the volume that each stands for.
    #[getter]
    fn cubature_weights<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, &self.inner.cubature.measure)
    }

    /// V: the file's own vertex that each vertex of the skin is; None where nobody kept account of them (glTF, baked files).
    #[getter]
    fn file_vertices<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyArray1<i64>>> {
        let known = !self.file_vertices.is_empty();
        let vertices = || self.file_vertices.iter().map(|v| i64::from(*v)).collect();
        known.then(|| PyArray1::from_vec(py, vertices()))
    }

    /// Degrees of freedom: 6 a bone, 3 a handle.
    #[getter]
    fn dofs(&self) -> usize {
        self.inner.space().dofs()
    }

    /// kg.
    #[getter]
    fn tissue_mass(&self) -> f64 {
        self.inner.tissue_mass()
    }

    /// What was decided about the file and in the bake, a sentence each.
    #[getter]
    fn notes(&self) -> Vec<String> {
        self.notes.clone()
    }

    /// What the bake did, as a dictionary; None where a baked file has none.
    #[getter]
    fn report<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        let told = self.report.as_ref().map(|report| pythonize(py, report));
        told.transpose()
            .map_err(|e| invalid("report", e.to_string()))
    }

    fn __repr__(&self) -> String {
        let avatar = &self.inner;
        format!(
            "<supple.Avatar {:?}: {} vertices, {} bones, {} handles>",
            avatar.name,
            avatar.skin.len(),
            avatar.skeleton.len(),
            avatar.handles.len()
        )
    }
}
