//! Baked files: the same bytes for the same input, and typed errors for anything else.

use super::{TINY, baked, recipe};
use std::path::Path;
use std::sync::Arc;
use supple::Error;
use supple::file::{AvatarFile, Parts, Section, read_avatar, write_avatar};
use supple::glam::{DAffine3, DVec3};
use supple::internal::math::{Random, Rows};
use supple::model::{
    Appearance, Avatar, Image, Joint, JointBone, JointList, PoseOffsets, RenderMesh, SkinJoints,
    UpAxis,
};
use supple_bake::{
    BakeCost, BakeReport, HandleCandidates, bake, baked_file, from_bytes, full_space, read_baked,
    to_bytes, write_baked,
};
use supple_samples::Limb;

fn tiny() -> (Avatar, BakeReport) {
    let recipe = recipe(HandleCandidates::Skin, 8);
    bake(&TINY.body().unwrap(), &recipe, &mut |_| {}).unwrap()
}

#[test]
fn same_input_same_bytes_whatever_the_threads() {
    let body = Limb::S.body().unwrap();
    let recipe = recipe(HandleCandidates::Skin, 30);
    let once = to_bytes(&baked(&body, &recipe), None).unwrap();
    assert!(once == to_bytes(&baked(&body, &recipe), None).unwrap());
    #[cfg(feature = "threads")]
    for threads in [1, 3] {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        assert!(once == pool.install(|| to_bytes(&baked(&body, &recipe), None).unwrap()));
    }
}

#[test]
fn a_file_comes_back_as_it_was_written() {
    let (avatar, mut report) = tiny();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("limb.supple");
    write_avatar(&avatar, &path).unwrap();
    assert_eq!(read_baked(&path).unwrap().report, None);
    write_baked(&avatar, &report, &path).unwrap();
    assert_eq!(read_avatar(&path).unwrap(), avatar);
    // The report is kept but for what the bake took.
    report.cost = BakeCost::default();
    assert_eq!(read_baked(&path).unwrap().report, Some(report));
    // Nothing else is left beside it.
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    let nowhere = folder.path().join("missing").join("limb.supple");
    assert!(matches!(
        write_avatar(&avatar, &nowhere),
        Err(Error::Io { .. })
    ));
    assert!(matches!(read_avatar(&nowhere), Err(Error::Io { .. })));
}

fn problem(bytes: &[u8]) -> String {
    let error = from_bytes(bytes, Path::new("limb.supple")).unwrap_err();
    assert!(matches!(error, Error::Format { .. }), "{error:?}");
    error.to_string()
}

#[test]
fn a_file_cut_anywhere_is_an_error() {
    let avatar = baked(&TINY.body().unwrap(), &recipe(HandleCandidates::Skin, 8));
    let bytes = to_bytes(&avatar, None).unwrap();
    for length in 0..bytes.len() {
        problem(&bytes[..length]);
    }
    let longer = [bytes.as_slice(), &[0]].concat();
    assert!(problem(&longer).contains("payload"));
    assert_eq!(
        from_bytes(&bytes, Path::new("limb.supple")).unwrap().avatar,
        avatar
    );
}

#[test]
fn every_flipped_bit_is_an_error() {
    let avatar = baked(&TINY.body().unwrap(), &recipe(HandleCandidates::Skin, 8));
    let bytes = to_bytes(&avatar, None).unwrap();
    let mut random = Random::new(5);
    // All of the header, and some of the rest.
    let header = 0..24 * 8;
    let rest = (0..300).map(|_| random.index(bytes.len() * 8));
    for bit in header.chain(rest) {
        let mut flipped = bytes.clone();
        flipped[bit / 8] ^= 1 << (bit % 8);
        problem(&flipped);
    }
}

#[test]
fn a_forged_checksum_does_not_get_nonsense_in() {
    let (avatar, report) = tiny();
    survives_forgery(&to_bytes(&avatar, Some(&report)).unwrap(), 24, 6, 2000);
}

/// Gives a changed file the checksum of what it holds now.
pub fn seal(file: &mut [u8]) {
    let mut hasher = crc32fast::Hasher::new();
    hasher.update(&file[8..12]);
    hasher.update(&file[16..]);
    file[12..16].copy_from_slice(&hasher.finalize().to_le_bytes());
}

/// Whoever changes `bytes` from `first` on and recomputes the checksum gets a typed error or a valid avatar, so many times.
pub fn survives_forgery(bytes: &[u8], first: usize, seed: u64, times: usize) {
    let mut random = Random::new(seed);
    let mut refused = 0;
    for _ in 0..times {
        let mut forged = bytes.to_vec();
        for _ in 0..1 + random.index(4) {
            let at = first + random.index(forged.len() - first);
            forged[at] = random.index(256) as u8;
        }
        seal(&mut forged);
        match from_bytes(&forged, Path::new("limb.supple")) {
            Ok(baked) => baked.avatar.validate().unwrap(),
            Err(Error::Format { .. }) => refused += 1,
            Err(other) => panic!("{other:?}"),
        }
    }
    assert!(refused > 20, "{refused}");
}

#[test]
fn foreign_and_newer_files_are_named() {
    let avatar = baked(&TINY.body().unwrap(), &recipe(HandleCandidates::Skin, 8));
    let bytes = to_bytes(&avatar, None).unwrap();
    assert!(problem(b"glTF\x02\0\0\0 something else altogether").contains("not a baked avatar"));
    let mut newer = bytes.clone();
    newer[8] += 1;
    assert!(problem(&newer).contains("update supple"));
    newer[8] = 0;
    assert!(problem(&newer).contains("bake it again"));
}

#[test]
fn a_file_for_a_game_is_the_same_avatar_without_its_layer() {
    let (avatar, report) = tiny();
    let file = baked_file(&avatar, Some(&report)).unwrap();
    let bytes = file.to_bytes(Parts::Step).unwrap();
    assert!(bytes.len() < file.to_bytes(Parts::All).unwrap().len());
    let back = from_bytes(&bytes, Path::new("limb.supple")).unwrap().avatar;
    assert!(back.layer.is_empty());
    let error = full_space(&back).unwrap_err().to_string();
    assert!(error.contains("--without-layer"), "{error}");
    let whole = Avatar {
        layer: avatar.layer.clone(),
        ..back
    };
    assert_eq!(whole, avatar);
}

#[test]
fn a_section_that_is_not_known_is_passed_over_and_one_that_is_missing_is_named() {
    let (avatar, _) = tiny();
    let mut file = AvatarFile::new(avatar);
    file.others.push(Section {
        tag: *b"futr",
        version: 7,
        content: vec![1, 2, 3],
    });
    let mut bytes = file.to_bytes(Parts::All).unwrap();
    let path = Path::new("limb.supple");
    assert_eq!(AvatarFile::from_bytes(&bytes, path).unwrap(), file);
    // The same file with another name on its skin.
    let at = bytes.windows(4).position(|tag| tag == b"skin").unwrap();
    bytes[at..at + 4].copy_from_slice(b"sk1n");
    let mut hasher = crc32fast::Hasher::new();
    hasher.update(&bytes[8..12]);
    hasher.update(&bytes[16..]);
    bytes[12..16].copy_from_slice(&hasher.finalize().to_le_bytes());
    assert!(problem(&bytes).contains("section skin: is not there"));
}

/// What only shading reads is a section of its own: a file of before is one without it.
#[test]
fn materials_and_tangents_come_back_and_have_defaults() {
    let (mut avatar, _) = tiny();
    let path = Path::new("limb.supple");
    let part = RenderMesh {
        name: "bar".into(),
        material: "steel".into(),
        vertices: vec![0, 1, 2],
        texture_coordinates: vec![[0.0, 0.25]; 3],
        triangles: vec![[0, 1, 2]],
        ..RenderMesh::default()
    };
    avatar.render_meshes = vec![part.clone(), part];
    let of_before = to_bytes(&avatar, None).unwrap();
    assert!(!of_before.windows(4).any(|tag| tag == b"shad"));
    assert_eq!(from_bytes(&of_before, path).unwrap().avatar, avatar);
    avatar.render_meshes[1].material_index = Some(7);
    avatar.render_meshes[1].tangents = vec![[0.0, 0.6, 0.8, -1.0]; 3];
    let mut file = AvatarFile::new(avatar.clone());
    let bytes = file.to_bytes(Parts::Step).unwrap();
    let layer = std::mem::take(&mut avatar.layer);
    assert_eq!(from_bytes(&bytes, path).unwrap().avatar, avatar);
    avatar.layer = layer;
    // The section of another number of parts.
    let shading = (bytes.windows(4)).position(|tag| tag == b"shad").unwrap();
    avatar.render_meshes.iter_mut().for_each(|part| {
        part.material_index = None;
        part.tangents.clear();
    });
    avatar.render_meshes.truncate(1);
    file = AvatarFile::new(avatar.clone());
    let length = u64::from_le_bytes(bytes[shading + 8..shading + 16].try_into().unwrap());
    file.others.push(Section {
        tag: *b"shad",
        version: 1,
        content: bytes[shading + 16..shading + 16 + length as usize].to_vec(),
    });
    assert!(problem(&file.to_bytes(Parts::All).unwrap()).contains("section shad"));
    // Tangents that are not one a vertex.
    avatar.render_meshes[0].tangents = vec![[1.0; 4]; 2];
    let error = to_bytes(&avatar, None).unwrap_err().to_string();
    assert!(error.contains("tangent"), "{error}");
}

/// So are what a file's vertices have besides, and its images; the latter are not for a step.
#[test]
fn attributes_and_images_come_back() {
    let (mut avatar, _) = tiny();
    let path = Path::new("limb.supple");
    let part = RenderMesh {
        vertices: vec![0, 1, 2],
        triangles: vec![[0, 1, 2]],
        ..RenderMesh::default()
    };
    avatar.render_meshes = vec![part.clone(), part];
    let plain = to_bytes(&avatar, None).unwrap();
    let has = |bytes: &[u8], tag: &[u8]| bytes.windows(4).any(|found| found == tag);
    assert!(!has(&plain, b"vatt") && !has(&plain, b"look"));
    let part = &mut avatar.render_meshes[1];
    part.normals = vec![[0.0, 0.6, 0.8]; 3];
    part.colours = vec![[0.1, 0.2, 0.3, 1.0]; 3];
    part.further_coordinates = vec![vec![[0.5, 1.5]; 3], Vec::new()];
    avatar.appearance = Arc::new(Appearance {
        gltf: "{}".into(),
        images: vec![
            Image::default(),
            Image {
                name: "skin".into(),
                mime_type: "image/png".into(),
                bytes: (0..=255).collect(),
            },
        ],
    });
    let bytes = to_bytes(&avatar, None).unwrap();
    assert_eq!(from_bytes(&bytes, path).unwrap().avatar, avatar);
    let step = AvatarFile::new(avatar.clone())
        .to_bytes(Parts::Step)
        .unwrap();
    assert!(has(&step, b"vatt") && !has(&step, b"look"));
    // Of another number than there are vertices.
    for spoil in [
        |part: &mut RenderMesh| part.normals = vec![[1.0, 0.0, 0.0]; 2],
        |part: &mut RenderMesh| part.colours = vec![[1.0; 4]; 4],
        |part: &mut RenderMesh| part.further_coordinates[1] = vec![[f32::NAN, 0.0]; 3],
    ] {
        let mut spoilt = avatar.clone();
        spoil(&mut spoilt.render_meshes[1]);
        let error = to_bytes(&spoilt, None).unwrap_err().to_string();
        assert!(error.contains("normal or colour"), "{error}");
    }
}

#[test]
fn a_file_without_the_extension_is_read_and_says_so_where_offsets_come() {
    let (mut avatar, _) = tiny();
    let path = Path::new("limb.supple");
    let offsets = vec![[1e-3; 3]; avatar.offset_vertices()];
    let mut held = PoseOffsets::default();
    let file = |avatar: &Avatar| AvatarFile::new(avatar.clone());
    let with = file(&avatar).to_bytes(Parts::Step).unwrap();
    let back = AvatarFile::from_bytes(&with, path).unwrap().avatar;
    held.set(&back, &offsets).unwrap();
    // As `supple` wrote it before there were any.
    avatar.pose_extension = Rows::default();
    let without = file(&avatar).to_bytes(Parts::Step).unwrap();
    assert!(!without.windows(4).any(|w| w == b"exte"));
    let back = AvatarFile::from_bytes(&without, path).unwrap().avatar;
    let error = held.set(&back, &offsets).unwrap_err().to_string();
    assert!(error.contains("bake the character again"), "{error}");
    held.set(&back, &[]).unwrap();
    // A row too few, and a vertex that is not there.
    for row in [vec![(0, 1.0)], vec![(offsets.len() as u32, 1.0)]] {
        avatar.pose_extension = (1..avatar.cubature.len()).map(|_| [(0, 1.0)]).collect();
        if row[0].0 > 0 {
            avatar.pose_extension.push(row);
        }
        let error = file(&avatar).to_bytes(Parts::Step).unwrap_err();
        assert!(error.to_string().contains("pose_extension"), "{error}");
    }
}

#[test]
fn joints_and_up_come_back_and_have_defaults() {
    let (mut avatar, _) = tiny();
    let path = Path::new("limb.supple");
    let tags = |bytes: &[u8], tag: &[u8; 4]| bytes.windows(4).any(|w| w == tag);
    // What is its default is not written, and comes back.
    avatar.up = UpAxis::Y;
    assert_eq!(avatar.joints, JointList::of_bones(&avatar.skeleton));
    let bytes = AvatarFile::new(avatar.clone())
        .to_bytes(Parts::All)
        .unwrap();
    assert!(!tags(&bytes, b"join") && !tags(&bytes, b"upax"));
    assert_eq!(AvatarFile::from_bytes(&bytes, path).unwrap().avatar, avatar);
    let joint = |name: &str, bone, scale: f64| Joint {
        name: name.into(),
        bone,
        bind: DAffine3::from_scale(DVec3::splat(scale)),
    };
    let joints = vec![
        joint("hat", JointBone::RidesOn(0), 3.0),
        joint("limb", JointBone::Is(0), 0.01),
    ];
    let skin = SkinJoints {
        joints: vec![1, 0],
        inverse_binds: vec![DAffine3::from_translation(DVec3::X); 2],
    };
    avatar.joints = JointList::new(1, joints, vec![SkinJoints::default(), skin]).unwrap();
    avatar.up = UpAxis::Z;
    for parts in [Parts::Step, Parts::All] {
        let bytes = AvatarFile::new(avatar.clone()).to_bytes(parts).unwrap();
        assert!(tags(&bytes, b"join") && tags(&bytes, b"upax"));
        let back = AvatarFile::from_bytes(&bytes, path).unwrap().avatar;
        assert_eq!((back.joints, back.up), (avatar.joints.clone(), UpAxis::Z));
    }
    // A list of other bones than the avatar's.
    avatar.joints = JointList::new(2, Vec::new(), Vec::new()).unwrap();
    let error = AvatarFile::new(avatar).to_bytes(Parts::All).unwrap_err();
    assert!(
        error.to_string().contains("of 2 bones; the avatar has 1"),
        "{error}"
    );
}
