//! What each stage of an evaluation costs.

use super::potential::{GpuPotential, Stages};
use super::{Batch, shared::Summary};
use crate::Result;
use std::time::Instant;

type Dispatch = fn(&Stages, &mut wgpu::ComputePass<'_>, Batch);

/// The stages of begin_step, evaluate and pose_skin, in order.
const STAGES: &[(&str, Dispatch)] = &[
    ("pose_blend", |s, pass, b| {
        s.pose_blend.dispatch_cubature(pass, b);
    }),
    ("displacement", |s, pass, b| {
        s.displacement.dispatch(pass, b)
    }),
    ("elasticity", |s, pass, b| s.elasticity.dispatch(pass, b)),
    ("contact", |s, pass, b| s.contact.dispatch(pass, b)),
    ("friction", |s, pass, b| s.friction.dispatch(pass, b)),
    ("compact", |s, pass, b| s.compact.dispatch(pass, b)),
    ("gradient", |s, pass, b| s.gradient.dispatch(pass, b)),
    ("point_hessian", |s, pass, b| {
        s.point_hessian.dispatch(pass, b)
    }),
    ("hessian", |s, pass, b| s.hessian.dispatch(pass, b)),
    ("energy", |s, pass, b| s.energy.dispatch(pass, b)),
    ("posed pose_blend", |s, pass, b| {
        s.pose_blend.dispatch_posed_skin(pass, b)
    }),
    ("skin", |s, pass, b| s.skin.dispatch(pass, b)),
    ("normals", |s, pass, b| s.normals.dispatch(pass, b)),
];

impl GpuPotential {
    /// Least wall-clock seconds of each stage over `repeats` runs on the states of the last
    /// [`evaluate`](crate::potential::Potential::evaluate), every stage submitted and waited for by
    /// itself; the first entry is such a submission with nothing in it.
    ///
    /// # Errors
    /// [`crate::GpuError::DeviceLost`].
    pub async fn stage_times(&mut self, repeats: usize) -> Result<Vec<(&'static str, f64)>> {
        let empty: (&str, Dispatch) = ("submission", |_, _, _| {});
        let mut times = Vec::new();
        for (name, dispatch) in std::iter::once(&empty).chain(STAGES) {
            let mut least = f64::INFINITY;
            for _ in 0..repeats.max(1) {
                let clock = Instant::now();
                let bytes = size_of::<Summary>() as u64;
                self.submit(
                    |stages, pass| {
                        for batch in self.chunks(self.batch.len()) {
                            dispatch(stages, pass, batch);
                        }
                    },
                    |encoder| {
                        let summaries = self.buffers.summaries.raw();
                        self.readback.record(encoder, summaries, 0..bytes, 0);
                    },
                );
                self.readback.read(&self.device, bytes, |_| ()).await?;
                least = least.min(clock.elapsed().as_secs_f64());
            }
            times.push((*name, least));
        }
        Ok(times)
    }
}
