//! Isotropic remeshing of an implicit surface to a given number of vertices.
//!
//! Split, collapse, flip, relax and project, after Botsch and Kobbelt (2004), with an edge length
//! that varies over the surface.

use super::topology::EditMesh;
use glam::DVec3;
use supple::internal::math::par_map;

/// What the remesher asks of a surface. Lengths in mm.
pub(super) trait Implicit: Sync {
    /// The field: negative inside, about the distance near its zero level.
    fn distance(&self, p: DVec3) -> f64;

    /// Wanted edge length near `p`, up to a common factor.
    fn edge_length(&self, p: DVec3) -> f64;

    /// `p` moved onto the zero level by Newton steps along the gradient.
    fn project(&self, mut p: DVec3) -> DVec3 {
        for _ in 0..4 {
            let value = self.distance(p);
            let h = 1e-4;
            let slope = DVec3::AXES.map(|e| (self.distance(p + h * e) - value) / h);
            let slope = DVec3::from_array(slope);
            if value.abs() < 1e-5 || slope.length_squared() < 1e-6 {
                break;
            }
            p -= (value / slope.length_squared() * slope).clamp_length_max(3.0);
        }
        p
    }
}

/// Remeshes a closed surface to `vertices` vertices (more only where no edge can be collapsed).
pub(super) fn remesh(
    surface: &dyn Implicit,
    positions: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
    vertices: usize,
) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    remesh_to(surface, EditMesh::new(positions, triangles), vertices)
}

/// Remeshes half of a symmetric surface, open along one loop on x = 0, so that with its mirror image it
/// has `vertices` vertices. Those on the plane have x = 0 exactly.
pub(super) fn remesh_half(
    surface: &dyn Implicit,
    positions: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
    vertices: usize,
) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    remesh_to(surface, EditMesh::half(positions, triangles), vertices)
}

fn remesh_to(
    surface: &dyn Implicit,
    mut mesh: EditMesh,
    vertices: usize,
) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let mut factor = 1.0;
    for _ in 0..12 {
        let sizes = sizes(surface, &mesh);
        collapse_short(&mut mesh, surface, &sizes, factor);
        let sizes = self::sizes(surface, &mesh);
        split_long(&mut mesh, surface, &sizes, factor);
        improve(&mut mesh, surface, 2);
        // Edges per vertex are fixed, so the count goes with the inverse square of the length.
        let excess = mesh.vertex_count() as f64 / vertices as f64;
        factor *= excess.powf(0.4).clamp(0.7, 1.4);
    }
    settle(&mut mesh, surface, vertices);
    improve(&mut mesh, surface, 8);
    mesh.compact()
}

/// Wanted edge length at each vertex.
fn sizes(surface: &dyn Implicit, mesh: &EditMesh) -> Vec<f64> {
    par_map(mesh.positions.len(), |v| {
        if mesh.is_live(v as u32) {
            surface.edge_length(mesh.positions[v])
        } else {
            1.0
        }
    })
}

fn middle(mesh: &EditMesh, surface: &dyn Implicit, a: u32, b: u32) -> DVec3 {
    surface.project(0.5 * (mesh.positions[a as usize] + mesh.positions[b as usize]))
}

/// Where the ends of an edge meet: a vertex on the seam stays there.
fn meeting(mesh: &EditMesh, surface: &dyn Implicit, a: u32, b: u32) -> DVec3 {
    match (mesh.on_seam(a), mesh.on_seam(b)) {
        (true, false) => mesh.positions[a as usize],
        (false, true) => mesh.positions[b as usize],
        _ => middle(mesh, surface, a, b),
    }
}

fn collapse_short(mesh: &mut EditMesh, surface: &dyn Implicit, sizes: &[f64], factor: f64) {
    let wanted = |a: u32, b: u32| 0.5 * factor * (sizes[a as usize] + sizes[b as usize]);
    let mut moved = vec![false; mesh.positions.len()];
    // A vertex moves once a pass, so that lengths seen are current.
    loop {
        let mut collapsed = 0;
        let mut edges = mesh.edges();
        edges.retain(|&(a, b)| mesh.length(a, b) < 0.8 * wanted(a, b));
        edges.sort_by(|x, y| {
            let ratio = |e: &(u32, u32)| mesh.length(e.0, e.1) / wanted(e.0, e.1);
            ratio(x).total_cmp(&ratio(y)).then(x.cmp(y))
        });
        moved.iter_mut().for_each(|m| *m = false);
        for (a, b) in edges {
            if moved[a as usize] || moved[b as usize] {
                continue;
            }
            let target = meeting(mesh, surface, a, b);
            let long = |v: u32| {
                mesh.neighbours(v).into_iter().any(|n| {
                    n != a
                        && n != b
                        && mesh.positions[n as usize].distance(target) > 1.4 * wanted(v, n)
                })
            };
            if long(a) || long(b) {
                continue;
            }
            if mesh.collapse(a, b, target) {
                moved[a as usize] = true;
                moved[b as usize] = true;
                collapsed += 1;
            }
        }
        if collapsed == 0 {
            break;
        }
    }
}

fn split_long(mesh: &mut EditMesh, surface: &dyn Implicit, sizes: &[f64], factor: f64) {
    for (a, b) in mesh.edges() {
        let ends = 0.5 * (sizes[a as usize] + sizes[b as usize]);
        if mesh.length(a, b) > 0.9 * factor * ends {
            // A narrow feature may lie between the ends.
            let position = middle(mesh, surface, a, b);
            let wanted = factor * ends.min(surface.edge_length(position));
            if mesh.length(a, b) > 1.35 * wanted {
                mesh.split(a, b, position);
            }
        }
    }
}

/// Collapses the shortest or splits the longest edges one by one until the count is met.
fn settle(mesh: &mut EditMesh, surface: &dyn Implicit, vertices: usize) {
    while mesh.vertex_count() != vertices {
        let surplus = mesh.vertex_count() > vertices;
        let missing = mesh.vertex_count().abs_diff(vertices);
        let mut edges: Vec<(f64, u32, u32)> = mesh
            .edges()
            .into_iter()
            // In a half, edges of the seam for an odd number and all others for an even one.
            .filter(|&(a, b)| !mesh.is_half() || mesh.step(a, b) % 2 == missing % 2)
            .map(|(a, b)| {
                let at = 0.5 * (mesh.positions[a as usize] + mesh.positions[b as usize]);
                (mesh.length(a, b) / surface.edge_length(at), a, b)
            })
            .collect();
        edges.sort_by(|x, y| x.0.total_cmp(&y.0).then((x.1, x.2).cmp(&(y.1, y.2))));
        if surplus {
            let mut done = false;
            for (_, a, b) in edges {
                let position = meeting(mesh, surface, a, b);
                if mesh.collapse(a, b, position) {
                    done = true;
                    break;
                }
            }
            if !done {
                return;
            }
        } else if let Some(&(_, a, b)) = edges.last() {
            let position = middle(mesh, surface, a, b);
            mesh.split(a, b, position);
        }
    }
}

/// Flips towards valence 6, then moves vertices along the surface to even out the triangles.
fn improve(mesh: &mut EditMesh, surface: &dyn Implicit, rounds: usize) {
    for _ in 0..rounds {
        flip_to_regular(mesh);
        relax(mesh, surface);
    }
}

fn flip_to_regular(mesh: &mut EditMesh) {
    for (a, b) in mesh.edges() {
        let Some((c, d)) = mesh.wing(a, b) else {
            continue;
        };
        if mesh.is_poor(a) || mesh.is_poor(b) {
            continue;
        }
        // On the seam the mirror image flips as well.
        let deviation = |v: u32, change: f64| {
            let times = if mesh.on_seam(v) { 2.0 } else { 1.0 };
            (mesh.valence(v) as f64 + times * change - 6.0).powi(2)
        };
        let sum = |change: f64| {
            deviation(a, -change)
                + deviation(b, -change)
                + deviation(c, change)
                + deviation(d, change)
        };
        let (before, after) = (sum(0.0), sum(1.0));
        // Ties go to the shorter diagonal.
        let shorter = mesh.length(c, d) < 0.8 * mesh.length(a, b);
        if after < before || (after == before && shorter) {
            mesh.flip(a, b);
        }
    }
}

/// Area-weighted tangential smoothing with back-projection.
fn relax(mesh: &mut EditMesh, surface: &dyn Implicit) {
    let sizes = sizes(surface, mesh);
    let moved: Vec<DVec3> = par_map(mesh.positions.len(), |v| {
        let v = v as u32;
        let here = mesh.positions[v as usize];
        if !mesh.is_live(v) {
            return here;
        }
        let (mut centre, mut total, mut normal) = (DVec3::ZERO, 0.0, DVec3::ZERO);
        for t in mesh.triangles_around(v) {
            let area = mesh.area_vector(t);
            let centroid: DVec3 =
                t.iter().map(|&w| mesh.positions[w as usize]).sum::<DVec3>() / 3.0;
            let size: f64 = t.iter().map(|&w| sizes[w as usize]).sum();
            let weight = area.length() / (size * size);
            centre += weight * centroid;
            total += weight;
            normal += area;
        }
        let step = centre / total - here;
        if !mesh.on_seam(v) {
            let step = step.reject_from(normal.normalize_or(DVec3::Z));
            return surface.project(here + 0.7 * step);
        }
        // The mirror images of the triangles balance the other half.
        let flat = |d: DVec3| DVec3::new(0.0, d.y, d.z);
        let step = flat(step).reject_from(flat(normal).normalize_or(DVec3::Z));
        flat(surface.project(here + 0.7 * step))
    });
    mesh.positions = moved;
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::polygonise::polygonise;
    use supple::model::Surface;

    /// A sphere whose northern half wants edges half as long.
    struct Sphere(f64);

    impl Implicit for Sphere {
        fn distance(&self, p: DVec3) -> f64 {
            p.length() - self.0
        }

        fn project(&self, p: DVec3) -> DVec3 {
            self.0 * p.normalize()
        }

        fn edge_length(&self, p: DVec3) -> f64 {
            if p.z > 0.0 { 1.0 } else { 2.0 }
        }
    }

    #[test]
    fn a_sphere_keeps_its_shape_gets_its_count_and_follows_the_edge_lengths() {
        let sphere = Sphere(3.0);
        let box_size = DVec3::splat(3.7);
        let (positions, triangles) =
            polygonise(-box_size, box_size, 0.31, |p| p.length() - sphere.0);
        let raw = Surface {
            positions,
            triangles,
        };
        assert!(raw.is_closed());
        let volume = 4.0 / 3.0 * std::f64::consts::PI * sphere.0.powi(3);
        // Chords lie inside: a deficit of the order of (cell / radius)².
        assert!((0.97..1.0).contains(&(raw.volume() / volume)));
        for count in [150, 701] {
            let (positions, triangles) =
                remesh(&sphere, raw.positions.clone(), raw.triangles.clone(), count);
            let mesh = Surface {
                positions,
                triangles,
            };
            assert!(mesh.is_closed());
            assert_eq!(mesh.positions.len(), count);
            assert_eq!(mesh.triangles.len(), 2 * count - 4);
            assert!(
                mesh.positions
                    .iter()
                    .all(|p| (p.length() - 3.0).abs() < 1e-12)
            );
            // Half the edge length is four times the vertices: 80 % of them.
            let north = mesh.positions.iter().filter(|p| p.z > 0.0).count() as f64;
            assert!(
                (0.72..0.88).contains(&(north / count as f64)),
                "{north} of {count}"
            );
        }
    }

    #[test]
    fn half_a_sphere_keeps_its_border_on_the_plane_and_counts_with_its_mirror_image() {
        let sphere = Sphere(3.0);
        let (low, high) = (DVec3::new(0.0, -3.7, -3.7), DVec3::splat(3.7));
        let (positions, triangles) = polygonise(low, high, 0.31, |p| p.length() - sphere.0);
        for count in [151, 700] {
            let (positions, triangles) =
                remesh_half(&sphere, positions.clone(), triangles.clone(), count);
            let on_plane = positions.iter().filter(|p| p.x == 0.0).count();
            assert_eq!(2 * positions.len() - on_plane, count);
            assert_eq!(
                2 * triangles.len(),
                2 * count - 4,
                "closed, without a handle"
            );
            assert!(positions.iter().all(|p| p.x >= 0.0));
            assert!(positions.iter().all(|p| (p.length() - 3.0).abs() < 1e-12));
            // Edges without a second triangle are those of the plane, one for each vertex there.
            let directed = |&[a, b, c]: &[u32; 3]| [(a, b), (b, c), (c, a)];
            let edges: Vec<(u32, u32)> = triangles.iter().flat_map(directed).collect();
            let border = edges.iter().filter(|(a, b)| !edges.contains(&(*b, *a)));
            let ends: Vec<f64> = border
                .flat_map(|&(a, b)| [a, b].map(|v| positions[v as usize].x))
                .collect();
            assert!(ends.len() == 2 * on_plane && ends.iter().all(|x| *x == 0.0));
        }
    }
}
