//! Commands of one or several recorders that go to the device together, and one readback for all of them.

use super::readback::{Bytes, Patience, Readback};
use crate::{GpuError, Result};
use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};

/// An encoder that is open from the first command to [`Submission::submit`], and the staging buffer that its copies go to.
///
/// ```text
/// a.record_evaluate(…, &mut submission)?;   // reserves its part of the staging buffer
/// b.record_evaluate(…, &mut submission)?;
/// let bytes = submission.read().await?;     // one submission, one readback; to be dropped before the next
/// a.finish_evaluate(&bytes, …)?;
/// b.finish_evaluate(&bytes, …)?;
/// ```
#[derive(Debug)]
pub struct Submission {
    device: wgpu::Device,
    queue: wgpu::Queue,
    readback: Readback,
    encoder: Option<wgpu::CommandEncoder>,
    recording: u64,
    /// What was last sent.
    sent: Option<wgpu::SubmissionIndex>,
    /// How often it was sent and read.
    traffic: [u64; 2],
    /// Bytes of the staging buffer that are spoken for, and how many of the first ones stay so where others are forgotten.
    reserved: u64,
    kept: u64,
}

/// Numbers of recordings, so that no two of any submissions share one; 0 is none.
static RECORDINGS: AtomicU64 = AtomicU64::new(1);

fn next_recording() -> u64 {
    RECORDINGS.fetch_add(1, Ordering::Relaxed)
}

impl Submission {
    /// With room for `bytes` to read back; `label` says of what, in errors.
    ///
    /// # Errors
    /// [`GpuError::Limit`] where the device has no buffer so large.
    pub fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        label: &str,
        bytes: u64,
        patience: Patience,
    ) -> Result<Self> {
        Ok(Self {
            readback: Readback::new(device, label, bytes, patience)?,
            device: device.clone(),
            queue: queue.clone(),
            encoder: None,
            recording: next_recording(),
            sent: None,
            traffic: [0; 2],
            reserved: 0,
            kept: 0,
        })
    }

    /// The number of the recording that is open; each [`Submission::submit`] opens another. What the host writes to a
    /// buffer (`Queue::write_buffer`) takes effect before all of it, so what one command of a recording is to read
    /// must not be overwritten for another.
    pub fn recording(&self) -> u64 {
        self.recording
    }

    /// Bytes that it has room to read back.
    pub fn room(&self) -> u64 {
        self.readback.room()
    }

    /// How often anything was sent, and read back.
    pub fn traffic(&self) -> [u64; 2] {
        self.traffic
    }

    /// Records commands.
    pub fn encoder(&mut self) -> &mut wgpu::CommandEncoder {
        let device = &self.device;
        (self.encoder).get_or_insert_with(|| device.create_command_encoder(&Default::default()))
    }

    /// Takes the next `bytes` of the staging buffer, until [`Submission::read`].
    ///
    /// # Errors
    /// [`GpuError::Limit`] where they are not there.
    pub fn reserve(&mut self, bytes: u64) -> Result<Range<u64>> {
        if self.reserved == 0 {
            self.readback.renew(&self.device);
        }
        let end = self.reserved + bytes;
        if end > self.readback.room() {
            return Err(GpuError::Limit {
                what: "bytes to read back in a submission".to_owned(),
                needed: end,
                limit: self.readback.room(),
                cure: "make it with room for all that is recorded",
            }
            .into());
        }
        Ok(std::mem::replace(&mut self.reserved, end)..end)
    }

    /// Records the copy of `range` of `source` to byte `at` of the staging buffer.
    pub fn copy(&mut self, source: &wgpu::Buffer, range: Range<u64>, at: u64) {
        self.encoder();
        if let Some(encoder) = &mut self.encoder {
            self.readback.record(encoder, source, range, at);
        }
    }

    /// Sends what is recorded, and what the host has written since. What is to be read back still is.
    pub fn submit(&mut self) -> wgpu::SubmissionIndex {
        self.recording = next_recording();
        self.traffic[0] += 1;
        let index = (self.queue).submit(self.encoder.take().map(wgpu::CommandEncoder::finish));
        self.sent = Some(index.clone());
        index
    }

    /// Sends what is recorded, if there is anything.
    pub fn flush(&mut self) {
        if self.encoder.is_some() {
            self.submit();
        }
    }

    /// What is reserved by now comes back with whatever is read next.
    pub fn keep_reads(&mut self) {
        self.kept = self.reserved;
    }

    /// Forgets what was to be read back and is not kept, after an error; what is recorded runs with the next submission.
    pub fn cancel_reads(&mut self) {
        self.reserved = self.kept;
    }

    /// Sends what is recorded and not sent yet, and waits for all that is reserved; then nothing is reserved any more, however it ends.
    ///
    /// # Errors
    /// [`GpuError::DeviceLost`], [`GpuError::Timeout`].
    pub async fn read(&mut self) -> Result<Bytes<'_>> {
        let bytes = std::mem::take(&mut self.reserved);
        self.kept = 0;
        if bytes == 0 {
            self.flush();
            return Ok(Bytes::default());
        }
        let index = match self.sent.take() {
            Some(index) if self.encoder.is_none() => index,
            _ => self.submit(),
        };
        self.traffic[1] += 1;
        self.readback.read(&self.device, index, bytes).await
    }
}
