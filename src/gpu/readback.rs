//! Bytes back from the device, through one staging buffer that stays.

use crate::{GpuError, Result};
use std::future::Future;
use std::ops::Range;
use std::pin::Pin;
use std::sync::{Arc, Mutex};
use std::task::{Context, Poll, Waker};

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

/// A staging buffer and the way to wait for it.
#[derive(Debug)]
pub struct Readback {
    staging: wgpu::Buffer,
    waiting: Waiting,
}

impl Readback {
    /// Staging room for `bytes`.
    pub fn new(device: &wgpu::Device, label: &str, bytes: u64, waiting: Waiting) -> Self {
        let staging = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some(label),
            size: bytes.max(4).next_multiple_of(wgpu::COPY_BUFFER_ALIGNMENT),
            usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        Self { staging, waiting }
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

    /// Waits for the recorded copies, which must have been submitted, and hands the first `bytes` of
    /// them to `consume`.
    ///
    /// # Errors
    /// [`GpuError::DeviceLost`] where the device or the mapping failed.
    pub async fn read<R>(
        &self,
        device: &wgpu::Device,
        bytes: u64,
        consume: impl FnOnce(&[u8]) -> R,
    ) -> Result<R> {
        let lost = |problem: String| GpuError::DeviceLost(problem);
        let mapped = Mapped::default();
        let signal = mapped.clone();
        self.staging
            .map_async(wgpu::MapMode::Read, 0..bytes, move |result| {
                signal.finish(result.map_err(|e| e.to_string()));
            });
        if self.waiting == Waiting::Block {
            device
                .poll(wgpu::PollType::wait_indefinitely())
                .map_err(|e| lost(e.to_string()))?;
        }
        mapped.await.map_err(lost)?;
        let out = {
            let view = self
                .staging
                .get_mapped_range(0..bytes)
                .map_err(|e| lost(e.to_string()))?;
            consume(&view)
        };
        self.staging.unmap();
        Ok(out)
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
}

impl Future for Mapped {
    type Output = Result<(), String>;

    fn poll(self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<Self::Output> {
        let mut state = self.0.lock().unwrap_or_else(|e| e.into_inner());
        match state.result.take() {
            Some(result) => Poll::Ready(result),
            None => {
                state.waker = Some(context.waker().clone());
                Poll::Pending
            }
        }
    }
}
