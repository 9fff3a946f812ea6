//! KHR_draco_mesh_compression: the vertices and triangles of a primitive in a stream of Draco's.
//!
//! The stream is read by `draco-core`, which is pure Rust and takes limits on what it may become.

use super::Problem;
use draco_core::{DecodeLimits, DecoderBuffer, Mesh, MeshDecoder};

/// Bytes of a vertex, all attributes together. A character's has some 100.
const MOST_BYTES_PER_POINT: u64 = 512;

/// What a stream holds.
pub(in crate::gltf) struct DracoMesh {
    mesh: Mesh,
}

impl DracoMesh {
    /// Decompresses `bytes`, if that gives at most so many vertices, and twice as many triangles.
    pub fn new(bytes: &[u8], most_points: u64) -> Result<Self, Problem> {
        let limits = DecodeLimits::default()
            .with_max_points(most_points)
            .with_max_faces(most_points.saturating_mul(2))
            .with_max_decoded_bytes(most_points.saturating_mul(MOST_BYTES_PER_POINT));
        let mut mesh = Mesh::new();
        let mut buffer = DecoderBuffer::new(bytes).with_limits(limits);
        let decoded = MeshDecoder::new().decode(&mut buffer, &mut mesh);
        decoded.map_err(|e| format!("Draco data that are broken: {e}"))?;
        if mesh.num_points() as u64 > most_points {
            return Err("Draco data of more vertices than a file of this size may have".into());
        }
        Ok(Self { mesh })
    }

    /// Number of vertices.
    pub fn points(&self) -> usize {
        self.mesh.num_points()
    }

    /// Vertices of the triangles, all of them there.
    pub fn indices(&self) -> Result<Vec<u32>, Problem> {
        let points = self.points();
        let corners = self.mesh.faces().iter().flatten().map(|point| point.0);
        let indices: Vec<u32> = corners.collect();
        match indices.iter().find(|v| **v as usize >= points) {
            None => Ok(indices),
            Some(v) => Err(format!("Draco data that name vertex {v} of {points}")),
        }
    }

    /// `width` numbers of each vertex of the attribute with this id; whole ones as they are, whether they stand for
    /// fractions or not.
    pub fn attribute(&self, id: u32, width: usize) -> Result<Vec<f64>, Problem> {
        let found = self.mesh.attribute_by_unique_id(id);
        let found = found.ok_or_else(|| format!("Draco data without attribute {id}"))?;
        if usize::from(found.num_components()) != width {
            let components = found.num_components();
            return Err(format!(
                "Draco attribute {id} of {components} components; {width} are needed"
            ));
        }
        let values = found.read_f32s(self.points(), width);
        match values.iter().all(|v| v.is_finite()) {
            true => Ok(values.into_iter().map(f64::from).collect()),
            false => Err(format!(
                "Draco attribute {id} holds a value that is not finite"
            )),
        }
    }
}
