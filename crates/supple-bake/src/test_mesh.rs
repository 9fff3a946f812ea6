//! Meshes for the tests of this room.

use glam::DVec3;
use supple::internal::math::Random;
use supple::model::TetMesh;

/// A box of `cells` cubes of edge `cell`, six tets each, every node moved by up to `jitter` edges.
pub fn jittered_box(cells: [usize; 3], cell: f64, jitter: f64, seed: u64) -> TetMesh {
    let mut random = Random::new(seed);
    let [nx, ny, nz] = cells.map(|c| c + 1);
    let node = |i: usize, j: usize, k: usize| (i + nx * (j + ny * k)) as u32;
    let mut mesh = TetMesh::default();
    for k in 0..nz {
        for j in 0..ny {
            for i in 0..nx {
                let corner = DVec3::new(i as f64, j as f64, k as f64);
                mesh.nodes
                    .push(cell * (corner + jitter * random.vector(1.0)));
            }
        }
    }
    // Kuhn's division: one tet for each order in which the three axes are walked.
    let orders = [
        [0, 1, 2],
        [1, 2, 0],
        [2, 0, 1],
        [1, 0, 2],
        [0, 2, 1],
        [2, 1, 0],
    ];
    for k in 0..cells[2] {
        for j in 0..cells[1] {
            for i in 0..cells[0] {
                for order in orders {
                    let mut at = [i, j, k];
                    let mut tet = [node(i, j, k); 4];
                    for (step, axis) in order.into_iter().enumerate() {
                        at[axis] += 1;
                        tet[step + 1] = node(at[0], at[1], at[2]);
                    }
                    mesh.tets.push(tet);
                    if mesh.volume(mesh.tets.len() - 1) < 0.0 {
                        tet.swap(2, 3);
                        *mesh.tets.last_mut().expect("a tet was pushed") = tet;
                    }
                }
            }
        }
    }
    mesh
}

/// A box in which some tets are partly tissue.
pub fn partly_tissue() -> (TetMesh, Vec<f64>) {
    let mesh = jittered_box([8, 7, 6], 0.01, 0.15, 21);
    let mut random = Random::new(22);
    let fraction = (mesh.tets.iter())
        .map(|_| {
            if random.uniform(0.0, 1.0) < 0.3 {
                0.2 + 0.8 * random.uniform(0.0, 1.0)
            } else {
                1.0
            }
        })
        .collect();
    (mesh, fraction)
}
