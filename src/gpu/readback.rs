//! Bytes back from the device, through one staging buffer that stays.

use crate::{GpuError, Result};
use std::future::Future;
use std::ops::{Deref, Range};
use std::pin::Pin;
use std::sync::{Arc, Mutex};
use std::task::{Context, Poll, Waker};
use std::time::Duration;

/// Who drives the device while a readback is awaited.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Waiting {
    /// The future blocks its thread in `Device::poll` until the bytes are there: right for native
    /// programs without an executor. On the web it is the same as [`Waiting::Host`].
    #[default]
    Block,
    /// The host calls `Device::poll` (or is a browser, which needs no call); the future wakes up.
    Host,
}

/// How a readback is waited for.
#[derive(Clone, Copy, Debug)]
pub struct Patience {
    /// Who drives the device.
    pub waiting: Waiting,
    /// How long a future that blocks its thread waits at most; ten times as long for a first answer.
    pub timeout: Duration,
}

/// How much longer a first answer may take: some drivers compile a kernel when it is first run.
const FIRST: u32 = 10;

/// A staging buffer and the way to wait for it.
#[derive(Debug)]
pub struct Readback {
    label: String,
    staging: wgpu::Buffer,
    patience: Patience,
    /// Whether anything has been read.
    answered: bool,
    /// Whether a mapping of the staging buffer was asked for and not awaited to its end.
    abandoned: bool,
}

impl Readback {
    /// Staging room for `bytes`.
    ///
    /// # Errors
    /// [`GpuError::Limit`] where the device has no buffer so large.
    pub fn new(device: &wgpu::Device, label: &str, bytes: u64, patience: Patience) -> Result<Self> {
        let size = bytes.max(4).next_multiple_of(wgpu::COPY_BUFFER_ALIGNMENT);
        let limit = device.limits().max_buffer_size;
        if size > limit {
            return Err(GpuError::Limit {
                what: format!("bytes to read back of `{label}`"),
                needed: size,
                limit,
                cure: "step fewer instances together, or make the device with a larger max_buffer_size",
            }
            .into());
        }
        Ok(Self {
            label: label.to_owned(),
            staging: staging(device, label, size),
            patience,
            answered: false,
            abandoned: false,
        })
    }

    /// Before anything is copied again: another staging buffer in place of one whose mapping was abandoned. wgpu may take
    /// the end of the submission that was waited for then for that of the next mapping, which would show old bytes.
    pub fn renew(&mut self, device: &wgpu::Device) {
        if std::mem::take(&mut self.abandoned) {
            self.staging = staging(device, &self.label, self.staging.size());
        }
    }

    /// Bytes that it has room for.
    pub fn room(&self) -> u64 {
        self.staging.size()
    }

    /// Records the copy of `range` of `source` to byte `at` of the staging buffer.
    pub fn record(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        source: &wgpu::Buffer,
        range: Range<u64>,
        at: u64,
    ) {
        let bytes = range.end - range.start;
        encoder.copy_buffer_to_buffer(source, range.start, &self.staging, at, bytes);
    }

    /// The first `bytes`, at least one, of what the copies brought, once `submission` has run: the last one with copies in it. Dropped
    /// while it waits, it leaves the staging buffer free for the next.
    ///
    /// # Errors
    /// [`GpuError::DeviceLost`] where the device or the mapping failed, [`GpuError::Timeout`] where the device took too
    /// long.
    pub async fn read(
        &mut self,
        device: &wgpu::Device,
        submission: wgpu::SubmissionIndex,
        bytes: u64,
    ) -> Result<Bytes<'_>> {
        let lost = |problem: String| GpuError::DeviceLost(problem);
        let mapped = Mapped::default();
        let signal = mapped.clone();
        self.abandoned = true;
        self.staging
            .map_async(wgpu::MapMode::Read, 0..bytes, move |result| {
                signal.finish(result.map_err(|e| e.to_string()));
            });
        let pending = Pending {
            staging: &self.staging,
            mapped: &mapped,
        };
        let timeout = match self.answered {
            true => self.patience.timeout,
            false => self.patience.timeout.saturating_mul(FIRST),
        };
        if self.patience.waiting == Waiting::Block {
            let waited = wgpu::PollType::Wait {
                submission_index: Some(submission),
                timeout: Some(timeout),
            };
            device.poll(waited).map_err(|error| match error {
                wgpu::PollError::Timeout => GpuError::Timeout {
                    what: self.label.clone(),
                    waited: timeout,
                },
                wgpu::PollError::WrongSubmissionIndex(..) => lost(error.to_string()),
            })?;
        }
        mapped.clone().await.map_err(lost)?;
        (self.answered, self.abandoned) = (true, false);
        std::mem::forget(pending);
        let view = self.staging.get_mapped_range(0..bytes);
        let mut out = Bytes {
            view: None,
            staging: Some(&self.staging),
        };
        out.view = Some(view.map_err(|e| lost(e.to_string()))?);
        Ok(out)
    }
}

fn staging(device: &wgpu::Device, label: &str, size: u64) -> wgpu::Buffer {
    device.create_buffer(&wgpu::BufferDescriptor {
        label: Some(label),
        size,
        usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    })
}

/// Bytes of a staging buffer, which nothing is copied to until they are dropped.
#[derive(Debug, Default)]
pub struct Bytes<'a> {
    view: Option<wgpu::BufferView>,
    staging: Option<&'a wgpu::Buffer>,
}

impl Deref for Bytes<'_> {
    type Target = [u8];

    fn deref(&self) -> &[u8] {
        self.view.as_deref().unwrap_or_default()
    }
}

impl Drop for Bytes<'_> {
    fn drop(&mut self) {
        self.view = None;
        if let Some(staging) = &self.staging {
            staging.unmap();
        }
    }
}

/// A mapping that nobody waits for any more once this is dropped.
struct Pending<'a> {
    staging: &'a wgpu::Buffer,
    mapped: &'a Mapped,
}

impl Drop for Pending<'_> {
    fn drop(&mut self) {
        // What failed to map is not mapped.
        if !self.mapped.has_failed() {
            self.staging.unmap();
        }
    }
}

#[derive(Debug, Default)]
struct MappedState {
    result: Option<Result<(), String>>,
    waker: Option<Waker>,
}

/// The end of a mapping, as a future.
#[derive(Clone, Debug, Default)]
struct Mapped(Arc<Mutex<MappedState>>);

impl Mapped {
    fn finish(&self, result: Result<(), String>) {
        let waker = {
            // A poisoned lock only means that another thread panicked; the state is still whole.
            let mut state = self.0.lock().unwrap_or_else(|e| e.into_inner());
            state.result = Some(result);
            state.waker.take()
        };
        if let Some(waker) = waker {
            waker.wake();
        }
    }

    fn has_failed(&self) -> bool {
        let state = self.0.lock().unwrap_or_else(|e| e.into_inner());
        matches!(state.result, Some(Err(_)))
    }
}

impl Future for Mapped {
    type Output = Result<(), String>;

    fn poll(self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<Self::Output> {
        let mut state = self.0.lock().unwrap_or_else(|e| e.into_inner());
        match &state.result {
            Some(result) => Poll::Ready(result.clone()),
            None => {
                state.waker = Some(context.waker().clone());
                Poll::Pending
            }
        }
    }
}
