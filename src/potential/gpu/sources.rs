//! The kernels' texts, and how one is composed from them.

use super::stage_list::with_stages;
use crate::collider::Shape;
use crate::gpu::Module;
use crate::material::Material;
use crate::{GpuError, Result};
use std::borrow::Cow;
use std::fmt::Write;

macro_rules! texts {
    ($($path:literal),* $(,)?) => {
        &[$(($path, include_str!(concat!("../../../kernels/", $path)))),*]
    };
}

/// Files under `kernels/` that stages are composed of.
const PARTS: &[(&str, &str)] = texts![
    "shared/batch.wgsl",
    "shared/kinematics.wgsl",
    "shared/point_motion.wgsl",
    "shared/tensor.wgsl",
    "shared/decomposition.wgsl",
    "shared/distance.wgsl",
    "shared/contact.wgsl",
    "shared/contact_stiffness.wgsl",
    "shared/friction.wgsl",
    "shared/exclusive_sum.wgsl",
    "shared/tissue.wgsl",
    "shared/neo_hookean.wgsl",
    "shared/neo_hookean_modes.wgsl",
    "shared/exponential.wgsl",
    "shared/positive_part.wgsl",
    "material/fung_neo_hookean.wgsl",
    "material/orthotropic.wgsl",
    "material/stable_neo_hookean.wgsl",
    "collider/half_space.wgsl",
    "collider/sphere.wgsl",
    "collider/capsule.wgsl",
    "collider/cylinder.wgsl",
    "collider/box.wgsl",
    "collider/mesh.wgsl",
];

macro_rules! stage_texts {
    ($($name:ident: $stage:ident,)*) => {
        &[$((
            concat!(stringify!($name), ".wgsl"),
            include_str!(concat!("../../../kernels/", stringify!($name), ".wgsl")),
        )),*]
    };
}

/// The stages' own files.
const STAGES: &[(&str, &str)] = with_stages!(stage_texts);

/// Stands for the files of the avatar's material in a list of includes.
pub(super) const MATERIAL: &str = "material";
/// Stands for the files of all shapes and the switch between them in a list of includes.
pub(super) const SHAPES: &str = "shapes";

/// The texts that one avatar's kernels are made of.
#[derive(Clone, Debug)]
pub struct Sources {
    files: Vec<(&'static str, Cow<'static, str>)>,
    material: &'static [&'static str],
}

impl Sources {
    /// The texts for tissue of `material`.
    pub fn new(material: &Material) -> Self {
        Self {
            files: (PARTS.iter().chain(STAGES))
                .map(|&(path, text)| (path, Cow::Borrowed(text)))
                .collect(),
            material: material.kernels(),
        }
    }

    /// Which material law they are for, by the files of its texts.
    pub(super) fn material(&self) -> &'static [&'static str] {
        self.material
    }

    /// Paths of all files, under `kernels/`.
    pub fn paths(&self) -> impl Iterator<Item = &'static str> {
        self.files.iter().map(|(path, _)| *path)
    }

    /// The same with `from`, which must occur exactly once in the file `path`, replaced by `to`: tests
    /// break kernels with it.
    ///
    /// # Errors
    /// [`GpuError::Shader`] where the file is unknown or `from` does not occur exactly once.
    pub fn edited(mut self, path: &str, from: &str, to: &str) -> Result<Self> {
        let fail = |message: String| GpuError::Shader {
            kernel: path.to_owned(),
            message,
        };
        let (_, text) = (self.files.iter_mut())
            .find(|(name, _)| *name == path)
            .ok_or_else(|| fail("there is no such file".to_owned()))?;
        let count = text.matches(from).count();
        if count != 1 {
            return Err(fail(format!("`{from}` occurs {count} times")).into());
        }
        *text = Cow::Owned(text.replace(from, to));
        Ok(self)
    }

    /// The module of stage `name`: `includes` in order, then its own file.
    ///
    /// # Errors
    /// [`GpuError::Shader`] where a file is unknown or the whole does not compile.
    pub fn module(&self, name: &str, includes: &[&str]) -> Result<Module> {
        let mut source = String::new();
        for &path in includes {
            match path {
                MATERIAL => {
                    for path in self.material {
                        self.append(name, path, &mut source)?;
                    }
                }
                SHAPES => {
                    // Not those of `Shape::examples`: a mesh is made on all threads, which here may wait for one another.
                    for path in Shape::KERNELS {
                        self.append(name, path, &mut source)?;
                    }
                    source.push_str(&shape_switch());
                }
                _ => self.append(name, path, &mut source)?,
            }
        }
        self.append(name, &format!("{name}.wgsl"), &mut source)?;
        Module::parse(name, source)
    }

    fn append(&self, name: &str, path: &str, source: &mut String) -> Result<()> {
        let (_, text) = (self.files.iter())
            .find(|(file, _)| *file == path)
            .ok_or_else(|| GpuError::Shader {
                kernel: name.to_owned(),
                message: format!("kernels/{path} is not in the list of texts"),
            })?;
        source.push_str(text);
        source.push('\n');
        Ok(())
    }
}

/// The function that calls a shape's own by its number. The shape in `collider/x.wgsl` is `x_distance`.
fn shape_switch() -> String {
    let mut out = String::from(
        "fn signed_distance(shape: u32, parameters: vec4<f32>, p: vec3<f32>) -> SignedDistance {\n\
         switch shape {\n",
    );
    for (index, path) in Shape::KERNELS.into_iter().enumerate() {
        let file = path.rsplit('/').next().unwrap_or(path);
        let stem = file.trim_end_matches(".wgsl");
        // Writing to a String cannot fail.
        let _ = writeln!(
            out,
            "case {index}u: {{ return {stem}_distance(parameters, p); }}"
        );
    }
    out.push_str("default: { return SignedDistance(vec3<f32>(), 0.0); }\n}\n}\n");
    out
}
