//! The worker threads of a program, where the system may allow fewer than are wanted.
//!
//! Containers limit processes and threads (`pids.max`), users may be limited (`ulimit -u`), and each thread needs address space for its
//! stack (`ulimit -v`). A program starts its workers once, works with those that it gets, and says so.

use std::io;
use std::num::NonZeroUsize;
use std::sync::mpsc::{Sender, channel};
use std::thread::{Builder, JoinHandle};

use rayon::{ThreadBuilder, ThreadPoolBuilder};

use crate::out_of_memory::address_space_limit;

/// Threads that are left to others where the system allows fewer than are wanted: what waits for interruptions, reads a file's
/// structure, shows progress.
const SPARE: usize = 3;
/// Address space of a thread's stack, bytes.
const STACK_BYTES: u64 = 1 << 21;
/// Threads may take one fraction, 1 / this, of a limited address space for themselves.
const THREADS: u64 = 2;

/// How many threads work.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Workers {
    /// How many were wanted.
    pub wanted: usize,
    /// How many there are; one may be the thread that asked.
    pub running: usize,
}

impl Workers {
    /// Warning if there are fewer threads than were wanted.
    pub fn note(&self) -> Option<String> {
        let Self { wanted, running } = self;
        let s = if *running == 1 { "" } else { "s" };
        (running < wanted).then(|| {
            format!(
                "{running} thread{s} instead of {wanted}: the system allows no more (see ulimit -u, ulimit -v, or pids.max of a container); \
                 results are the same, it takes longer"
            )
        })
    }
}

/// Starts the worker threads of a program, as many as were asked for or one for each processor. Where the system allows fewer, there
/// are fewer; where it allows none, the calling thread does all the work. To be called once, before any work.
pub fn start_workers(asked: Option<u16>) -> Workers {
    let available = || std::thread::available_parallelism().unwrap_or(NonZeroUsize::MIN);
    let asked = asked.map(usize::from).and_then(NonZeroUsize::new);
    let wanted = asked.unwrap_or_else(available).get();
    share_one_heap();
    let room = address_space_limit().map_or(usize::MAX, |bytes| {
        let thread = STACK_BYTES + product_buffer_bytes();
        usize::try_from(bytes / THREADS / thread).unwrap_or(usize::MAX)
    });
    // All of them before the pool: it can't be started a second time with fewer.
    let started = (0..wanted.min(room)).map_while(|_| Waiting::start().ok());
    let mut waiting: Vec<Waiting> = started.collect();
    if waiting.len() < wanted.min(room) {
        let spare = SPARE.min(waiting.len().div_ceil(2));
        for released in waiting.split_off(waiting.len() - spare) {
            released.release();
        }
    }
    let running = waiting.len().max(1);
    let pool = ThreadPoolBuilder::new().num_threads(running);
    // A pool that exists already serves as well.
    let _ = match waiting.is_empty() {
        true => pool.use_current_thread().build_global(),
        false => pool
            .spawn_handler(|work| match waiting.pop() {
                Some(thread) => thread.give(work),
                None => Err(io::ErrorKind::WouldBlock.into()),
            })
            .build_global(),
    };
    Workers { wanted, running }
}

/// Address space that faer's products of matrices take in each thread, mostly untouched: twice the processor's last cache, which
/// servers have hundreds of megabytes of.
fn product_buffer_bytes() -> u64 {
    let text = std::fs::read_to_string("/sys/devices/system/cpu/cpu0/cache/index3/size");
    let kibibytes = text.ok().and_then(|text| {
        let number = text.trim().strip_suffix('K')?;
        number.parse::<u64>().ok()
    });
    kibibytes.map_or(0, |kibibytes| kibibytes.saturating_mul(2 << 10))
}

/// Each thread would take 64 MB of address space for a heap of its own; where that is limited they share one.
fn share_one_heap() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    if address_space_limit().is_some() {
        // SAFETY: a setting of the C library's allocator.
        unsafe {
            libc::mallopt(libc::M_ARENA_MAX, 1);
        }
    }
}

/// Whether the system allows one thread more now: for libraries that take it for granted.
pub fn one_more() -> bool {
    let started = Builder::new().spawn(|| ());
    started.is_ok_and(|thread| thread.join().is_ok())
}

/// A thread that waits for its work.
struct Waiting {
    sender: Sender<ThreadBuilder>,
    handle: JoinHandle<()>,
}

impl Waiting {
    fn start() -> io::Result<Self> {
        let (sender, receiver) = channel::<ThreadBuilder>();
        let work = move || {
            if let Ok(work) = receiver.recv() {
                work.run();
            }
        };
        let handle = Builder::new()
            .name("worker".into())
            .stack_size(STACK_BYTES as usize)
            .spawn(work)?;
        Ok(Self { sender, handle })
    }

    fn give(self, work: ThreadBuilder) -> io::Result<()> {
        let sent = self.sender.send(work);
        sent.map_err(|_| io::ErrorKind::BrokenPipe.into())
    }

    fn release(self) {
        drop(self.sender);
        let _ = self.handle.join();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fewer_workers_are_told() {
        let workers = |running| Workers { wanted: 4, running };
        assert_eq!(workers(4).note(), None);
        let note = workers(1).note().unwrap_or_default();
        assert!(note.starts_with("1 thread instead of 4: "), "{note}");
        assert!(
            workers(3)
                .note()
                .is_some_and(|note| note.starts_with("3 threads"))
        );
    }
}
