//! Memory that processes share: each takes what it was forecast to need before it begins.

use std::sync::{Condvar, Mutex, PoisonError};

use crate::workers::lock;

/// Memory that is there, and who waits for it. It is given in the order in which it is asked for: a large part isn't overtaken for ever.
#[derive(Debug)]
pub struct MemoryShare {
    total: u64,
    state: Mutex<State>,
    changed: Condvar,
}

#[derive(Debug)]
struct State {
    free: u64,
    next_ticket: u64,
    served: u64,
}

/// Memory that a process has; given back when dropped.
#[derive(Debug)]
pub struct Share<'m> {
    of: &'m MemoryShare,
    bytes: u64,
}

impl MemoryShare {
    /// So many bytes, all free.
    pub fn of(total: u64) -> Self {
        Self {
            total,
            state: Mutex::new(State {
                free: total,
                next_ticket: 0,
                served: 0,
            }),
            changed: Condvar::new(),
        }
    }

    /// Waits for bytes; for all of it where more is asked for than there is.
    pub fn take(&self, bytes: u64) -> Share<'_> {
        let bytes = bytes.min(self.total);
        let mut state = lock(&self.state);
        let ticket = state.next_ticket;
        state.next_ticket += 1;
        while state.served != ticket || state.free < bytes {
            state = self
                .changed
                .wait(state)
                .unwrap_or_else(PoisonError::into_inner);
        }
        state.served += 1;
        state.free -= bytes;
        self.changed.notify_all();
        Share { of: self, bytes }
    }
}

impl Drop for Share<'_> {
    fn drop(&mut self) {
        lock(&self.of.state).free += self.bytes;
        self.of.changed.notify_all();
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicU64, Ordering};
    use std::time::Duration;

    use super::*;

    #[test]
    fn no_more_is_given_than_there_is() {
        let memory = MemoryShare::of(10);
        let (held, most) = (AtomicU64::new(0), AtomicU64::new(0));
        std::thread::scope(|scope| {
            for bytes in [6, 3, 9, 1, 5, 20, 2, 7] {
                let (memory, held, most) = (&memory, &held, &most);
                scope.spawn(move || {
                    let share = memory.take(bytes);
                    let now = held.fetch_add(share.bytes, Ordering::SeqCst) + share.bytes;
                    most.fetch_max(now, Ordering::SeqCst);
                    std::thread::sleep(Duration::from_millis(5));
                    held.fetch_sub(share.bytes, Ordering::SeqCst);
                });
            }
        });
        let most = most.into_inner();
        assert!((6..=10).contains(&most), "{most}");
        assert_eq!(lock(&memory.state).free, 10);
    }

    #[test]
    fn who_asks_first_is_served_first() {
        let memory = MemoryShare::of(10);
        let first = memory.take(6);
        std::thread::scope(|scope| {
            let large = scope.spawn(|| drop(memory.take(8)));
            while lock(&memory.state).next_ticket < 2 {
                std::thread::yield_now();
            }
            let small = scope.spawn(|| drop(memory.take(1)));
            std::thread::sleep(Duration::from_millis(20));
            assert!(!large.is_finished() && !small.is_finished());
            drop(first);
        });
    }
}
