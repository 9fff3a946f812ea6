//! Small glTF files made by the tests.

use glam::{DAffine3, DMat4, DQuat, DVec3};
use serde_json::{Value, json};

pub const BYTE: u32 = 5121;
pub const SHORT: u32 = 5123;
pub const FLOAT: u32 = 5126;

/// A document and its one buffer as they grow.
#[derive(Clone)]
pub struct Fixture {
    pub json: Value,
    pub binary: Vec<u8>,
}

impl Fixture {
    pub fn new() -> Self {
        let json = json!({
            "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
            "nodes": [], "meshes": [], "skins": [], "accessors": [], "bufferViews": [],
        });
        let binary = Vec::new();
        Self { json, binary }
    }

    /// Appends to a list of the document; the new index.
    pub fn push(&mut self, list: &str, value: Value) -> usize {
        if self.json[list].is_null() {
            self.json[list] = json!([]);
        }
        let list = self.json[list].as_array_mut().unwrap();
        list.push(value);
        list.len() - 1
    }

    pub fn view(&mut self, bytes: &[u8]) -> usize {
        self.binary.resize(self.binary.len().next_multiple_of(4), 0);
        let (offset, length) = (self.binary.len(), bytes.len());
        self.binary.extend(bytes);
        let view = json!({"buffer": 0, "byteOffset": offset, "byteLength": length});
        self.push("bufferViews", view)
    }

    pub fn accessor(&mut self, component: u32, kind: &str, count: usize, bytes: &[u8]) -> usize {
        let view = self.view(bytes);
        let accessor = json!({
            "bufferView": view, "componentType": component, "count": count, "type": kind,
        });
        self.push("accessors", accessor)
    }

    pub fn floats<const N: usize>(&mut self, kind: &str, values: &[[f32; N]]) -> usize {
        let bytes: Vec<u8> = values
            .as_flattened()
            .iter()
            .flat_map(|v| v.to_le_bytes())
            .collect();
        self.accessor(FLOAT, kind, values.len(), &bytes)
    }

    pub fn vectors(&mut self, values: &[DVec3]) -> usize {
        let values: Vec<[f32; 3]> = values.iter().map(|v| v.as_vec3().to_array()).collect();
        self.floats("VEC3", &values)
    }

    pub fn shorts(&mut self, kind: &str, count: usize, values: &[u16]) -> usize {
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        self.accessor(SHORT, kind, count, &bytes)
    }

    pub fn matrices(&mut self, values: &[DMat4]) -> usize {
        let values: Vec<[f32; 16]> = values.iter().map(|m| m.as_mat4().to_cols_array()).collect();
        self.floats("MAT4", &values)
    }

    /// A new animation without channels.
    pub fn animation(&mut self, name: &str) -> usize {
        let animation = json!({"name": name, "samplers": [], "channels": []});
        self.push("animations", animation)
    }

    /// Adds a channel to an animation; `values` are three or four floats an element.
    pub fn channel(
        &mut self,
        animation: usize,
        (node, path, interpolation): (usize, &str, &str),
        times: &[f32],
        values: &[Vec<f32>],
    ) {
        let times: Vec<[f32; 1]> = times.iter().map(|t| [*t]).collect();
        let input = self.floats("SCALAR", &times);
        let bytes: Vec<u8> = values
            .iter()
            .flatten()
            .flat_map(|v| v.to_le_bytes())
            .collect();
        let kind = if path == "rotation" { "VEC4" } else { "VEC3" };
        let output = self.accessor(FLOAT, kind, values.len(), &bytes);
        let animation = &mut self.json["animations"][animation];
        let samplers = animation["samplers"].as_array_mut().unwrap();
        samplers.push(json!({"input": input, "output": output, "interpolation": interpolation}));
        let sampler = samplers.len() - 1;
        let channels = animation["channels"].as_array_mut().unwrap();
        channels.push(json!({"sampler": sampler, "target": {"node": node, "path": path}}));
    }

    /// Turns a node away from its rest in half a second and back in another.
    pub fn swing(&mut self, animation: usize, node: usize, turn: DQuat) {
        let rest = &self.json["nodes"][node]["rotation"];
        let part = |k: usize| rest[k].as_f64().unwrap_or(if k == 3 { 1.0 } else { 0.0 });
        let rest = DQuat::from_array([0, 1, 2, 3].map(part));
        let values = [rest, rest * turn, rest].map(|q| q.as_quat().to_array().to_vec());
        let channel = (node, "rotation", "LINEAR");
        self.channel(animation, channel, &[0.0, 0.5, 1.0], &values);
    }

    /// The file as GLB.
    pub fn glb(&self) -> Vec<u8> {
        let mut file = self.clone();
        file.json["buffers"] = json!([{"byteLength": self.binary.len()}]);
        file.glb_with_buffers()
    }

    /// The same with the buffers that the document says.
    pub fn glb_with_buffers(&self) -> Vec<u8> {
        let mut json = self.json.to_string().into_bytes();
        json.resize(json.len().next_multiple_of(4), b' ');
        let mut binary = self.binary.clone();
        binary.resize(binary.len().next_multiple_of(4), 0);
        let mut out = b"glTF\x02\0\0\0".to_vec();
        out.extend((28 + json.len() as u32 + binary.len() as u32).to_le_bytes());
        for (kind, chunk) in [(b"JSON", json), (b"BIN\0", binary)] {
            out.extend((chunk.len() as u32).to_le_bytes());
            out.extend(kind);
            out.extend(chunk);
        }
        out
    }

    /// The file as text, its buffer at `uri`.
    pub fn text(&self, uri: &str) -> Vec<u8> {
        let mut json = self.json.clone();
        json["buffers"] = json!([{"byteLength": self.binary.len(), "uri": uri}]);
        json.to_string().into_bytes()
    }
}

/// A closed bar along x: rings of eight vertices and a vertex at each end.
pub struct Bar {
    pub positions: Vec<DVec3>,
    pub triangles: Vec<[u16; 3]>,
    /// For each vertex how far it is along the bar, 0 to 1.
    pub along: Vec<f64>,
}

pub const BONES: usize = 3;
pub const LENGTH: f64 = 0.6;

impl Bar {
    pub fn new(rings: usize, radius: f64) -> Self {
        const AROUND: usize = 8;
        let mut positions = vec![DVec3::ZERO];
        for r in 0..rings {
            let x = LENGTH * r as f64 / (rings - 1) as f64;
            for k in 0..AROUND {
                let angle = std::f64::consts::TAU * k as f64 / AROUND as f64;
                // Rounded ends: the first and last rings are narrower.
                let radius = radius * if r == 0 || r == rings - 1 { 0.5 } else { 1.0 };
                positions.push(DVec3::new(x, radius * angle.cos(), radius * angle.sin()));
            }
        }
        positions[0].x = -0.2 * radius;
        positions.push(DVec3::X * (LENGTH + 0.2 * radius));
        let at = |r: usize, k: usize| (1 + r * AROUND + k % AROUND) as u16;
        let last = positions.len() as u16 - 1;
        let mut triangles = Vec::new();
        for k in 0..AROUND {
            triangles.push([0, at(0, k + 1), at(0, k)]);
            triangles.push([last, at(rings - 1, k), at(rings - 1, k + 1)]);
            for r in 0..rings - 1 {
                let (a, b) = (at(r, k), at(r, k + 1));
                let (c, d) = (at(r + 1, k), at(r + 1, k + 1));
                triangles.extend([[a, b, c], [b, d, c]]);
            }
        }
        let along = positions
            .iter()
            .map(|p| (p.x / LENGTH).clamp(0.0, 1.0))
            .collect();
        Self {
            positions,
            triangles,
            along,
        }
    }

    /// Four joints and weights of each vertex: neighbouring bones share.
    pub fn influences(&self) -> (Vec<[u8; 4]>, Vec<[f32; 4]>) {
        let influence = |s: &f64| {
            let at = (s * BONES as f64 - 0.5).clamp(0.0, (BONES - 1) as f64);
            let bone = (at as usize).min(BONES - 2);
            let weight = (at - bone as f64) as f32;
            (
                [bone as u8, bone as u8 + 1, 0, 0],
                [1.0 - weight, weight, 0.0, 0.0],
            )
        };
        self.along.iter().map(influence).unzip()
    }

    /// A skinned primitive of `file` with the bar's triangles and its vertices at `positions`.
    pub fn primitive(&self, file: &mut Fixture, positions: &[DVec3]) -> Value {
        let (joints, weights) = self.influences();
        self.primitive_on(file, positions, &joints, &weights)
    }

    /// The same with joints and weights of each vertex.
    pub fn primitive_on(
        &self,
        file: &mut Fixture,
        positions: &[DVec3],
        joints: &[[u8; 4]],
        weights: &[[f32; 4]],
    ) -> Value {
        let attributes = json!({
            "POSITION": file.vectors(positions),
            "JOINTS_0": file.accessor(BYTE, "VEC4", joints.len(), joints.as_flattened()),
            "WEIGHTS_0": file.floats("VEC4", weights),
        });
        let indices = file.shorts(
            "SCALAR",
            3 * self.triangles.len(),
            self.triangles.as_flattened(),
        );
        json!({"attributes": attributes, "indices": indices})
    }
}

/// Local placements of the bar's joints: rest rotations, and offsets that put each a third further
/// along the bar.
pub fn joint_places() -> [(DQuat, DVec3); BONES] {
    let turns = [
        DQuat::from_rotation_z(0.7),
        DQuat::from_rotation_x(-1.1),
        DQuat::from_rotation_y(0.4),
    ];
    let mut above = DQuat::IDENTITY;
    let mut bone = 0;
    turns.map(|turn| {
        let step = if bone == 0 {
            0.0
        } else {
            LENGTH / BONES as f64
        };
        let place = (turn, above.inverse() * (DVec3::X * step));
        above *= turn;
        bone += 1;
        place
    })
}

/// World placements of the joints under `armature`, turned away from the bind pose by `bend`.
pub fn joint_worlds(armature: DAffine3, bend: &[DQuat; BONES]) -> [DAffine3; BONES] {
    let mut world = armature;
    let mut bends = bend.iter();
    joint_places().map(|(turn, offset)| {
        let turn = turn * *bends.next().unwrap();
        world *= DAffine3::from_rotation_translation(turn, offset);
        world
    })
}

/// How [`bar_file`] differs from a plain one.
#[derive(Clone)]
pub struct BarFile {
    /// Placement of the armature above the joints, which is no joint itself.
    pub armature: (f64, DQuat, DVec3),
    /// Rotations of the joints at rest, after those of the bind pose.
    pub bend: [DQuat; BONES],
    /// What the mesh is multiplied with before the bind pose.
    pub placement: DMat4,
    pub rings: usize,
}

impl Default for BarFile {
    fn default() -> Self {
        Self {
            armature: (1.0, DQuat::IDENTITY, DVec3::ZERO),
            bend: [DQuat::IDENTITY; BONES],
            placement: DMat4::IDENTITY,
            rings: 10,
        }
    }
}

/// A bar of three bones: node 0 the armature, 1 to 3 the joints, 4 the mesh. Mesh 0 has one primitive.
pub fn bar_file(options: &BarFile) -> Fixture {
    let bar = Bar::new(options.rings, 0.05);
    let mut file = Fixture::new();
    let (scale, turn, place) = options.armature;
    let armature = DAffine3::from_scale_rotation_translation(DVec3::splat(scale), turn, place);
    file.push(
        "nodes",
        json!({
            "name": "armature", "children": [1, 4], "translation": place.to_array(),
            "rotation": turn.to_array(), "scale": [scale, scale, scale],
        }),
    );
    for (j, (turn, offset)) in joint_places().into_iter().enumerate() {
        let turn = turn * options.bend[j];
        let children: Vec<usize> = (j + 1 < BONES).then_some(j + 2).into_iter().collect();
        let mut node = json!({
            "name": format!("bone {j}"), "rotation": turn.to_array(), "translation": offset.to_array(),
        });
        if !children.is_empty() {
            node["children"] = json!(children);
        }
        file.push("nodes", node);
    }
    let bind = joint_worlds(DAffine3::IDENTITY, &[DQuat::IDENTITY; BONES]);
    let inverse = bind.map(|b| DMat4::from(b.inverse()) * options.placement);
    let _ = armature;
    let inverse = file.matrices(&inverse);
    file.push(
        "skins",
        json!({"joints": [1, 2, 3], "inverseBindMatrices": inverse}),
    );
    let back = options.placement.inverse();
    let positions: Vec<DVec3> = bar
        .positions
        .iter()
        .map(|p| back.transform_point3(*p))
        .collect();
    let primitive = bar.primitive(&mut file, &positions);
    file.push("meshes", json!({"name": "bar", "primitives": [primitive]}));
    file.push("nodes", json!({"name": "mesh", "mesh": 0, "skin": 0}));
    file
}
