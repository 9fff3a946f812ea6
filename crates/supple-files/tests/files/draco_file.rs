//! Files whose mesh is a stream of Draco's.

use crate::gltf::fixture::*;
use draco_core::{
    DataType, EncoderBuffer, EncoderOptions, FaceIndex, GeometryAttributeType, Mesh, MeshEncoder,
    PointAttribute, PointIndex,
};
use glam::DVec3;
use serde_json::json;

/// What is compressed, in the order of the ids.
pub const ATTRIBUTES: [&str; 5] = ["POSITION", "JOINTS_0", "WEIGHTS_0", "TEXCOORD_0", "NORMAL"];

/// A normal of each vertex of a bar: away from its middle.
fn normals(bar: &Bar) -> Vec<DVec3> {
    let middle = DVec3::X * 0.5 * LENGTH;
    bar.positions
        .iter()
        .map(|p| (*p - middle).normalize())
        .collect()
}

/// A bar with normals, and texture coordinates that say how far along a vertex is.
pub fn bar() -> Fixture {
    let mut file = bar_file(&BarFile::default());
    let bar = Bar::new(10, 0.05);
    let coordinates: Vec<[f32; 2]> = bar.positions.iter().map(|p| [p.x as f32, 0.5]).collect();
    let coordinates = file.floats("VEC2", &coordinates);
    let normals = file.vectors(&normals(&bar));
    let attributes = &mut file.json["meshes"][0]["primitives"][0]["attributes"];
    attributes["TEXCOORD_0"] = json!(coordinates);
    attributes["NORMAL"] = json!(normals);
    file
}

/// The same, compressed; numbers as they are, not rounded.
pub fn draco_bar(options: &EncoderOptions) -> Fixture {
    with_stream(&stream(options))
}

/// The same with this stream.
pub fn with_stream(coded: &[u8]) -> Fixture {
    let mut file = bar();
    let view = file.view(coded);
    let ids = ATTRIBUTES
        .iter()
        .enumerate()
        .map(|(id, name)| (name.to_string(), json!(id)));
    let ids: serde_json::Map<_, _> = ids.collect();
    let primitive = &mut file.json["meshes"][0]["primitives"][0];
    let draco = json!({"bufferView": view, "attributes": ids});
    primitive["extensions"] = json!({"KHR_draco_mesh_compression": draco});
    let accessors = ATTRIBUTES.map(|name| primitive["attributes"][name].as_u64().unwrap() as usize);
    let indices = primitive["indices"].as_u64().unwrap() as usize;
    for accessor in accessors.into_iter().chain([indices]) {
        file.json["accessors"][accessor]
            .as_object_mut()
            .unwrap()
            .remove("bufferView");
    }
    file.json["extensionsRequired"] = json!(["KHR_draco_mesh_compression"]);
    file
}

/// The stream in [`draco_bar`].
pub fn stream(options: &EncoderOptions) -> Vec<u8> {
    let bar = Bar::new(10, 0.05);
    let mut mesh = Mesh::new();
    let count = bar.positions.len();
    let (joints, weights) = bar.influences();
    let positions: Vec<f32> = (bar.positions.iter())
        .flat_map(|p| p.as_vec3().to_array())
        .collect();
    let coordinates: Vec<f32> = bar
        .positions
        .iter()
        .flat_map(|p| [p.x as f32, 0.5])
        .collect();
    let normals: Vec<f32> = (normals(&bar).iter())
        .flat_map(|n| n.as_vec3().to_array())
        .collect();
    let bytes =
        |values: &[f32]| -> Vec<u8> { values.iter().flat_map(|v| v.to_le_bytes()).collect() };
    use GeometryAttributeType as Kind;
    for (kind, width, data_type, bytes) in [
        (Kind::Position, 3, DataType::Float32, bytes(&positions)),
        (
            Kind::Generic,
            4,
            DataType::Uint8,
            joints.as_flattened().to_vec(),
        ),
        (
            Kind::Generic,
            4,
            DataType::Float32,
            bytes(weights.as_flattened()),
        ),
        (Kind::TexCoord, 2, DataType::Float32, bytes(&coordinates)),
        (Kind::Normal, 3, DataType::Float32, bytes(&normals)),
    ] {
        let mut attribute = PointAttribute::new();
        attribute.init(kind, width, data_type, false, count);
        attribute.buffer_mut().write(0, &bytes);
        mesh.add_attribute(attribute);
    }
    mesh.set_num_faces(bar.triangles.len());
    for (f, t) in bar.triangles.iter().enumerate() {
        mesh.set_face(FaceIndex(f as u32), t.map(|v| PointIndex(v.into())));
    }
    let mut encoder = MeshEncoder::new();
    encoder.set_mesh(mesh);
    let mut out = EncoderBuffer::new();
    encoder.encode(options, &mut out).unwrap();
    out.data().to_vec()
}
