//! Signals that ask the program to end: Ctrl-C (SIGINT), SIGTERM as containers and batch systems send it, and SIGHUP of a
//! terminal that is closed.
//!
//! The first one lets the program clean up or write what it has; a second one ends it at once. Nothing unfinished is left by
//! either. A program that was started with SIGHUP ignored (`nohup`) goes on ignoring it.

use std::sync::Once;
use std::sync::atomic::{AtomicU8, Ordering};

use dcb_formats::dcb::remove_unfinished;

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

/// Exit status of the first signal; 0 before.
static RECEIVED: AtomicU8 = AtomicU8::new(0);

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

/// From now on the first signal is noted and calls `first` on a thread of its own; a second one ends the program at once. Only
/// the first call in a program has an effect.
pub fn watch(first: impl FnOnce(StopSignal) + Send + 'static) {
    static WATCHED: Once = Once::new();
    WATCHED.call_once(|| {
        let mut first = Some(first);
        listen(move |signal| match first.take() {
            Some(first) => {
                RECEIVED.store(signal.exit_status(), Ordering::SeqCst);
                let cleaning = std::thread::Builder::new();
                if cleaning.spawn(move || first(signal)).is_err() {
                    end(signal);
                }
            }
            None => end(signal),
        });
    });
}

/// Ends the program at once, and leaves nothing unfinished.
pub fn end(signal: StopSignal) -> ! {
    remove_unfinished();
    // Not by `std::process::exit`: HDF5 would still tidy up what another thread is writing.
    #[cfg(unix)]
    signal_hook::low_level::exit(i32::from(signal.exit_status()));
    #[cfg(not(unix))]
    std::process::exit(i32::from(signal.exit_status()));
}

/// From now on a file that grows beyond `ulimit -f` is an error of the write, not the end of the program.
pub fn survive_file_size_limit() {
    #[cfg(unix)]
    let _ = signal_hook::flag::register(signal_hook::consts::SIGXFSZ, Default::default());
}

/// Calls `each` for every signal. Where the system refuses, signals end the program as if nobody listened.
#[cfg(unix)]
fn listen(mut each: impl FnMut(StopSignal) + Send + 'static) {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};

    let mut wanted = vec![SIGINT, SIGTERM];
    if !is_ignored(SIGHUP) {
        wanted.push(SIGHUP);
    }
    let Ok(mut signals) = signal_hook::iterator::Signals::new(wanted) else {
        return;
    };
    let _ = std::thread::Builder::new().spawn(move || {
        for number in signals.forever() {
            match number {
                SIGTERM => each(StopSignal::Terminate),
                SIGHUP => each(StopSignal::HangUp),
                _ => each(StopSignal::Interrupt),
            }
        }
    });
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

#[cfg(not(unix))]
fn listen(mut each: impl FnMut(StopSignal) + Send + 'static) {
    let _ = ctrlc::set_handler(move || each(StopSignal::Interrupt));
}
