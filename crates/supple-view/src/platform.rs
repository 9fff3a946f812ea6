//! What a page has otherwise than a desktop: the clock, and work beside the interface.

use std::future::Future;

/// Seconds, from some time on.
#[derive(Clone, Copy, Debug)]
pub struct Clock(web_time::Instant);

impl Clock {
    /// From now on.
    pub fn start() -> Self {
        Self(web_time::Instant::now())
    }

    /// Since then, s.
    pub fn seconds(&self) -> f64 {
        self.0.elapsed().as_secs_f64()
    }
}

/// Lets others work for a while.
#[cfg(not(target_arch = "wasm32"))]
pub fn rest() {
    std::thread::sleep(std::time::Duration::from_millis(10));
}

/// Does `work` beside the interface: on a thread.
#[cfg(not(target_arch = "wasm32"))]
pub fn beside(work: impl Future<Output = ()> + Send + 'static) {
    std::thread::spawn(move || pollster::block_on(work));
}

/// Does `work` between the page's frames, as far as it waits for anything.
#[cfg(target_arch = "wasm32")]
pub fn beside(work: impl Future<Output = ()> + 'static) {
    wasm_bindgen_futures::spawn_local(work);
}
