//! Signals that ask the program to end: Ctrl-C (SIGINT), SIGTERM as containers and batch systems send it, and SIGHUP of a
//! terminal that is closed.
//!
//! All threads block them and one waits for them, so no handler runs: METIS has one of its own for SIGTERM, which jumps out of
//! whatever is being done, and crashes in any thread but its own.
//!
//! The first one lets the program clean up or write what it has; a second one ends it at once. Nothing unfinished is left by
//! either. A program that was started with SIGHUP ignored (`nohup`) goes on ignoring it.

use std::sync::atomic::{AtomicU8, Ordering};
use std::sync::{Mutex, PoisonError};

use dcb_formats::output::remove_unfinished;

/// Who asked for an end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StopSignal {
    /// SIGINT.
    Interrupt,
    /// SIGTERM.
    Terminate,
    /// SIGHUP.
    HangUp,
}

/// Exit status of the first signal that somebody watched for; 0 before.
static RECEIVED: AtomicU8 = AtomicU8::new(0);

/// Function that the first signal calls.
type First = Box<dyn FnOnce(StopSignal) + Send>;
static FIRST: Mutex<Option<First>> = Mutex::new(None);

impl StopSignal {
    const ALL: [Self; 3] = [Self::Interrupt, Self::Terminate, Self::HangUp];

    /// 128 and the signal's number, as shells have it.
    pub fn exit_status(self) -> u8 {
        match self {
            Self::Interrupt => 130,
            Self::Terminate => 143,
            Self::HangUp => 129,
        }
    }

    /// For messages and for the record.
    pub fn reason(self) -> &'static str {
        match self {
            Self::Interrupt => "interrupted",
            Self::Terminate => "terminated (SIGTERM)",
            Self::HangUp => "hung up (SIGHUP)",
        }
    }
}

/// The first signal that came since [`watch`] was called.
pub fn received() -> Option<StopSignal> {
    let status = RECEIVED.load(Ordering::SeqCst);
    StopSignal::ALL
        .into_iter()
        .find(|signal| signal.exit_status() == status)
}

/// From now on the first signal is noted and calls `first` on a thread of its own; a second one ends the program at once.
pub fn watch(first: impl FnOnce(StopSignal) + Send + 'static) {
    *FIRST.lock().unwrap_or_else(PoisonError::into_inner) = Some(Box::new(first));
}

fn note(signal: StopSignal) {
    let first = FIRST.lock().unwrap_or_else(PoisonError::into_inner).take();
    let Some(first) = first else { end(signal) };
    RECEIVED.store(signal.exit_status(), Ordering::SeqCst);
    let cleaning = std::thread::Builder::new();
    if cleaning.spawn(move || first(signal)).is_err() {
        end(signal);
    }
}

/// Ends the program at once, and leaves nothing unfinished.
pub fn end(signal: StopSignal) -> ! {
    remove_unfinished();
    // Not by `std::process::exit`: HDF5 would still tidy up what another thread is writing.
    #[cfg(unix)]
    // SAFETY: ends the process; nothing of it is used afterwards.
    unsafe {
        libc::_exit(i32::from(signal.exit_status()))
    }
    #[cfg(not(unix))]
    std::process::exit(i32::from(signal.exit_status()))
}

/// Called by a program before it starts threads. From now on signals end it with nothing unfinished left, or call what
/// [`watch`] was given; and a file that grows beyond `ulimit -f` is an error of the write, not the end of the program.
///
/// Processes that are started inherit the blocked signals; programs other than these must be given them back.
#[cfg(unix)]
pub fn listen() {
    use nix::sys::signal::{SigSet, Signal};

    let mut stopping = SigSet::empty();
    stopping.add(Signal::SIGINT);
    stopping.add(Signal::SIGTERM);
    if !is_ignored(libc::SIGHUP) {
        stopping.add(Signal::SIGHUP);
    }
    let mut blocked = stopping;
    blocked.add(Signal::SIGXFSZ);
    if blocked.thread_block().is_err() {
        return;
    }
    let waiting = std::thread::Builder::new().spawn(move || {
        loop {
            match stopping.wait() {
                Ok(Signal::SIGTERM) => note(StopSignal::Terminate),
                Ok(Signal::SIGHUP) => note(StopSignal::HangUp),
                Ok(_) => note(StopSignal::Interrupt),
                Err(_) => {}
            }
        }
    });
    if waiting.is_err() {
        // They end the program as if nobody listened.
        let _ = stopping.thread_unblock();
    }
}

/// Called by a program before it starts threads. From now on Ctrl-C calls what [`watch`] was given.
#[cfg(not(unix))]
pub fn listen() {
    let _ = ctrlc::set_handler(|| note(StopSignal::Interrupt));
}

#[cfg(unix)]
fn is_ignored(signal: i32) -> bool {
    let mut action = std::mem::MaybeUninit::<libc::sigaction>::zeroed();
    // SAFETY: without a new action the call only writes the present one, for which zeros are valid too.
    let action = unsafe {
        libc::sigaction(signal, std::ptr::null(), action.as_mut_ptr());
        action.assume_init()
    };
    action.sa_sigaction == libc::SIG_IGN
}
