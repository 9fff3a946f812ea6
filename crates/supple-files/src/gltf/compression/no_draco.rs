//! What stands in for Draco in a build without its feature.

use super::Problem;

/// A stream that is not read.
pub(in crate::gltf) enum DracoMesh {}

impl DracoMesh {
    /// Always an error.
    pub fn new(_bytes: &[u8], _most_points: u64) -> Result<Self, Problem> {
        Err("KHR_draco_mesh_compression: this build is without the feature draco".into())
    }

    pub fn points(&self) -> usize {
        match *self {}
    }

    pub fn indices(&self) -> Result<Vec<u32>, Problem> {
        match *self {}
    }

    pub fn attribute(&self, _id: u32, _width: usize) -> Result<Vec<f64>, Problem> {
        match *self {}
    }
}
