//! Threads that work on one queue.

use std::sync::{Mutex, MutexGuard, PoisonError};
use std::thread::Builder;

/// Does the work on so many threads, each until it finds nothing more to do; the first error, once all have ended.
pub(crate) fn on_threads<E: Send>(
    count: usize,
    work: impl Fn() -> Result<(), E> + Sync,
) -> Result<(), E> {
    std::thread::scope(|scope| {
        let workers: Vec<_> = (0..count)
            .map_while(|_| Builder::new().spawn_scoped(scope, &work).ok())
            .collect();
        // The caller works where the system allows no further thread, and does nothing but wait where it allows all.
        let own = match workers.len() < count {
            true => work(),
            false => Ok(()),
        };
        let ended = workers.into_iter().map(|worker| match worker.join() {
            Ok(ended) => ended,
            Err(cause) => std::panic::resume_unwind(cause),
        });
        ended.fold(own, Result::and)
    })
}

/// A lock whose holders leave nothing half done.
pub(crate) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
