//! Energy differences on the GPU: the trials of a line search.

use super::dispatch::Batch;
use super::evaluate::energies;
use super::potential::{GpuPotential, Start};
use super::shared::{BatchState, Summary};
use super::stage::Stage;
use crate::Result;
use crate::potential::Trial;

/// E(state) − E(base) of each trial; as many at once as the options have room for.
pub(super) async fn energy_differences(
    potential: &mut GpuPotential,
    trials: &[Trial<'_>],
    out: &mut [f64],
) -> Result<()> {
    let begun = |i: usize| potential.starts[i].is_some();
    potential.checks.trials(trials, out.len(), begun)?;
    let instances = potential.starts.len();
    let most = potential.options.trials.max(1);
    for (trials, out) in trials.chunks(most).zip(out.chunks_mut(most)) {
        potential.clear_uploads();
        // First the trials, then the bases they are measured from, each base once.
        let mut bases: Vec<&Trial<'_>> = Vec::new();
        for trial in trials {
            let Start {
                origin,
                batch_state,
                ..
            } = potential.start(trial.instance)?.clone();
            let base = bases
                .iter()
                .position(|b| b.instance == trial.instance && b.base == trial.base)
                .unwrap_or_else(|| {
                    bases.push(trial);
                    bases.len() - 1
                });
            let batch_state = BatchState {
                slot: (instances + potential.batch.len()) as u32,
                base: (instances + trials.len() + base) as u32,
                ..batch_state
            };
            potential.push_state(batch_state, trial.base, trial.state, origin);
        }
        for trial in bases {
            let Start {
                origin,
                current,
                batch_state,
                ..
            } = potential.start(trial.instance)?.clone();
            let batch_state = BatchState {
                slot: (instances + potential.batch.len()) as u32,
                base: batch_state.instance,
                ..batch_state
            };
            potential.push_state(batch_state, &current, trial.base, origin);
        }
        potential.upload(instances);
        let all = Batch::whole(potential.batch.len());
        let bytes = (trials.len() * size_of::<Summary>()) as u64;
        potential.submit(
            |stages, pass| {
                stages.displacement.dispatch(pass, all);
                stages.contact.dispatch(pass, all);
                if potential.has_friction {
                    stages.friction.dispatch(pass, all);
                }
                stages.energy.dispatch(pass, Batch::whole(trials.len()));
            },
            |encoder| {
                let summaries = potential.buffers.common.summaries.raw();
                potential.readback.record(encoder, summaries, 0..bytes, 0);
            },
        );
        let unpack = |bytes: &[u8]| {
            let summaries = bytes.chunks_exact(size_of::<Summary>());
            for (out, bytes) in out.iter_mut().zip(summaries) {
                let energies = energies(&bytemuck::pod_read_unaligned(bytes));
                *out = energies.map_or(f64::NAN, |e| e.total());
            }
        };
        potential
            .readback
            .read(&potential.device, bytes, unpack)
            .await?;
    }
    Ok(())
}
