//! Worlds: avatars of several assets, colliders and bodies together.

mod bodies;
mod coming_and_going;
mod contacts;
mod driving;
mod fine;
#[cfg(feature = "gpu")]
mod gpu;
mod offsets;
mod previous_skins;
mod skin_springs;
mod snapshots;
mod springs;

use crate::support;
use std::sync::Arc;
use supple::model::Avatar;
use supple::sim::{Settings, SolverMode};
use supple::world::Backend;
use supple::{Result, World};
use supple_samples::Limb;

/// A limb around one bone along x, captured under gravity.
fn limb(stations: usize, sectors: usize) -> Arc<Avatar> {
    let limb = Limb {
        stations,
        layers: 1,
        sectors,
        ..support::SMALL
    };
    Arc::new(support::full_space_limb(&limb, 1, true))
}

/// A world on the CPU whose steps are minimised to rounding.
const CONVERGED: SolverMode = SolverMode::Converged {
    tolerance: 1e-11,
    max_iterations: 100,
};

fn converged() -> Result<World> {
    World::new(Backend::Cpu)?.with_settings(Settings {
        solver: CONVERGED,
        report_at_end: true,
        ..Settings::default()
    })
}
