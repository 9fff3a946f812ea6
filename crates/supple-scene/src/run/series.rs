//! A run's steps as arrays.

use supple::Result;
use supple::internal::cpu::skin_displacement;
use supple::model::Avatar;
use supple::potential::Potential;
use supple::sim::{Simulation, StepEnergies, StepReport};
use supple_files::{Series, energy_terms, loads_by_bone};

/// An empty series of `avatar`.
pub(super) fn empty(avatar: &Avatar) -> Series {
    Series {
        faces: avatar.triangles.clone(),
        bone_names: avatar.skeleton.names.clone(),
        ..Series::default()
    }
}

/// Adds the step that `simulation` has just made and ended at `time`, s.
pub(super) fn add<P: Potential>(
    series: &mut Series,
    avatar: &Avatar,
    simulation: &mut Simulation<P>,
    time: f64,
    report: &StepReport,
) -> Result<()> {
    let (mut positions, mut normals) = (Vec::new(), Vec::new());
    simulation.read_skin_blocking(0, &mut positions, &mut normals)?;
    series.time.push(time);
    series.vertices.append(&mut positions);
    let state = simulation.instances()[0].state.clone();
    (series.displacement).append(&mut skin_displacement(avatar, &state));
    let (mut forces, mut pressures) = (Vec::new(), Vec::new());
    let potential = simulation.potential_mut();
    pollster::block_on(potential.read_contacts(0, &state, &mut forces, &mut pressures))?;
    series.contact_force.append(&mut forces);
    let report = &report.instances[0];
    (series.loads).append(&mut loads_by_bone(&report.loads, avatar.skeleton.len()));
    series.energies.push(energy_terms(&StepEnergies {
        tissue: report.energies,
        skeleton: report.skeleton_energies,
    }));
    Ok(())
}
