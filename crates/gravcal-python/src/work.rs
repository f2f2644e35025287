//! Work that may last: done without the interpreter's lock, on a thread of its own, while the caller's passes on what it tells, and Ctrl-C.

use std::panic::resume_unwind;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Mutex, PoisonError};
use std::thread::{Builder, scope};
use std::time::Duration;

use pyo3::prelude::*;

/// Between two looks at signals.
const TICK: Duration = Duration::from_millis(50);
/// As the program's own thread has.
const STACK: usize = 8 << 20;

/// Who is told how far the work is.
pub type Report<'a> = dyn Fn(String) + Sync + 'a;

/// Does `work`, which is handed whom to tell. Whatever `progress` raises, and Ctrl-C, sets `stop`, and is raised when the work has ended.
pub fn run<T: Send>(
    py: Python<'_>,
    progress: Option<&Bound<'_, PyAny>>,
    stop: &AtomicBool,
    work: impl FnOnce(&Report<'_>) -> T + Send,
) -> PyResult<T> {
    let (sender, reported) = channel();
    let reported = Mutex::new(reported);
    scope(|scope| {
        let worker = Builder::new().stack_size(STACK).spawn_scoped(scope, move || {
            // Nobody listens any more only where this scope is left.
            let report = move |news: String| drop(sender.send(news));
            work(&report)
        })?;
        let mut failed = None;
        loop {
            let outcome = match py.detach(|| reported.lock().unwrap_or_else(PoisonError::into_inner).recv_timeout(TICK))
            {
                Ok(news) => progress.map_or(Ok(()), |progress| progress.call1((news,)).map(drop)),
                Err(RecvTimeoutError::Timeout) => Ok(()),
                Err(RecvTimeoutError::Disconnected) => break,
            };
            if let (Err(error), None) = (outcome.and_then(|()| py.check_signals()), &failed) {
                stop.store(true, Ordering::Relaxed);
                failed = Some(error);
            }
        }
        let done = py.detach(|| worker.join()).unwrap_or_else(|panic| resume_unwind(panic));
        failed.map_or(Ok(done), Err)
    })
}
