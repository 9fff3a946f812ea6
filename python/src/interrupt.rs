//! Long work beside Python: other threads of Python go on, its progress is told, and Ctrl-C ends it.

use crate::error::to_python;
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use std::panic::resume_unwind;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread::Builder;
use std::time::Duration;

/// How long Ctrl-C waits at most.
const PATIENCE: Duration = Duration::from_millis(50);

/// As much as a main thread has.
const STACK: usize = 8 << 20;

/// Does `work` on a thread of its own without the GIL. It is given what its phases are told to, which goes on to `progress`
/// as (done, of all, name). On Ctrl-C, and where `progress` raises, the thread ends at its next phase and its result is
/// dropped.
pub fn in_background<T: Send + 'static>(
    py: Python<'_>,
    progress: Option<&Bound<'_, PyAny>>,
    work: impl FnOnce(&mut dyn FnMut(usize)) -> supple::Result<T> + Send + 'static,
) -> PyResult<T> {
    let (sender, mut receiver) = channel();
    let given_up = Arc::new(AtomicBool::new(false));
    let asked = given_up.clone();
    let body = move || {
        work(&mut |phase| {
            // Unwinds this thread alone, without a message: nobody waits for it any more.
            if asked.load(Ordering::Relaxed) || sender.send(phase).is_err() {
                resume_unwind(Box::new("given up"));
            }
        })
    };
    let thread = Builder::new().name("supple bake".into()).stack_size(STACK);
    let thread = thread
        .spawn(body)
        .map_err(|e| PyRuntimeError::new_err(format!("no thread for the bake: {e}")))?;
    let phases = supple_bake::PHASES;
    let mut told = || -> PyResult<()> {
        loop {
            let receiver = &mut receiver;
            let next = py.detach(move || receiver.recv_timeout(PATIENCE));
            py.check_signals()?;
            match next {
                Ok(phase) => {
                    if let Some(progress) = progress {
                        let name = phases.get(phase).copied().unwrap_or("done");
                        progress.call1((phase, phases.len(), name))?;
                    }
                }
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return Ok(()),
            }
        }
    };
    if let Err(error) = told() {
        given_up.store(true, Ordering::Relaxed);
        return Err(error);
    }
    let joined = py.detach(|| thread.join());
    joined
        .map_err(|_| {
            PyRuntimeError::new_err("the bake failed in a way that it should not: please report it")
        })?
        .map_err(to_python)
}
