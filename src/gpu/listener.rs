//! What a driver refuses, as a value: left alone, wgpu would panic.

use std::future::Future;

/// Hears of what the driver refuses while it lives: errors of every kind, on this thread. Scopes nest: the first of these
/// is the innermost, and ends first.
pub struct Listener([wgpu::ErrorScopeGuard; 3]);

impl Listener {
    /// From now on.
    pub fn new(device: &wgpu::Device) -> Self {
        use wgpu::ErrorFilter::{Internal, OutOfMemory, Validation};
        let mut guards =
            [Internal, OutOfMemory, Validation].map(|kind| device.push_error_scope(kind));
        guards.reverse();
        Self(guards)
    }

    /// The error, if there was one; a browser tells it later.
    pub fn heard(self) -> impl Future<Output = Option<String>> + use<> {
        let [validation, memory, internal] = self.0.map(wgpu::ErrorScopeGuard::pop);
        async move {
            let error = match validation.await {
                Some(error) => Some(error),
                None => memory.await,
            };
            let error = match error {
                Some(error) => Some(error),
                None => internal.await,
            };
            error.map(|e| e.to_string())
        }
    }
}
