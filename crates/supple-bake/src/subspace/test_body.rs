//! Avatars for the tests of this room.

use crate::basis::Truncation;
use crate::body::Body;
use crate::handles::HandleRegion;
use crate::recipe::Recipe;
use crate::test_mesh::jittered_box;
use crate::{bake, one_bone_body};
use supple::material::{Material, StableNeoHookean};
use supple::model::Avatar;

/// `body` baked with `handles` on its skin, untruncated, of tissue with this Poisson's ratio.
pub fn baked(body: &Body, handles: usize, poissons_ratio: f64) -> Avatar {
    let recipe = Recipe {
        material: Some(Material::StableNeoHookean(StableNeoHookean {
            youngs_modulus: 30e3,
            poissons_ratio,
        })),
        handles: vec![HandleRegion {
            count: Some(handles),
            ..HandleRegion::default()
        }],
        truncation: Truncation::OFF,
        ..Recipe::default()
    };
    bake(body, &recipe, &mut |_| {}).unwrap().0
}

/// A box of cells of 1 cm, jittered, on a bone that holds its lowest layer of nodes; the rest of its boundary is skin.
pub fn clamped_box(cells: [usize; 3], poissons_ratio: f64) -> Avatar {
    box_with_jitter(cells, poissons_ratio, 0.12)
}

/// The same with every node moved by up to `jitter` edges.
pub fn box_with_jitter(cells: [usize; 3], poissons_ratio: f64, jitter: f64) -> Avatar {
    let mesh = jittered_box(cells, 0.01, jitter, 17);
    let lowest = ((cells[0] + 1) * (cells[1] + 1)) as u32;
    let mut skin: Vec<u32> = mesh.boundary_triangles().into_iter().flatten().collect();
    skin.sort_unstable();
    skin.dedup();
    skin.retain(|n| *n >= lowest);
    let pinned: Vec<u32> = (0..lowest).collect();
    let body = one_bone_body("box", mesh, &pinned, &skin).unwrap();
    baked(&body, 8, poissons_ratio)
}
