//! The JSON of a glTF 2.0 file: what this crate reads of it (glTF 2.0 specification, chapter 5).

use serde::Deserialize;
use serde_json::Value;
use std::collections::BTreeMap;

/// The root object.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Document {
    pub asset: Asset,
    #[serde(default)]
    pub extensions_required: Vec<String>,
    #[serde(default)]
    pub extensions: Extensions,
    pub scene: Option<usize>,
    #[serde(default)]
    pub scenes: Vec<Scene>,
    #[serde(default)]
    pub nodes: Vec<Node>,
    #[serde(default)]
    pub meshes: Vec<Mesh>,
    #[serde(default)]
    pub materials: Vec<Value>,
    #[serde(default)]
    pub textures: Vec<Value>,
    #[serde(default)]
    pub samplers: Vec<Value>,
    #[serde(default)]
    pub images: Vec<Image>,
    #[serde(default)]
    pub skins: Vec<Skin>,
    #[serde(default)]
    pub accessors: Vec<Accessor>,
    #[serde(default)]
    pub buffer_views: Vec<BufferView>,
    #[serde(default)]
    pub buffers: Vec<Buffer>,
    #[serde(default)]
    pub animations: Vec<Animation>,
}

/// Versions that the file states.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Asset {
    pub version: String,
    pub min_version: Option<String>,
}

/// The extensions of the root object that are read.
#[derive(Debug, Default, Deserialize)]
pub(super) struct Extensions {
    #[serde(rename = "VRM")]
    pub vrm_0: Option<Value>,
    #[serde(rename = "VRMC_vrm")]
    pub vrm_1: Option<Value>,
    #[serde(rename = "VRMC_vrm_animation")]
    pub vrm_animation: Option<Value>,
    #[serde(rename = "VRMC_springBone")]
    pub spring_bones: Option<Value>,
}

/// Nodes that are shown together.
#[derive(Debug, Deserialize)]
pub(super) struct Scene {
    #[serde(default)]
    pub nodes: Vec<usize>,
}

/// A node of the hierarchy.
#[derive(Debug, Deserialize)]
pub(super) struct Node {
    pub name: Option<String>,
    #[serde(default)]
    pub children: Vec<usize>,
    pub mesh: Option<usize>,
    pub skin: Option<usize>,
    /// Column by column; instead of the three below.
    pub matrix: Option<[f64; 16]>,
    pub translation: Option<[f64; 3]>,
    /// x, y, z, w.
    pub rotation: Option<[f64; 4]>,
    pub scale: Option<[f64; 3]>,
    pub weights: Option<Vec<f64>>,
    #[serde(default)]
    pub extensions: NodeExtensions,
}

/// The extensions of a node that are read.
#[derive(Debug, Default, Deserialize)]
pub(super) struct NodeExtensions {
    #[serde(rename = "KHR_node_visibility")]
    pub visibility: Option<Visibility>,
}

/// Whether a node and what is below it are drawn.
#[derive(Debug, Deserialize)]
pub(super) struct Visibility {
    #[serde(default = "visible")]
    pub visible: bool,
}

fn visible() -> bool {
    true
}

/// Primitives drawn together.
#[derive(Debug, Deserialize)]
pub(super) struct Mesh {
    pub name: Option<String>,
    pub primitives: Vec<Primitive>,
    pub weights: Option<Vec<f64>>,
    pub extras: Option<Value>,
}

/// Vertices and triangles of one material.
#[derive(Debug, Deserialize)]
pub(super) struct Primitive {
    pub attributes: BTreeMap<String, usize>,
    pub indices: Option<usize>,
    pub material: Option<usize>,
    pub mode: Option<u32>,
    #[serde(default)]
    pub targets: Vec<BTreeMap<String, usize>>,
    pub extras: Option<Value>,
    #[serde(default)]
    pub extensions: PrimitiveExtensions,
}

/// The extensions of a primitive that are read.
#[derive(Debug, Default, Deserialize)]
pub(super) struct PrimitiveExtensions {
    #[serde(rename = "KHR_draco_mesh_compression")]
    pub draco: Option<DracoPrimitive>,
}

/// A view with triangles and attributes, which have ids in it.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct DracoPrimitive {
    pub buffer_view: usize,
    pub attributes: BTreeMap<String, u32>,
}

/// A picture in a view, in a data URI or in another file.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Image {
    pub name: Option<String>,
    pub uri: Option<String>,
    pub buffer_view: Option<usize>,
}

/// Joints and their inverse bind matrices.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Skin {
    pub inverse_bind_matrices: Option<usize>,
    pub joints: Vec<usize>,
}

/// An array of elements in a view.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Accessor {
    pub buffer_view: Option<usize>,
    #[serde(default)]
    pub byte_offset: u64,
    pub component_type: u32,
    #[serde(default)]
    pub normalized: bool,
    pub count: u64,
    #[serde(rename = "type")]
    pub kind: String,
    pub sparse: Option<Sparse>,
}

/// Elements that differ from the view's.
#[derive(Debug, Deserialize)]
pub(super) struct Sparse {
    pub count: u64,
    pub indices: SparseArray,
    pub values: SparseArray,
}

/// The indices or values of a [`Sparse`].
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct SparseArray {
    pub buffer_view: usize,
    #[serde(default)]
    pub byte_offset: u64,
    /// Of indices only.
    pub component_type: Option<u32>,
}

/// A stretch of a buffer.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct BufferView {
    pub buffer: usize,
    #[serde(default)]
    pub byte_offset: u64,
    pub byte_length: u64,
    pub byte_stride: Option<u64>,
    #[serde(default)]
    pub extensions: ViewExtensions,
}

impl BufferView {
    /// How it is compressed, if it is.
    pub fn meshopt(&self) -> Option<&MeshoptView> {
        let extensions = &self.extensions;
        (extensions.meshopt_ext.as_ref()).or(extensions.meshopt_khr.as_ref())
    }
}

/// The extensions of a view that are read.
#[derive(Debug, Default, Deserialize)]
pub(super) struct ViewExtensions {
    #[serde(rename = "EXT_meshopt_compression")]
    pub meshopt_ext: Option<MeshoptView>,
    #[serde(rename = "KHR_meshopt_compression")]
    pub meshopt_khr: Option<MeshoptView>,
}

/// Where the compressed bytes of a view are, and what they become: `count` elements of `byte_stride` bytes.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct MeshoptView {
    pub buffer: usize,
    #[serde(default)]
    pub byte_offset: u64,
    pub byte_length: u64,
    pub byte_stride: u64,
    pub count: u64,
    pub mode: String,
    pub filter: Option<String>,
}

/// Bytes in the file, in a data URI or in another file.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Buffer {
    pub uri: Option<String>,
    pub byte_length: u64,
    #[serde(default)]
    pub extensions: BufferExtensions,
}

/// The extensions of a buffer that are read.
#[derive(Debug, Default, Deserialize)]
pub(super) struct BufferExtensions {
    #[serde(rename = "EXT_meshopt_compression")]
    pub meshopt_ext: Option<Fallback>,
    #[serde(rename = "KHR_meshopt_compression")]
    pub meshopt_khr: Option<Fallback>,
}

/// Whether a buffer is only for who cannot decompress.
#[derive(Debug, Deserialize)]
pub(super) struct Fallback {
    #[serde(default)]
    pub fallback: bool,
}

/// Channels that move nodes.
#[derive(Debug, Deserialize)]
pub(super) struct Animation {
    pub name: Option<String>,
    pub channels: Vec<Channel>,
    pub samplers: Vec<Sampler>,
}

/// A sampler that drives a property of a node.
#[derive(Debug, Deserialize)]
pub(super) struct Channel {
    pub sampler: usize,
    pub target: Target,
}

/// The driven property.
#[derive(Debug, Deserialize)]
pub(super) struct Target {
    pub node: Option<usize>,
    pub path: String,
}

/// Key times, values and what lies between them.
#[derive(Debug, Deserialize)]
pub(super) struct Sampler {
    pub input: usize,
    pub output: usize,
    pub interpolation: Option<String>,
}
