//! Worker threads: as many as are asked for, and those of this process.

use std::process;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::error::Failure;

/// The process that has loaded this module; rayon's usual threads are its.
static LOADED_IN: OnceLock<u32> = OnceLock::new();

/// Threads of a process that was forked from it, and that process.
static FORKED: Mutex<Option<(u32, Arc<ThreadPool>)>> = Mutex::new(None);

/// Notes the process that loads this module.
pub fn remember_process() {
    LOADED_IN.get_or_init(process::id);
}

/// Works with so many threads; with all where nothing is said.
pub fn with_threads<T: Send>(
    threads: Option<usize>,
    work: impl FnOnce() -> T + Send,
) -> Result<T, Failure> {
    match threads {
        None => of_this_process(work),
        Some(0) => Err(Failure::input("threads: is 0, expected 1 or more")),
        Some(threads) => Ok(pool(threads)?.install(work)),
    }
}

/// Works with the threads of this process. Those of its parent aren't there after a fork, and work given to them would never be done.
pub fn of_this_process<T: Send>(work: impl FnOnce() -> T + Send) -> Result<T, Failure> {
    let process = process::id();
    if LOADED_IN
        .get()
        .is_none_or(|loaded_in| *loaded_in == process)
    {
        return Ok(work());
    }
    let pool = {
        let mut forked = FORKED.lock().unwrap_or_else(PoisonError::into_inner);
        match &*forked {
            Some((owner, pool)) if *owner == process => Arc::clone(pool),
            _ => {
                let pool = Arc::new(pool(0)?);
                // Another process's pool is left alone: its threads can't be joined here.
                std::mem::forget(forked.replace((process, Arc::clone(&pool))));
                pool
            }
        }
    };
    Ok(pool.install(work))
}

/// So many threads; 0 are all.
fn pool(threads: usize) -> Result<ThreadPool, Failure> {
    let pool = ThreadPoolBuilder::new().num_threads(threads).build();
    pool.map_err(|error| Failure::input(format!("threads: {error}")))
}
