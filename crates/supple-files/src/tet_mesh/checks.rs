//! What every tet mesh that comes in must be: its tets oriented and not flat, its faces shared by two
//! at most.

use glam::DVec3;
use supple::model::TetMesh;

/// A tet counts as flat below this volume relative to its longest edge cubed (a regular one has 0.118).
const FLAT: f64 = 1e-9;

/// Whether a node is somewhere: the square of a length must stay finite too.
pub(super) fn is_place(node: DVec3) -> bool {
    node.is_finite() && node.abs().max_element() <= 1e100
}

/// Turns tet `t` of `mesh` to positive volume.
pub(super) fn orient(mesh: &mut TetMesh, t: usize) -> Result<(), &'static str> {
    let [a, b, c, d] = mesh.corners(t);
    let longest = [b - a, c - a, d - a, c - b, d - b, d - c]
        .iter()
        .fold(0.0, |longest: f64, edge| longest.max(edge.length()));
    // Scaled first, so that a huge or tiny mesh does not overflow or vanish.
    let volume = ((b - a) / longest)
        .cross((c - a) / longest)
        .dot((d - a) / longest)
        / 6.0;
    if volume.is_nan() || volume.abs() <= FLAT {
        return Err("is flat: remove the tet or move its nodes apart");
    }
    if volume < 0.0 {
        mesh.tets[t].swap(2, 3);
    }
    Ok(())
}

/// Every face in two tets at most, no tet twice; the tet at fault.
pub(super) fn check_topology(mesh: &TetMesh) -> Result<(), (usize, String)> {
    let mut faces = Vec::with_capacity(4 * mesh.tets.len());
    for t in 0..mesh.tets.len() {
        faces.extend(mesh.faces(t).into_iter().map(|mut face| {
            face.sort_unstable();
            (face, t)
        }));
    }
    faces.sort_unstable();
    if let Some(crowd) = faces.chunk_by(|a, b| a.0 == b.0).find(|c| c.len() > 2) {
        let problem = format!("is the third tet on face {:?}: remove one", crowd[2].0);
        return Err((crowd[2].1, problem));
    }
    let mut tets: Vec<([u32; 4], usize)> = Vec::with_capacity(mesh.tets.len());
    tets.extend(mesh.tets.iter().enumerate().map(|(t, tet)| {
        let mut tet = *tet;
        tet.sort_unstable();
        (tet, t)
    }));
    tets.sort_unstable();
    match tets.windows(2).find(|w| w[0].0 == w[1].0) {
        Some(twins) => Err((twins[1].1, "repeats a tet: remove it".into())),
        None => Ok(()),
    }
}

/// Whether each node is in a tet.
pub(super) fn used_nodes(mesh: &TetMesh) -> Vec<bool> {
    let mut used = vec![false; mesh.nodes.len()];
    mesh.tets
        .iter()
        .flatten()
        .for_each(|&n| used[n as usize] = true);
    used
}
