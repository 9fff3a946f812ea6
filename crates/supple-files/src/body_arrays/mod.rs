//! A body from a program's own arrays.

use crate::array::Array;
use crate::arrays::{Arrays, Item};
use crate::smpl::model_of;
use crate::{CharacterFile, PartNames};
use supple::Result;
use supple::model::{JointList, UpAxis};
use supple_bake::{Body, ParametricModel};

/// A skinned body as arrays in NumPy's C order, for bodies that no reader here knows. An `.npz` file with arrays of these
/// names is read as a character file, too. Bones may come in any order, the root first.
///
/// ```
/// use supple_files::BodyArrays;
///
/// let arrays = BodyArrays {
///     vertices: &[0.0, 0.0, 0.0, 0.1, 0.0, 0.0, 0.0, 0.1, 0.0, 0.0, 0.0, 0.1],
///     faces: &[0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3],
///     joints: &[0.02, 0.02, 0.02],
///     parents: &[-1],
///     weights: &[1.0; 4],
///     ..BodyArrays::default()
/// };
/// let body = arrays.body("tetrahedron", &[])?;
/// assert_eq!(body.skin.positions.len(), 4);
/// # Ok::<(), supple::Error>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BodyArrays<'a> {
    /// vertices × 3, m.
    pub vertices: &'a [f64],
    /// triangles × 3, counter-clockwise seen from outside.
    pub faces: &'a [u32],
    /// bones × 3, m; empty where there is a regressor.
    pub joints: &'a [f64],
    /// bones × vertices: shares of vertices in each joint, in place of `joints`.
    pub joint_regressor: &'a [f64],
    /// Each bone's parent by its place; −1 of the first.
    pub parents: &'a [i64],
    /// vertices × bones, rows sum to 1; or vertices × any, of the bones that `weight_bones` names.
    pub weights: &'a [f64],
    /// As many as `weights`, or none.
    pub weight_bones: &'a [u32],
    /// vertices × 3 × shapes, m a unit; or none.
    pub shape_directions: &'a [f64],
    /// bones × 3 × shapes, m a unit: how shapes move `joints`.
    pub joint_directions: &'a [f64],
    /// vertices × 3 × 9 (bones − 1), m a unit of R_j − I row by row (SMPL's `posedirs`); or none. What depends on the pose
    /// in another way a host gives once a step: `Character::set_pose_offsets`.
    pub pose_directions: &'a [f64],
    /// A name for each bone; numbered ones if none is given.
    pub names: &'a [&'a str],
    /// What points up; y if not given.
    pub up: Option<UpAxis>,
}

impl BodyArrays<'_> {
    /// The model that they are.
    ///
    /// # Errors
    /// [`supple::Error::Invalid`] naming the array, with what was expected and what was found.
    pub fn model(&self) -> Result<ParametricModel> {
        Ok(model_of(&self.arrays())?.model)
    }

    /// The body of the model's shape `betas`; missing ones are 0.
    ///
    /// # Errors
    /// As [`BodyArrays::model`].
    pub fn body(&self, name: &str, betas: &[f64]) -> Result<Body> {
        let model = model_of(&self.arrays())?;
        let mut body = Body::of_model(name, &model.model, betas, Vec::new());
        body.joints = JointList::of_bones_in_order(&body.skeleton, &model.file_order);
        body.up = self.up.unwrap_or(body.up);
        Ok(body)
    }

    /// What [`read_character`](crate::read_character) makes of an archive of these arrays: parts that are not tissue are
    /// attached, and an account of the vertices is kept.
    ///
    /// # Errors
    /// As [`BodyArrays::model`]; of shapes that are too many or not finite; of parts that are not there.
    pub fn character(&self, name: &str, betas: &[f64], parts: &PartNames) -> Result<CharacterFile> {
        let model = model_of(&self.arrays())?;
        let mut file = CharacterFile::of_model(name, model, betas, parts)?;
        file.body.up = self.up.unwrap_or(file.body.up);
        Ok(file)
    }

    /// The arrays by their names, in the shapes that their lengths tell.
    fn arrays(&self) -> Arrays {
        let (vertices, bones) = (self.vertices.len() / 3, self.parents.len());
        let per = |all: usize, rows: usize| all / rows.max(1);
        let shapes = |all: &[f64], rows| [rows, 3, per(all.len(), 3 * rows)];
        let columns = per(self.weights.len(), vertices);
        let mut arrays = Arrays::in_memory();
        let mut add = |name: &str, shape: &[usize], numbers: Vec<f64>| {
            // A length that fits no such shape is told as the length that it is.
            let fits = shape.iter().product::<usize>() == numbers.len();
            let shape = if fits {
                shape.to_vec()
            } else {
                vec![numbers.len()]
            };
            if !numbers.is_empty() {
                let texts = Vec::new();
                arrays.insert(
                    name,
                    Item::Dense(Array {
                        shape,
                        numbers,
                        texts,
                    }),
                );
            }
        };
        let indices = |all: &[u32]| all.iter().map(|i| f64::from(*i)).collect();
        add("vertices", &[vertices, 3], self.vertices.to_vec());
        add("faces", &[self.faces.len() / 3, 3], indices(self.faces));
        add("joints", &[bones, 3], self.joints.to_vec());
        add(
            "J_regressor",
            &[bones, vertices],
            self.joint_regressor.to_vec(),
        );
        add(
            "parents",
            &[bones],
            self.parents.iter().map(|p| *p as f64).collect(),
        );
        add("weights", &[vertices, columns], self.weights.to_vec());
        add(
            "weight_bones",
            &[vertices, columns],
            indices(self.weight_bones),
        );
        for (name, all, rows) in [
            ("shape_directions", self.shape_directions, vertices),
            ("joint_directions", self.joint_directions, bones),
            ("pose_directions", self.pose_directions, vertices),
        ] {
            add(name, &shapes(all, rows), all.to_vec());
        }
        // Numbered here, not by the number of bones: only SMPL's own files leave their names to be known.
        let names: Vec<String> = match self.names {
            [] => (0..bones).map(|j| format!("bone_{j}")).collect(),
            names => names.iter().map(ToString::to_string).collect(),
        };
        if !names.is_empty() {
            let shape = vec![names.len()];
            let (numbers, texts) = (Vec::new(), names);
            arrays.insert(
                "names",
                Item::Dense(Array {
                    shape,
                    numbers,
                    texts,
                }),
            );
        }
        arrays
    }
}

#[cfg(test)]
mod tests;
