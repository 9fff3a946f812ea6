//! Plumbing that knows no physics: device, kernel, buffers, readback.
