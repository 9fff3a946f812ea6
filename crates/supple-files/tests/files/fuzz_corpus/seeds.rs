//! Small sound files of every format.

use std::io::{Cursor, Write};
use supple_samples::Limb;
use zip::write::SimpleFileOptions;

use crate::gltf::meshopt::{EXT, KHR, Mode, compressed, stream_of_positions};
use crate::meshopt_encoder::Channel;
use crate::support;

pub const OBJ: &str = "# two tets\no low\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nvt 0.5 0.5\nvn 0 0 1\nf 1/1/1 3/1/1 2/1/1\n\
    f 1 2 4\nf 2 3 4\nf 1 4 3\no high\nv 0 0 2\nv 1 0 2\nv 0 1 2\nv 0 0 3\nf -4 -2 -3\nf -4 -3 -1\nf -3 -2 -1\nf -4 -1 -2\n";

/// `.node`, `.ele` and `.face`.
pub const TETGEN: &str = "5 3 1 1\n1 0 0 0 0.5 2\n2 1 0 0 0.5 2 # c\n3 0 1 0 0.5 2\n4 0 0 1 0.5 0\n5 1 1 1 0.5 0\n%\
    2 4 1\n1 1 3 2 4 7\n2 2 3 4 5 -1\n%3 1\n1 1 2 3 9\n2 2 3 4 0\n3 2 4 5 -4 1 2\n";

pub const BVH: &str = "HIERARCHY\nROOT hips\n{\n\tOFFSET 0 0 0\n\tCHANNELS 6 Xposition Yposition Zposition Zrotation \
    Xrotation Yrotation\n\tJOINT knee\n\t{\n\t\tOFFSET 0 -40 1\n\t\tCHANNELS 3 Zrotation Xrotation Yrotation\n\t\tEnd Site\n\t\t{\n\
    \t\t\tOFFSET 0 -40 0\n\t\t}\n\t}\n}\nMOTION\nFrames: 2\nFrame Time: 0.0083\n0 90 0 1 2 3 4 5 6\n0 91 1 2 3 4 5 6 7\n";

/// Bones along x and a frame more than is announced.
pub const BVH_ALONG_X: &str = "HIERARCHY\nROOT hips {\nOFFSET 0 0 0\nCHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation \
    Yrotation\nJOINT spine {\nOFFSET 9 0 0\nCHANNELS 1 Zrotation\nEnd Site {\nOFFSET 0 0 0\n}\n}\nJOINT leftUpLeg {\nOFFSET 0 0 9\n\
    CHANNELS 1 Zrotation\nJOINT leftFoot {\nOFFSET 80 0 0\nCHANNELS 1 Zrotation\nEnd Site {\nOFFSET 0 0 0\n}\n}\n}\n}\nMOTION\n\
    Frames: 1\nFrame Time: 0.0083\n0 90 0 0 0 0 90 -90 90\n0 90 0 0 0 0 90 -80 80\n";

pub const POSE: &str = "/** a comment */\nexport const pose = {\n jointTransforms: {\n  wrist: { offsetMatrix: [1, 0, 0, 0, 0, 1, 0, \
    0, 0, 0, 1, 0, 0.1, 0, -2e-3, 1], radius: 0.02 },\n  'thumb-tip': { offsetMatrix: [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1], },\n },\n};\n";

pub const POSE_STREAM: &str = "{\"up\": \"y\", \"unit\": \"m\", \"rest\": {\"wrist\": {\"position\": [0, 1, 0], \"rotation\": [0, 0, 0, 1]}}}\n\
    {\"time\": 0.0, \"bones\": {\"wrist\": {\"position\": [0, 1, 0], \"rotation\": [0, 0, 0, 1]}}}\n\
    {\"time\": 0.5, \"bones\": {\"wrist\": {\"matrix\": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 1, 0, 1]}}}\n";

pub const RECIPE: &str = "model = \"body.npz\"\nbetas = [0.5, -1.0]\nbones = \"bones.obj\"\n\n[bake]\ndensity = 950.0\nbones_per_point = 4\n\n\
    [[bake.handles]]\nbones = [\"palm\"]\nspacing = 0.01\n\n[[bake.handles]]\ncount = 20\n\n[bake.truncation]\nbelow = 0.03\nabove = 0.1\n";

const PLAIN_TETS: &str = "5 2 1 3\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 1 1\n0 1 2 3\n1 2 3 4\n0\n1 2 3\n";

fn data(name: &str) -> Vec<u8> {
    std::fs::read(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/").to_string() + name).unwrap()
}

pub fn pickles() -> Vec<Vec<u8>> {
    [0, 2, 4, 5]
        .map(|p| data(&format!("model_protocol{p}.pkl")))
        .to_vec()
}

pub fn tets() -> Vec<Vec<u8>> {
    let files = [
        "nested_text_2_2.msh",
        "nested_binary_2_2.msh",
        "nested_text_4_1.msh",
        "nested_binary_4_1.msh",
        "nested.mesh",
        "nested.meshb",
        "hollow.msh",
    ];
    let mut seeds = files.map(data).to_vec();
    seeds.push(PLAIN_TETS.into());
    seeds
}

pub fn scenes() -> Vec<Vec<u8>> {
    let names = ["finger_press", "bone_press_s"];
    names
        .map(|n| {
            std::fs::read(format!(
                "{}/../../assets/scenes/{n}.toml",
                env!("CARGO_MANIFEST_DIR")
            ))
            .unwrap()
        })
        .to_vec()
}

fn npy(descr: &str, shape: &str, data: &[u8]) -> Vec<u8> {
    let header = format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': ({shape}), }}\n");
    let mut bytes = b"\x93NUMPY\x01\0".to_vec();
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.bytes());
    bytes.extend(data);
    bytes
}

fn f32s(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|v| v.to_le_bytes()).collect()
}

fn u32s(values: &[u32]) -> Vec<u8> {
    values.iter().flat_map(|v| v.to_le_bytes()).collect()
}

fn archive(members: &[(&str, Vec<u8>)]) -> Vec<u8> {
    let mut zip = zip::ZipWriter::new(Cursor::new(Vec::new()));
    for (name, bytes) in members {
        zip.start_file(*name, SimpleFileOptions::default()).unwrap();
        zip.write_all(bytes).unwrap();
    }
    zip.finish().unwrap().into_inner()
}

/// An archive with another member of this name.
pub fn with_member(from: &[u8], name: &str, bytes: &[u8]) -> Vec<u8> {
    let mut from = zip::ZipArchive::new(Cursor::new(from)).unwrap();
    let mut to = zip::ZipWriter::new(Cursor::new(Vec::new()));
    for i in 0..from.len() {
        let member = from.by_index_raw(i).unwrap();
        if member.name().unwrap() != name {
            to.raw_copy_file(member).unwrap();
        }
    }
    to.start_file(name, SimpleFileOptions::default()).unwrap();
    to.write_all(bytes).unwrap();
    to.finish().unwrap().into_inner()
}

/// Two bones on a tet.
pub fn smpl_archive() -> Vec<u8> {
    let names = b"root\0tip\0\0".map(u32::from);
    archive(&[
        (
            "v_template.npy",
            npy(
                "<f4",
                "4, 3",
                &f32s(&[0., 0., 0., 1., 0., 0., 0., 1., 0., 0., 0., 1.]),
            ),
        ),
        (
            "f.npy",
            npy("<u4", "4, 3", &u32s(&[0, 2, 1, 0, 1, 3, 1, 2, 3, 0, 3, 2])),
        ),
        (
            "weights.npy",
            npy(
                "<f4",
                "4, 2",
                &f32s(&[1., 0., 0.25, 0.75, 0., 1., 0.5, 0.5]),
            ),
        ),
        ("J_regressor.npy", regressors().remove(0)),
        (
            "kintree_table.npy",
            npy("<u4", "2, 2", &u32s(&[u32::MAX, 0, 0, 1])),
        ),
        ("shapedirs.npy", npy("<f4", "4, 3, 1", &f32s(&[0.1; 12]))),
        ("posedirs.npy", npy("<f4", "9, 12", &f32s(&[0.01; 108]))),
        ("joint_names.npy", npy("<U5", "2,", &u32s(&names))),
    ])
}

/// A dense regressor, and a sparse one as an array of one object.
pub fn regressors() -> Vec<Vec<u8>> {
    let dense = npy("<f4", "2, 4", &f32s(&[1., 0., 0., 0., 0., 0.5, 0.25, 0.25]));
    // The regressor's part of a pickle that SciPy wrote: an array of no dimension around it.
    let mut program = b"\x80\x02cscipy.sparse.csr\ncsr_matrix\n)\x81}(U\x06_shapeK\x02K\x04\x86U\x06indptr](K\0K\x01K\x04eU\x07indices](\
        K\0K\x01K\x02K\x03eU\x04data]("
        .to_vec();
    for value in [1.0f64, 0.5, 0.25, 0.25] {
        program.push(b'G');
        program.extend(value.to_be_bytes());
    }
    program.extend(b"eub.");
    vec![dense, npy("|O", "", &program)]
}

/// Three frames of a hand.
pub fn amass_archive() -> Vec<u8> {
    archive(&[
        ("poses.npy", amass_poses()),
        (
            "trans.npy",
            npy(
                "<f4",
                "3, 3",
                &f32s(&[0., 0., 1., 0., 0.1, 1., 0., 0.2, 1.]),
            ),
        ),
        ("mocap_framerate.npy", npy("<f8", "", &60f64.to_le_bytes())),
    ])
}

/// A frame of a body in parts, with betas; one of AIST++.
pub fn amass_relatives() -> [Vec<u8>; 2] {
    let zeros = |count: usize| f32s(&vec![0.1; count]);
    [
        archive(&[
            ("root_orient.npy", npy("<f4", "1, 3", &zeros(3))),
            ("pose_body.npy", npy("<f4", "1, 63", &zeros(63))),
            ("pose_hand.npy", npy("<f4", "1, 90", &zeros(90))),
            ("trans.npy", npy("<f4", "1, 3", &zeros(3))),
            ("betas.npy", npy("<f4", "16", &zeros(16))),
            ("fps.npy", npy("<f8", "", &60f64.to_le_bytes())),
        ]),
        archive(&[
            ("smpl_poses.npy", npy("<f4", "1, 72", &zeros(72))),
            ("smpl_trans.npy", npy("<f4", "1, 3", &zeros(3))),
            ("smpl_scaling.npy", npy("<f4", "1", &zeros(1))),
        ]),
    ]
}

pub fn amass_poses() -> Vec<u8> {
    npy("<f4", "3, 48", &f32s(&[0.1; 144]))
}

/// A skinned tet with two bones, a morph target, an animation and a VRM humanoid: as a GLB, as JSON with its buffer in it,
/// and as JSON without the skin.
pub fn gltf() -> Vec<Vec<u8>> {
    let (json, buffer) = gltf_document();
    let plain = json(&embedded(&buffer));
    let rigid = plain.replace("\"nodes\":[0,1]", "\"nodes\":[0]").replace(
        "\"mesh\":0,\"skin\":0",
        "\"mesh\":0,\"children\":[1],\"scale\":[1,1.1,1],\"extensions\":{\"KHR_node_visibility\":{\"visible\":true}}",
    );
    vec![
        glb(json("").into_bytes(), buffer),
        plain.into_bytes(),
        rigid.into_bytes(),
    ]
}

/// The same files, and a VRM animation.
pub fn gltf_motions() -> Vec<Vec<u8>> {
    let (json, buffer) = gltf_document();
    let motion = json(&embedded(&buffer)).replace("{\"mesh\":0,\"skin\":0}", "{}");
    let motion = motion.replace("VRMC_vrm", "VRMC_vrm_animation");
    [gltf(), vec![motion.into_bytes()]].concat()
}

/// A bar whose views meshopt compressed, in each mode and version.
pub fn meshopt() -> Vec<Vec<u8>> {
    vec![
        compressed(EXT, Mode::Attributes, Mode::Triangles),
        compressed(KHR, Mode::AttributesV1, Mode::Indices),
    ]
}

pub fn meshopt_streams() -> Vec<Vec<u8>> {
    let kinds = [
        [Channel::Bytes; 3],
        [Channel::Shorts; 3],
        [Channel::Xor(3), Channel::Bytes, Channel::Xor(0)],
    ];
    kinds.map(|kinds| stream_of_positions(&kinds)).to_vec()
}

/// A bar by both kinds of connectivity, and the ways that edges are walked.
#[cfg(feature = "draco")]
pub fn draco_streams() -> Vec<Vec<u8>> {
    let ways = [(0, 0), (1, 10), (1, 5), (1, 1)];
    let stream = |(method, level)| {
        let mut options = draco_core::EncoderOptions::new();
        options.set_encoding_method(method);
        options.set_compression_level(level);
        // Rounded, so that they are predicted from each other.
        for (id, bits) in [(0, 14), (2, 8), (3, 12), (4, 10)] {
            options.set_attribute_quantization(id, bits);
        }
        crate::draco_file::stream(&options)
    };
    ways.map(stream).to_vec()
}

fn embedded(buffer: &[u8]) -> String {
    let coded = base64(buffer);
    format!(",\"uri\":\"data:application/octet-stream;base64,{coded}\"")
}

/// The document, given what says where its buffer is, and the buffer.
fn gltf_document() -> (impl Fn(&str) -> String, Vec<u8>) {
    let mut buffer = Vec::new();
    let mut views = Vec::new();
    let mut accessors = Vec::new();
    let mut add = |bytes: Vec<u8>, component: u32, count: usize, kind: &str, extra: &str| {
        views.push(format!(
            "{{\"buffer\":0,\"byteOffset\":{},\"byteLength\":{}}}",
            buffer.len(),
            bytes.len()
        ));
        accessors.push(format!(
            "{{\"bufferView\":{},\"componentType\":{component},\"count\":{count},\"type\":\"{kind}\"{extra}}}",
            accessors.len()
        ));
        buffer.extend(bytes);
        buffer.resize(buffer.len().next_multiple_of(4), 0);
    };
    let places = [0., 0., 0., 1., 0., 0., 0., 1., 0., 0., 0., 1.];
    add(
        f32s(&places),
        5126,
        4,
        "VEC3",
        ",\"min\":[0,0,0],\"max\":[1,1,1]",
    );
    add([[0, 1, 0, 0]; 4].concat(), 5121, 4, "VEC4", "");
    add(
        [[191, 64, 0, 0]; 4].concat(),
        5121,
        4,
        "VEC4",
        ",\"normalized\":true",
    );
    let corners = [0u16, 2, 1, 0, 1, 3, 1, 2, 3, 0, 3, 2];
    add(
        corners.iter().flat_map(|c| c.to_le_bytes()).collect(),
        5123,
        12,
        "SCALAR",
        "",
    );
    let unit = |y: f32| {
        [
            1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1., 0., 0., y, 0., 1.,
        ]
    };
    add(f32s(&[unit(0.), unit(-0.5)].concat()), 5126, 2, "MAT4", "");
    add(
        f32s(&[0., 0.5]),
        5126,
        2,
        "SCALAR",
        ",\"min\":[0],\"max\":[0.5]",
    );
    add(f32s(&[0., 0., 0., 1., 0., 0., 1., 0.]), 5126, 2, "VEC4", "");
    add(f32s(&[0.1; 12]), 5126, 4, "VEC3", "");
    add(f32s(&[1., 1., 1., 0., 1.2, 1.]), 5126, 2, "VEC3", "");
    let (views, accessors, length) = (views.join(","), accessors.join(","), buffer.len());
    let json = move |uri: &str| {
        format!(
            "{{\"asset\":{{\"version\":\"2.0\"}},\"scene\":0,\"scenes\":[{{\"nodes\":[0,1]}}],\"nodes\":[{{\"mesh\":0,\"skin\":0}},{{\"name\":\"root\",\
             \"children\":[2]}},{{\"name\":\"tip\",\"translation\":[0,0.5,0]}}],\"meshes\":[{{\"primitives\":[{{\"attributes\":{{\"POSITION\":0,\"JOINTS_0\":1,\
             \"WEIGHTS_0\":2}},\"indices\":3,\"targets\":[{{\"POSITION\":7}}]}}],\"weights\":[0.5]}}],\"skins\":[{{\"joints\":[1,2],\"inverseBindMatrices\":4}}],\
             \"animations\":[{{\"channels\":[{{\"sampler\":0,\"target\":{{\"node\":2,\"path\":\"rotation\"}}}},\
             {{\"sampler\":1,\"target\":{{\"node\":2,\"path\":\"scale\"}}}}],\"samplers\":[{{\"input\":5,\"output\":6}},{{\"input\":5,\"output\":8}}]}}],\
             \"extensionsUsed\":[\"VRMC_vrm\"],\"extensions\":{{\"VRMC_vrm\":{{\"specVersion\":\"1.0\",\"humanoid\":{{\"humanBones\":{{\"hips\":{{\"node\":1}},\
             \"spine\":{{\"node\":2}}}}}}}}}},\"buffers\":[{{\"byteLength\":{length}{uri}}}],\"bufferViews\":[{views}],\"accessors\":[{accessors}]}}"
        )
    };
    (json, buffer)
}

fn glb(mut json: Vec<u8>, mut binary: Vec<u8>) -> Vec<u8> {
    json.resize(json.len().next_multiple_of(4), b' ');
    binary.resize(binary.len().next_multiple_of(4), 0);
    let total = 12 + 8 + json.len() + 8 + binary.len();
    let mut bytes = b"glTF".to_vec();
    bytes.extend(u32s(&[2, total as u32, json.len() as u32]));
    bytes.extend(b"JSON");
    bytes.extend(json);
    bytes.extend(u32s(&[binary.len() as u32]));
    bytes.extend(b"BIN\0");
    bytes.extend(binary);
    bytes
}

fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let group = |three: &[u8]| {
        let bits = (0..3).fold(0u32, |bits, i| {
            bits << 8 | u32::from(*three.get(i).unwrap_or(&0))
        });
        let digit = |i: usize| match i <= three.len() {
            true => char::from(DIGITS[(bits >> (18 - 6 * i) & 63) as usize]),
            false => '=',
        };
        [0, 1, 2, 3].map(digit)
    };
    bytes.chunks(3).flat_map(group).collect()
}

/// The smallest limb in its full space.
pub fn baked() -> Vec<u8> {
    let limb = Limb {
        stations: 2,
        layers: 1,
        sectors: 4,
        ..support::SMALL
    };
    supple_bake::to_bytes(&support::full_space_limb(&limb, 1, true), None).unwrap()
}

/// The baked file with its length and checksum set right (the table in src/bake/file.rs).
pub fn with_checksum(mut bytes: Vec<u8>) -> Vec<u8> {
    if let Some(length) = bytes.len().checked_sub(24) {
        bytes[16..24].copy_from_slice(&(length as u64).to_le_bytes());
        let mut sum = crc32fast::Hasher::new();
        sum.update(&bytes[8..12]);
        sum.update(&bytes[16..]);
        let sum = sum.finalize();
        bytes[12..16].copy_from_slice(&sum.to_le_bytes());
    }
    bytes
}
