//! A run's steps as arrays.

use glam::DVec3;
use supple::Result;
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

/// Adds the step that `simulation` has just made and ended at `time`, s, with its `skin` and that skin's displacement, m.
pub(super) fn add<P: Potential>(
    series: &mut Series,
    avatar: &Avatar,
    simulation: &mut Simulation<P>,
    time: f64,
    report: &StepReport,
    (skin, displacement): (&[DVec3], &[DVec3]),
) -> Result<()> {
    series.time.push(time);
    series.vertices.extend(skin);
    series.displacement.extend(displacement);
    let state = simulation.instances()[0].state.clone();
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
