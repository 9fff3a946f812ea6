//! Marching tetrahedra: a closed manifold triangle mesh of an implicit function's zero level.

use glam::{DVec3, IVec3};
use std::collections::HashMap;
use supple::internal::math::par_map;

/// The six tetrahedra of a cube around its diagonal 0–7 (corner bits: x, y, z); neighbouring cubes
/// agree on their common face's diagonal, so that the mesh is closed.
const TETS: [[usize; 4]; 6] = [
    [0, 1, 3, 7],
    [0, 3, 2, 7],
    [0, 2, 6, 7],
    [0, 6, 4, 7],
    [0, 4, 5, 7],
    [0, 5, 1, 7],
];

/// Grid points along a block's side.
const BLOCK: usize = 4;
/// How far a field may exceed the distance: it is close to it only near its zero level.
const SAFETY: f64 = 2.0;

/// Triangles of {f = 0} on a grid of `cell` over the box, outward where `f` grows outward.
pub(super) fn polygonise(
    low: DVec3,
    high: DVec3,
    cell: f64,
    f: impl Fn(DVec3) -> f64 + Sync + Send,
) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let size = ((high - low) / cell).ceil().as_ivec3() + IVec3::ONE;
    let (nx, ny, nz) = (size.x as usize, size.y as usize, size.z as usize);
    let point = |i: usize| {
        low + cell
            * DVec3::new(
                (i % nx) as f64,
                (i / nx % ny) as f64,
                (i / (nx * ny)) as f64,
            )
    };
    // Blocks far from the surface take the value of their middle, of which only the sign counts.
    let blocks = size.as_usizevec3().map(|n| n.div_ceil(BLOCK));
    let reach = SAFETY * 0.5 * cell * (BLOCK - 1) as f64 * 3f64.sqrt();
    let far: Vec<Option<f64>> = par_map(blocks.x * blocks.y * blocks.z, |b| {
        let corner = [
            b % blocks.x,
            b / blocks.x % blocks.y,
            b / (blocks.x * blocks.y),
        ];
        let middle = corner.map(|c| (c * BLOCK) as f64 + 0.5 * (BLOCK - 1) as f64);
        let value = f(low + cell * DVec3::from_array(middle));
        (value.abs() > reach).then_some(value)
    });
    let values: Vec<f64> = par_map(nz, |z| {
        (z * nx * ny..(z + 1) * nx * ny)
            .map(|i| {
                let block = [i % nx, i / nx % ny, z].map(|c| c / BLOCK);
                far[block[0] + blocks.x * (block[1] + blocks.y * block[2])]
                    .unwrap_or_else(|| f(point(i)))
            })
            .collect::<Vec<_>>()
    })
    .into_iter()
    .flatten()
    .collect();
    let mut vertex_of_edge: HashMap<(usize, usize), u32> = HashMap::new();
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    let mut cut = |a: usize, b: usize| {
        *vertex_of_edge
            .entry((a.min(b), a.max(b)))
            .or_insert_with(|| {
                let (lo, hi) = (a.min(b), a.max(b));
                // Off the corners, so that no triangle collapses to a point.
                let t = (values[lo] / (values[lo] - values[hi])).clamp(0.02, 0.98);
                positions.push(point(lo).lerp(point(hi), t));
                positions.len() as u32 - 1
            })
    };
    for z in 0..nz - 1 {
        for y in 0..ny - 1 {
            for x in 0..nx - 1 {
                let corner = |c: usize| x + (c & 1) + nx * (y + (c >> 1 & 1) + ny * (z + (c >> 2)));
                for tet in TETS {
                    let ids = tet.map(corner);
                    let (inside, outside): (Vec<usize>, Vec<usize>) =
                        ids.iter().partition(|&&i| values[i] < 0.0);
                    let polygon: Vec<u32> = match (inside.as_slice(), outside.as_slice()) {
                        (&[a], o) => o.iter().map(|&b| cut(a, b)).collect(),
                        (i, &[b]) => i.iter().map(|&a| cut(a, b)).collect(),
                        (&[a, b], &[c, d]) => vec![cut(a, c), cut(a, d), cut(b, d), cut(b, c)],
                        _ => continue,
                    };
                    let outward: DVec3 = outside.iter().map(|&i| point(i)).sum::<DVec3>()
                        / outside.len() as f64
                        - inside.iter().map(|&i| point(i)).sum::<DVec3>() / inside.len() as f64;
                    for k in 1..polygon.len() - 1 {
                        triangles.push((([polygon[0], polygon[k], polygon[k + 1]]), outward));
                    }
                }
            }
        }
    }
    let triangles = triangles
        .into_iter()
        .map(|([a, b, c], outward)| {
            let [p, q, r] = [a, b, c].map(|v| positions[v as usize]);
            if (q - p).cross(r - p).dot(outward) < 0.0 {
                [a, c, b]
            } else {
                [a, b, c]
            }
        })
        .collect();
    (positions, triangles)
}
