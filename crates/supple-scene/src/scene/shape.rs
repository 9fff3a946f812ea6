//! The solids of a scene, as TOML names them.

use serde::{Deserialize, Serialize};
use std::ops::Deref;
use std::path::{Path, PathBuf};
use supple::collider::{MeshShape, Shape};
use supple::model::Surface;
use supple::{Error, Result};
use supple_files::read_closed_obj;
use toml::Value;

/// A solid; one that is a triangle mesh keeps the name of its file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Key", into = "Key")]
pub struct SceneShape {
    shape: Shape,
    file: PathBuf,
}

impl From<Shape> for SceneShape {
    fn from(shape: Shape) -> Self {
        Self {
            shape,
            file: PathBuf::new(),
        }
    }
}

impl Deref for SceneShape {
    type Target = Shape;

    fn deref(&self) -> &Shape {
        &self.shape
    }
}

impl SceneShape {
    /// The OBJ file of a mesh; empty where the shape comes from none.
    pub fn file(&self) -> &Path {
        &self.file
    }
}

/// What a scene's text says.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(tag = "shape", rename_all = "snake_case", deny_unknown_fields)]
enum Key {
    HalfSpace,
    Sphere { radius: f64 },
    Capsule { radius: f64, half_length: f64 },
    Cylinder { radius: f64, half_length: f64 },
    Box { half_extents: [f64; 3] },
    Mesh { file: PathBuf },
}

impl From<SceneShape> for Key {
    fn from(from: SceneShape) -> Self {
        match from.shape {
            Shape::HalfSpace => Self::HalfSpace,
            Shape::Sphere { radius } => Self::Sphere { radius },
            Shape::Capsule {
                radius,
                half_length,
            } => Self::Capsule {
                radius,
                half_length,
            },
            Shape::Cylinder {
                radius,
                half_length,
            } => Self::Cylinder {
                radius,
                half_length,
            },
            Shape::Box { half_extents } => Self::Box { half_extents },
            Shape::Mesh(_) => Self::Mesh { file: from.file },
        }
    }
}

impl TryFrom<Key> for SceneShape {
    type Error = Error;

    fn try_from(key: Key) -> Result<Self> {
        Ok(match key {
            Key::HalfSpace => Shape::HalfSpace.into(),
            Key::Sphere { radius } => Shape::Sphere { radius }.into(),
            Key::Capsule {
                radius,
                half_length,
            } => Shape::Capsule {
                radius,
                half_length,
            }
            .into(),
            Key::Cylinder {
                radius,
                half_length,
            } => Shape::Cylinder {
                radius,
                half_length,
            }
            .into(),
            Key::Box { half_extents } => Shape::Box { half_extents }.into(),
            Key::Mesh { file } => Self {
                shape: Shape::Mesh(read_mesh(&file)?),
                file,
            },
        })
    }
}

/// The solid in a file: its objects together.
fn read_mesh(path: &Path) -> Result<MeshShape> {
    let mut whole = Surface::default();
    for (_, surface) in read_closed_obj(path)? {
        let first = whole.positions.len() as u32;
        whole.positions.extend(surface.positions);
        let triangles = surface.triangles.iter().map(|t| t.map(|v| first + v));
        whole.triangles.extend(triangles);
    }
    MeshShape::new(&whole).map_err(|e| e.of_file(path))
}

/// The files of meshes in a scene's `table`, each with its key, to be changed before anything is read.
pub(super) fn mesh_files(table: &mut toml::Table) -> Vec<(String, &mut String)> {
    let mut files = Vec::new();
    for (list, items) in table.iter_mut() {
        if !matches!(list.as_str(), "colliders" | "bodies") {
            continue;
        }
        for (i, item) in items.as_array_mut().into_iter().flatten().enumerate() {
            let shape = item.get_mut("shape").and_then(Value::as_table_mut);
            if let Some(Value::String(file)) = shape.and_then(|s| s.get_mut("file")) {
                files.push((format!("{list}[{i}].shape.file"), file));
            }
        }
    }
    files
}
