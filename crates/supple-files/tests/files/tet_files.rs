//! Tet meshes that Gmsh wrote (tests/data/README.md), and the soft layers that they are.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use supple::Error;
use supple::glam::DVec3;
use supple::internal::math::Rows;
use supple::model::{JointList, PoseBlend, Skeleton, SkinWeight, Surface, UpAxis};
use supple_bake::{Body, LayerMesh};
use supple_files::{TetFile, parse_tets, read_tets};

const NESTED: [&str; 6] = [
    "nested_text_2_2.msh",
    "nested_binary_2_2.msh",
    "nested_text_4_1.msh",
    "nested_binary_4_1.msh",
    "nested.mesh",
    "nested.meshb",
];

fn data(name: &str) -> PathBuf {
    Path::new("tests/data").join(name)
}

fn regions(pairs: &[(&str, &str)]) -> BTreeMap<String, String> {
    pairs
        .iter()
        .map(|(l, b)| (l.to_string(), b.to_string()))
        .collect()
}

fn volume(layer: &LayerMesh) -> f64 {
    layer.tissue_volume()
}

fn bones() -> Vec<String> {
    vec!["elbow".into(), "wrist".into()]
}

#[test]
fn one_mesh_is_read_from_every_form() {
    let first = read_tets(data(NESTED[0])).unwrap();
    assert_eq!((first.mesh.nodes.len(), first.mesh.tets.len()), (28, 96));
    let inside =
        |file: &TetFile, t: usize| (file.mesh.centroid(t) - 0.5).abs().max_element() < 0.25;
    for name in NESTED {
        let file = read_tets(data(name)).unwrap();
        assert_eq!(file.mesh.nodes, first.mesh.nodes, "{name}");
        let total: f64 = (0..96).map(|t| file.mesh.volume(t)).sum();
        assert!((total - 1.0).abs() < 1e-12, "{name}: {total}");
        assert!((0..96).all(|t| file.mesh.volume(t) > 0.0), "{name}");
        let (tissue, wrist) = match name {
            "nested.mesh" => ("3", "2"),
            "nested.meshb" => ("5", "7"),
            _ => ("tissue", "wrist"),
        };
        for t in 0..96 {
            let label = &file.labels[file.tet_labels[t].unwrap() as usize];
            assert_eq!(
                label,
                if inside(&file, t) { wrist } else { tissue },
                "{name}"
            );
        }
    }
}

#[test]
fn regions_become_bones_and_tissue() {
    for name in NESTED {
        let table = match name {
            "nested.mesh" => regions(&[("2", "wrist")]),
            "nested.meshb" => regions(&[("7", "wrist")]),
            _ => regions(&[]),
        };
        let made = read_tets(data(name))
            .unwrap()
            .layer(&bones(), &table)
            .unwrap();
        assert!((volume(&made.layer) - 0.875).abs() < 1e-12, "{name}");
        made.layer.validate(made.skin.positions.len(), 2).unwrap();
        assert!(made.skin.is_closed() && (made.skin.volume() - 1.0).abs() < 1e-12);
        assert!(made.bone_surfaces[0].triangles.is_empty());
        assert!((made.bone_surfaces[1].volume() - 0.125).abs() < 1e-12);
        for (node, bone) in made.layer.mesh.nodes.iter().zip(&made.layer.bone_of_node) {
            let on_bone = (*node - 0.5).abs().max_element() < 0.25 + 1e-9;
            assert_eq!(*bone, on_bone.then_some(1), "{name}: {node}");
        }
        for (place, row) in made
            .skin
            .positions
            .iter()
            .zip(made.layer.skin_embedding.iter())
        {
            let [(node, share)] = row else {
                panic!("a skin vertex is a node")
            };
            assert_eq!(
                (made.layer.mesh.nodes[*node as usize], *share),
                (*place, 1.0)
            );
        }
    }
}

#[test]
fn named_surfaces_hold_and_are_the_skin() {
    let file = read_tets(data("hollow.msh")).unwrap();
    let made = file.layer(&bones(), &regions(&[])).unwrap();
    assert!((volume(&made.layer) - 0.875).abs() < 1e-12);
    assert!(made.skin.is_closed() && (made.skin.volume() - 1.0).abs() < 1e-12);
    // The bone's surface is the hollow's wall, seen from the tissue.
    assert!((made.bone_surfaces[1].volume() - 0.125).abs() < 1e-12);
    let held = made.layer.bone_of_node.iter().flatten().count();
    assert_eq!(held, made.bone_surfaces[1].positions.len());
}

/// TetGen's files of a mesh, numbered from 1, with its labels as attributes.
fn tetgen(file: &TetFile, folder: &Path) -> PathBuf {
    let (mesh, mut nodes, mut tets) = (&file.mesh, String::new(), String::new());
    writeln!(nodes, "{} 3 0 0", mesh.nodes.len()).unwrap();
    for (i, n) in mesh.nodes.iter().enumerate() {
        writeln!(nodes, "{} {:?} {:?} {:?}", i + 1, n.x, n.y, n.z).unwrap();
    }
    writeln!(tets, "{} 4 1", mesh.tets.len()).unwrap();
    for (t, tet) in mesh.tets.iter().enumerate() {
        let [a, b, c, d] = tet.map(|n| n + 1);
        writeln!(
            tets,
            "{} {a} {b} {c} {d} {}",
            t + 1,
            file.tet_labels[t].unwrap()
        )
        .unwrap();
    }
    let path = folder.join("nested.1.ele");
    std::fs::write(&path, tets).unwrap();
    std::fs::write(path.with_extension("node"), nodes).unwrap();
    path
}

#[test]
fn tetgen_files_are_found_beside_each_other() {
    let folder = tempfile::tempdir().unwrap();
    let file = read_tets(data(NESTED[3])).unwrap();
    let path = tetgen(&file, folder.path());
    for named in [path.clone(), path.with_extension("node")] {
        let read = read_tets(named).unwrap();
        assert_eq!(read.mesh, file.mesh);
        let label = |f: &TetFile, t: usize| f.labels[f.tet_labels[t].unwrap() as usize].clone();
        for t in 0..96 {
            let number = ["tissue", "wrist"][label(&read, t).parse::<usize>().unwrap()];
            let same = label(&file, t);
            assert!(file.labels[0] != "tissue" || same == number);
        }
    }
    std::fs::remove_file(path.with_extension("node")).unwrap();
    assert!(matches!(read_tets(&path), Err(Error::Io { .. })));
}

/// A body of two bones whose skin is a finer cube.
fn body(size: f64) -> Body {
    let file = read_tets(data("hollow.msh")).unwrap();
    let coarse = file.layer(&bones(), &regions(&[])).unwrap().skin;
    let mut skin = Surface::default();
    for t in 0..coarse.triangles.len() {
        let corners = coarse.corners(t);
        let first = skin.positions.len() as u32;
        let middle = corners.iter().sum::<DVec3>() / 3.0;
        skin.positions
            .extend(corners.iter().chain([&middle]).map(|p| *p * size));
        skin.triangles
            .extend([[0, 1, 3], [1, 2, 3], [2, 0, 3]].map(|t| t.map(|v| v + first)));
    }
    let whole = SkinWeight {
        bone: 0,
        weight: 1.0,
    };
    let skeleton = Skeleton {
        names: bones(),
        parents: vec![None, Some(0)],
        joints: vec![DVec3::ZERO, DVec3::splat(0.5)],
        aliases: Vec::new(),
        limits: Vec::new(),
    };
    Body {
        name: "cube".into(),
        joints: JointList::of_bones(&skeleton),
        springs: Default::default(),
        up: UpAxis::Z,
        skeleton,
        skinning: skin.positions.iter().map(|_| [whole]).collect::<Rows<_>>(),
        skin,
        pose_blend: PoseBlend::default(),
        bone_surfaces: Vec::new(),
        layer: LayerMesh::default(),
        painted: BTreeMap::new(),
        attachments: Vec::new(),
        render_meshes: Vec::new(),
        appearance: Default::default(),
    }
}

#[test]
fn a_characters_skin_is_embedded() {
    for name in ["hollow.msh", NESTED[1]] {
        let mut body = body(1.0);
        let file = read_tets(data(name)).unwrap();
        file.put_into(&mut body, &regions(&[])).unwrap();
        body.validate().unwrap();
        for (place, row) in body
            .skin
            .positions
            .iter()
            .zip(body.layer.skin_embedding.iter())
        {
            let nodes = &body.layer.mesh.nodes;
            let found: DVec3 = row
                .iter()
                .map(|(n, share)| *share * nodes[*n as usize])
                .sum();
            assert!(place.distance(found) < 1e-12);
        }
        assert!((body.bone_surfaces[1].volume() - 0.125).abs() < 1e-12);
        let error = file
            .put_into(&mut self::body(1000.0), &regions(&[]))
            .unwrap_err();
        assert!(error.to_string().contains("in metres"), "{error}");
    }
}

#[test]
fn a_mesh_without_a_skeleton_is_a_body_around_one_bone() {
    let held = |body: &Body| body.layer.bone_of_node.iter().flatten().count();
    // An inner region; a hollow, its labels unknown; a region by table; nothing at all.
    let nested = read_tets(data(NESTED[0])).unwrap();
    let inner = nested.body("cube", &regions(&[])).unwrap();
    assert!((volume(&inner.layer) - 0.875).abs() < 1e-12);
    let named = nested.body("cube", &regions(&[("wrist", "bone")])).unwrap();
    assert_eq!(named, inner);
    let mut hollow = read_tets(data("hollow.msh")).unwrap();
    hollow.labels.clear();
    hollow.tet_labels.fill(None);
    hollow.marks.clear();
    let hollow = hollow.body("cube", &regions(&[])).unwrap();
    assert_eq!(held(&hollow), held(&inner));
    assert!(hollow.skin.is_closed() && hollow.skeleton.joints[0].distance(DVec3::splat(0.5)) < 0.1);
    let mut solid = nested.clone();
    solid.tet_labels.fill(None);
    let solid = solid.body("cube", &regions(&[])).unwrap();
    assert!((volume(&solid.layer) - 1.0).abs() < 1e-12);
    let deepest = solid.layer.bone_of_node.iter().zip(&solid.layer.mesh.nodes);
    for (_, node) in deepest.filter(|(bone, _)| bone.is_some()) {
        assert!((*node - 0.5).abs().max_element() < 0.25 + 1e-9);
    }
    assert!(held(&solid) > 0);
}

#[test]
fn labels_that_do_not_fit_are_told() {
    let file = read_tets(data(NESTED[0])).unwrap();
    let refused = |bones: &[&str], table: &[(&str, &str)], hint: &str| {
        let bones: Vec<_> = bones.iter().map(ToString::to_string).collect();
        let error = file.layer(&bones, &regions(table)).unwrap_err().to_string();
        assert!(error.contains(hint), "{error}");
    };
    refused(&["elbow"], &[], "its labels are wrist, tissue");
    refused(&["wrist"], &[("8", "wrist")], "no label \"8\"");
    refused(
        &["wrist"],
        &[("wrist", "knee")],
        "no bone \"knee\"; there are wrist",
    );
    refused(&["wrist", "tissue"], &[], "no outer face");
}

#[test]
fn broken_files_are_refused_with_their_place() {
    let refused = |name: &str, change: &dyn Fn(String) -> String, hint: &str| {
        let text = change(std::fs::read_to_string(data(name)).unwrap());
        let error = parse_tets(text.as_bytes(), Path::new(name)).expect_err(hint);
        let message = error.to_string();
        assert!(
            matches!(error, Error::Format { .. }) && message.contains(hint),
            "{message}"
        );
    };
    let edit =
        |from: &'static str, to: &'static str| move |text: String| text.replacen(from, to, 1);
    let [old, _, new, _, medit, _] = NESTED;
    refused(old, &edit("2.2 0 8", "3.0 0 8"), "line 2: version 3.0");
    refused(old, &edit("2.2 0 8", "2.2 0 4"), "8 bytes");
    refused(
        old,
        &edit("$Elements\n96", "$Elements\n97"),
        "element's number should stand here",
    );
    refused(
        old,
        &edit("$Elements\n96", "$Elements\n95"),
        "$EndElements should stand here",
    );
    refused(old, &edit(" 4 2 5 3 ", " 11 2 5 3 "), "higher order");
    refused(old, &edit(" 4 2 5 3 ", " 5 2 5 3 "), "hexahedra");
    refused(old, &edit(" 4 2 5 3 ", " 99 2 5 3 "), "type 99");
    refused(
        old,
        &edit("$EndNodes", "$Nodes"),
        "$EndNodes should stand here",
    );
    refused(
        new,
        &edit("$MeshFormat\n4.1 0 8\n$EndMeshFormat\n", ""),
        "first",
    );
    refused(new, &edit("3 2 4 ", "3 2 11 "), "higher order");
    refused(medit, &edit("Tetrahedra\n", "TetrahedraP2\n"), "linear");
    refused(
        medit,
        &edit("Dimension\n 3", "Dimension\n 2"),
        "three dimensions",
    );
    refused(medit, &|text| text[..text.len() / 2].to_string(), "line");
    refused(medit, &edit("Tetrahedra", "Whatever"), "there are none");
}
