//! A soft layer's tets cut open.

use super::{Colour, Mesh, Plane, from_srgb};
use glam::DVec3;
use std::collections::HashMap;
use supple::model::{SoftLayer, Surface, TetMesh};

/// Faces towards the outside.
const SKIN: u32 = 0xd9b8a0;
/// Faces that the cut lays bare.
const FLESH: u32 = 0xcf6a5c;
/// Faces that bones hold.
const BONE: u32 = 0xeadfc0;
/// How much darker a face's rim is.
const RIM: f32 = 0.42;

/// The tets of `layer` whose centroids `plane` does not hide, whole: what faces outward has the colour of skin, what
/// bones hold that of bone, and what the cut lays bare that of flesh. Every face has a dark rim, so that the mesh is
/// seen. Nothing of it is opened again by a clipping plane.
pub fn cut_layer(layer: &SoftLayer, plane: &Plane) -> Mesh {
    let mesh = &layer.mesh;
    let kept = |t: usize| plane.distance(mesh.centroid(t)) <= 0.0;
    let owners = owners(mesh);
    let mut out = Mesh::new(Surface::default(), [0.0; 3]);
    for t in (0..mesh.tets.len()).filter(|&t| kept(t)) {
        for face in mesh.faces(t) {
            let neighbour = owners[&sorted(face)].iter().find(|&&o| o != t as u32);
            let colour = match neighbour {
                Some(&n) if kept(n as usize) => continue,
                Some(_) => FLESH,
                None if (face.iter()).all(|&n| layer.bone_of_node[n as usize].is_some()) => BONE,
                None => SKIN,
            };
            let corners = face.map(|n| mesh.nodes[n as usize]);
            add_face(&mut out, corners, from_srgb(colour));
        }
    }
    out
}

/// The one or two tets of each face.
fn owners(mesh: &TetMesh) -> HashMap<[u32; 3], Vec<u32>> {
    let mut owners: HashMap<[u32; 3], Vec<u32>> = HashMap::with_capacity(2 * mesh.tets.len());
    for t in 0..mesh.tets.len() {
        for face in mesh.faces(t) {
            owners.entry(sorted(face)).or_default().push(t as u32);
        }
    }
    owners
}

fn sorted(mut face: [u32; 3]) -> [u32; 3] {
    face.sort_unstable();
    face
}

/// A flat triangle in a rim a seventh of its height wide.
fn add_face(mesh: &mut Mesh, outer: [DVec3; 3], colour: Colour) {
    let [a, b, c] = outer;
    let normal = (b - a).cross(c - a).normalize_or_zero();
    let centre = (a + b + c) / 3.0;
    let inner = outer.map(|p| centre + 0.8 * (p - centre));
    let rim = colour.map(|c| RIM * c);
    let mut add = |corners: [DVec3; 3], colour: Colour| {
        let first = mesh.surface.positions.len() as u32;
        mesh.surface.positions.extend(corners);
        mesh.surface.triangles.push([first, first + 1, first + 2]);
        mesh.normals.extend([normal; 3]);
        mesh.colours.extend([colour; 3]);
    };
    add(inner, colour);
    for k in 0..3 {
        let next = (k + 1) % 3;
        add([outer[k], outer[next], inner[next]], rim);
        add([outer[k], inner[next], inner[k]], rim);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use supple_samples::Limb;

    /// The faces shown enclose what was kept, whatever the plane.
    #[test]
    fn a_cut_encloses_the_tets_that_are_kept() {
        let body = Limb::S.body().unwrap();
        let layer = SoftLayer {
            mesh: body.layer.mesh.clone(),
            bone_of_node: body.layer.bone_of_node.clone(),
            ..SoftLayer::default()
        };
        for normal in [DVec3::X, DVec3::new(0.3, -1.0, 0.4), DVec3::ZERO] {
            let plane = Plane {
                point: DVec3::new(0.11, 0.003, 0.001),
                normal,
            };
            let cut = cut_layer(&layer, &plane);
            let tets = 0..layer.mesh.tets.len();
            let kept = tets.filter(|&t| plane.distance(layer.mesh.centroid(t)) <= 0.0);
            let volume: f64 = kept.map(|t| layer.mesh.volume(t)).sum();
            let enclosed = cut.surface.volume();
            assert!(
                (enclosed / volume - 1.0).abs() < 1e-9,
                "{enclosed} {volume}"
            );
        }
    }
}
