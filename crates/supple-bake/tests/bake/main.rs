//! Baking: a limb, a finger and a hand from mesh to file.

mod basis;
mod bodies;
mod cubature;
mod errors;
mod file;
mod fine;
mod interior;
mod large;
mod lattice;
mod limb;
mod meshing;
mod softness;
#[path = "../../../supple-samples/src/tests/surface.rs"]
mod surface;
mod tissue;

use supple::model::Avatar;
use supple_bake::{Body, HandleCandidates, HandleRegion, Recipe, Truncation, bake};
use supple_samples::Limb;

/// A limb small enough for a file of a few kilobytes.
const TINY: Limb = Limb {
    length: 0.06,
    inner_radius: 0.015,
    outer_radius: 0.04,
    stations: 3,
    layers: 2,
    sectors: 6,
};

fn recipe(candidates: HandleCandidates, count: usize) -> Recipe {
    Recipe {
        handles: vec![HandleRegion {
            candidates,
            count: Some(count),
            ..Default::default()
        }],
        ..Default::default()
    }
}

fn untruncated(recipe: Recipe) -> Recipe {
    Recipe {
        truncation: Truncation::OFF,
        ..recipe
    }
}

fn baked(body: &Body, recipe: &Recipe) -> Avatar {
    bake(body, recipe, &mut |_| {}).unwrap().0
}
