//! The lattice mesher on whole shapes: sound tets, the right volume, and fingers that stay apart.

use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use supple::glam::DVec3;
use supple::model::Surface;
use supple_bake::LayerMesh;
use supple_bake::mesh::{LatticeSize, MeshQuality, lattice};
use supple_samples::hand;

/// A tube with round ends along a path in the xy plane.
fn tube(path: &[DVec3], radius: f64) -> Surface {
    let (sectors, cap) = (24, 6);
    let tangent = |i: usize| {
        let (a, b) = (i.saturating_sub(1), (i + 1).min(path.len() - 1));
        (path[b] - path[a]).normalize()
    };
    let last = path.len() - 1;
    // (centre, radius, tangent) of each ring; the poles have radius 0.
    let mut rings = Vec::new();
    for k in 0..cap {
        let (sine, cosine) = (FRAC_PI_2 * k as f64 / cap as f64).sin_cos();
        rings.push((
            path[0] - tangent(0) * radius * cosine,
            radius * sine,
            tangent(0),
        ));
    }
    rings.extend((0..=last).map(|i| (path[i], radius, tangent(i))));
    for k in (0..cap).rev() {
        let (sine, cosine) = (FRAC_PI_2 * k as f64 / cap as f64).sin_cos();
        rings.push((
            path[last] + tangent(last) * radius * cosine,
            radius * sine,
            tangent(last),
        ));
    }
    let mut surface = Surface::default();
    let count = rings.len();
    for (r, (centre, radius, tangent)) in rings.into_iter().enumerate() {
        let side = DVec3::Z.cross(tangent);
        for k in 0..if r == 0 || r == count - 1 { 1 } else { sectors } {
            let (sine, cosine) = (TAU * k as f64 / sectors as f64).sin_cos();
            surface
                .positions
                .push(centre + radius * (cosine * side + sine * DVec3::Z));
        }
    }
    let vertex = |r: usize, k: usize| match r {
        0 => 0,
        _ if r == count - 1 => (surface.positions.len() - 1) as u32,
        _ => (1 + (r - 1) * sectors + k % sectors) as u32,
    };
    for r in 0..count - 1 {
        for k in 0..sectors {
            let [a, b, c, d] = [
                vertex(r, k),
                vertex(r, k + 1),
                vertex(r + 1, k + 1),
                vertex(r + 1, k),
            ];
            let halves = [[a, b, c], [a, c, d]];
            let whole = |t: &[u32; 3]| t[0] != t[1] && t[1] != t[2] && t[2] != t[0];
            surface.triangles.extend(halves.into_iter().filter(whole));
        }
    }
    assert!(surface.is_closed() && surface.volume() > 0.0);
    surface
}

fn line(from: DVec3, to: DVec3, steps: usize) -> Vec<DVec3> {
    (0..=steps)
        .map(|i| from.lerp(to, i as f64 / steps as f64))
        .collect()
}

/// Two parallel fingers along x, `gap` apart, on a bend at x < 0 that is their palm; and the bones of
/// the fingers and of the bend.
fn hairpin(radius: f64, gap: f64, length: f64) -> (Surface, Vec<Surface>) {
    let y = radius + 0.5 * gap;
    let (tip, root) = (DVec3::new(length, y, 0.0), DVec3::new(0.0, y, 0.0));
    let down = |p: DVec3| DVec3::new(p.x, -p.y, p.z);
    let bend = (1..12).map(|i| {
        let (sine, cosine) = (PI * i as f64 / 12.0).sin_cos();
        DVec3::new(-y * sine, y * cosine, 0.0)
    });
    let mut path = line(tip, root, 16);
    path.extend(bend.clone());
    path.extend(line(down(root), down(tip), 16));
    let bone = |path: &[DVec3]| tube(path, 0.7 * radius);
    let bend: Vec<DVec3> = bend.collect();
    let upper = bone(&line(tip, root + 0.3 * length * DVec3::X, 8));
    let lower = bone(&line(down(root) + 0.3 * length * DVec3::X, down(tip), 8));
    (tube(&path, radius), vec![bone(&bend), upper, lower])
}

/// What every layer must keep; returns the number of nodes that share their place with another.
fn check(layer: &LayerMesh, skin: &Surface, bones: usize) -> usize {
    layer.validate(skin.positions.len(), bones).unwrap();
    let quality = MeshQuality::of(&layer.mesh);
    assert_eq!(quality.inverted, 0);
    assert!(
        quality.smallest_dihedral > 59.9 && quality.largest_dihedral < 90.1,
        "{quality}"
    );
    for (v, row) in layer.skin_embedding.iter().enumerate() {
        assert!(
            row.iter().all(|(_, share)| (-1e-9..=1.0).contains(share)),
            "vertex {v}: {row:?}"
        );
        let place: DVec3 = row
            .iter()
            .map(|&(n, share)| share * layer.mesh.nodes[n as usize])
            .sum();
        assert!((place - skin.positions[v]).length() < 1e-12, "vertex {v}");
        let mut nodes: Vec<u32> = row.iter().map(|e| e.0).collect();
        nodes.sort_unstable();
        assert!(layer.mesh.tets.iter().any(|tet| {
            let mut tet = *tet;
            tet.sort_unstable();
            tet[..] == nodes[..]
        }));
    }
    let parts = parts(layer, |_| true);
    let held: BTreeSet<usize> = (layer.bone_of_node.iter().zip(&parts))
        .filter_map(|(bone, part)| bone.and(*part))
        .collect();
    assert!(
        parts.iter().flatten().all(|part| held.contains(part)),
        "a part floats"
    );
    let places: BTreeSet<[u64; 3]> = (layer.mesh.nodes.iter())
        .map(|p| p.to_array().map(f64::to_bits))
        .collect();
    layer.mesh.nodes.len() - places.len()
}

/// The part of each node when only tets whose corners all satisfy `keep` connect; parts are named by
/// their smallest node.
fn parts(layer: &LayerMesh, keep: impl Fn(DVec3) -> bool) -> Vec<Option<usize>> {
    let mesh = &layer.mesh;
    let mut part: Vec<Option<usize>> = vec![None; mesh.nodes.len()];
    let kept: Vec<usize> = (0..mesh.tets.len())
        .filter(|&t| mesh.corners(t).into_iter().all(&keep))
        .collect();
    let mut around: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
    for &t in &kept {
        mesh.tets[t]
            .iter()
            .for_each(|&n| around.entry(n).or_default().push(t));
    }
    for &start in around.keys() {
        let mut open = vec![start];
        while let Some(n) = open.pop() {
            if part[n as usize].is_none() {
                part[n as usize] = Some(start as usize);
                open.extend(around[&n].iter().flat_map(|&t| mesh.tets[t]));
            }
        }
    }
    part
}

fn size_of(parts: &[Option<usize>]) -> usize {
    parts.iter().flatten().collect::<BTreeSet<_>>().len()
}

#[test]
fn a_finger_around_its_bone() {
    let skin = tube(&line(DVec3::ZERO, DVec3::new(0.045, 0.013, 0.0), 20), 0.009);
    let bone = tube(
        &line(
            DVec3::new(0.004, 0.001, 0.0),
            DVec3::new(0.04, 0.011, 0.0),
            12,
        ),
        0.004,
    );
    for cell in [0.0018, 0.0027, 0.0041] {
        let layer = lattice(&skin, std::slice::from_ref(&bone), LatticeSize::Cell(cell)).unwrap();
        // The solid is convex: hardly a node needs a double (where what joins two tips of the solid
        // is too small for a sample).
        let doubled = check(&layer, &skin, 1);
        assert!(
            100 * doubled < layer.mesh.nodes.len(),
            "cell {cell}: {doubled}"
        );
        let ratio = layer.tissue_volume() / (skin.volume() - bone.volume());
        assert!((ratio - 1.0).abs() < 0.01, "cell {cell}: volume {ratio}");
        // Whole tets would overstate it.
        assert!(MeshQuality::of(&layer.mesh).volume > 1.2 * layer.tissue_volume());
        assert_eq!(size_of(&parts(&layer, |_| true)), 1);
        let again = lattice(&skin, std::slice::from_ref(&bone), LatticeSize::Cell(cell)).unwrap();
        assert!(layer == again);
        for (place, held) in layer.mesh.nodes.iter().zip(&layer.bone_of_node) {
            let axis = DVec3::new(0.036, 0.010, 0.0).normalize();
            let from = *place - DVec3::new(0.004, 0.001, 0.0);
            let distance = (from - axis * from.dot(axis).clamp(0.0, 0.0374)).length() - 0.004;
            // The polyhedral bone lies up to 1 % of its radius inside the round one.
            match held {
                Some(_) => assert!(distance < 0.25 * cell + 1e-9),
                None => assert!(distance > 0.25 * cell - 1e-4),
            }
        }
    }
}

#[test]
fn fingers_that_nearly_touch_are_not_bridged() {
    let radius = 0.008;
    // Gaps far below a cell, and below the distance of samples too.
    for (gap, cell) in [
        (0.004, 0.003),
        (0.0005, 0.003),
        (0.00005, 0.003),
        (0.0001, 0.0045),
    ] {
        let (skin, bones) = hairpin(radius, gap, 0.05);
        let layer = lattice(&skin, &bones, LatticeSize::Cell(cell)).unwrap();
        let doubled = check(&layer, &skin, 3);
        if gap < cell / 4.0 {
            assert!(doubled > 20, "gap {gap}: {doubled}");
        }
        let solid: f64 = skin.volume() - bones.iter().map(Surface::volume).sum::<f64>();
        assert!(
            (layer.tissue_volume() / solid - 1.0).abs() < 0.01,
            "gap {gap}"
        );
        // Whole, it is one part; without the bend and the cell beside it, the fingers are two.
        assert_eq!(size_of(&parts(&layer, |_| true)), 1);
        let fingers = parts(&layer, |p| p.x > cell);
        assert_eq!(size_of(&fingers), 2, "gap {gap}, cell {cell}");
        let side_of_part: BTreeMap<usize, bool> = (skin.positions.iter())
            .zip(layer.skin_embedding.iter())
            .filter(|(p, _)| p.x > 0.02)
            .map(|(p, row)| (fingers[row[0].0 as usize].unwrap(), p.y > 0.0))
            .collect();
        assert_eq!(side_of_part.len(), 2);
        for (p, row) in skin.positions.iter().zip(layer.skin_embedding.iter()) {
            if p.x > 0.02 {
                assert!(
                    row.iter()
                        .all(|e| side_of_part[&fingers[e.0 as usize].unwrap()] == (p.y > 0.0))
                );
            }
        }
        // No bone reaches into the finger beside it.
        for (part, bone) in fingers.iter().zip(&layer.bone_of_node) {
            if let (Some(part), Some(bone @ 1..=2)) = (part, bone) {
                assert_eq!(side_of_part[part], *bone == 1);
            }
        }
    }
}

#[test]
fn skins_that_cut_themselves_are_one_solid() {
    // Fingers of 8 mm radius whose axes are 13 mm apart.
    let (skin, bones) = hairpin(0.008, -0.003, 0.05);
    let layer = lattice(&skin, &bones, LatticeSize::Cell(0.003)).unwrap();
    check(&layer, &skin, 3);
    let counted_twice = skin.volume() - bones.iter().map(Surface::volume).sum::<f64>();
    assert!(layer.tissue_volume() < 0.99 * counted_twice);
}

#[test]
fn the_size_follows_the_wanted_nodes() {
    let (skin, bones) = hairpin(0.008, 0.001, 0.05);
    for nodes in [1000, 5000] {
        let layer = lattice(&skin, &bones, LatticeSize::Nodes(nodes)).unwrap();
        let ratio = layer.mesh.nodes.len() as f64 / nodes as f64;
        assert!((0.9..1.1).contains(&ratio), "{ratio}");
    }
}

#[test]
fn open_bones_lone_skins_and_bad_sizes_are_errors() {
    let (mut skin, bones) = hairpin(0.008, 0.001, 0.05);
    let message = |skin: &Surface, bones: &[Surface], size| {
        lattice(skin, bones, size).unwrap_err().to_string()
    };
    let cell = LatticeSize::Cell(0.004);
    assert!(message(&skin, &[], cell).contains("no bone"));
    for size in [
        LatticeSize::Cell(f64::NAN),
        LatticeSize::Cell(-1.0),
        LatticeSize::Cell(1e-9),
        LatticeSize::Nodes(0),
        LatticeSize::Nodes(usize::MAX),
    ] {
        message(&skin, &bones, size);
    }
    let mut open = bones.clone();
    open[1].triangles.pop();
    assert!(message(&skin, &open, cell).contains("bones[1]"));
    skin.positions[3].x = f64::NAN;
    assert!(message(&skin, &bones, cell).contains("not finite"));
}

#[test]
fn the_sample_hand() {
    let hand = hand().unwrap();
    let skin = Surface {
        positions: hand.model.template.clone(),
        triangles: hand.model.triangles.clone(),
    };
    let start = std::time::Instant::now();
    let layer = lattice(&skin, &hand.bones, LatticeSize::Nodes(20_000)).unwrap();
    let quality = MeshQuality::of(&layer.mesh);
    println!("{quality} in {:?}", start.elapsed());
    assert!((19_000..21_000).contains(&quality.nodes));
    let doubled = check(&layer, &skin, hand.bones.len());
    assert!(100 * doubled < quality.nodes, "{doubled}");
    let bones: f64 = hand.bones.iter().map(Surface::volume).sum();
    let ratio = layer.tissue_volume() / (skin.volume() - bones);
    assert!((ratio - 1.0).abs() < 0.01, "{ratio}");
    for bone in 0..hand.bones.len() as u32 {
        assert!(
            layer.bone_of_node.contains(&Some(bone)),
            "bone {bone} holds no node"
        );
    }
}

/// Fingers pressed together until they nearly touch, and a cell as wide as a finger's radius: the
/// fingers' outer two bones share no node.
#[test]
fn the_sample_hand_with_its_fingers_together() {
    let hand = hand().unwrap();
    let parents = &hand.model.parents;
    // The finger of a middle or distal bone: the child of the wrist it hangs on.
    let finger = |bone: u32| {
        let parent = parents[bone as usize]?;
        let grandparent = parents[parent as usize]?;
        Some(if parents[grandparent as usize].is_none() {
            parent
        } else {
            grandparent
        })
    };
    let finger_of_vertex: Vec<Option<u32>> = (hand.model.weights.iter())
        .map(|row| {
            row.iter()
                .find(|w| w.weight > 0.6)
                .and_then(|w| finger(w.bone))
        })
        .collect();
    for squeeze in [1.0, 0.85] {
        let narrow = |p: &DVec3| DVec3::new(p.x, squeeze * p.y, p.z);
        let surface = |positions: &[DVec3], triangles: &[[u32; 3]]| Surface {
            positions: positions.iter().map(narrow).collect(),
            triangles: triangles.to_vec(),
        };
        let skin = surface(&hand.model.template, &hand.model.triangles);
        let bones: Vec<Surface> = (hand.bones.iter())
            .map(|bone| surface(&bone.positions, &bone.triangles))
            .collect();
        let layer = lattice(&skin, &bones, LatticeSize::Cell(0.007)).unwrap();
        check(&layer, &skin, bones.len());
        let mut owner: BTreeMap<u32, u32> = BTreeMap::new();
        for (finger, row) in finger_of_vertex.iter().zip(layer.skin_embedding.iter()) {
            for (node, finger) in row.iter().filter_map(|e| Some((e.0, (*finger)?))) {
                assert_eq!(
                    *owner.entry(node).or_insert(finger),
                    finger,
                    "squeeze {squeeze}"
                );
            }
        }
        assert_eq!(owner.values().collect::<BTreeSet<_>>().len(), 5);
    }
}
