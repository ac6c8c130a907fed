//! Common part of the programs: how they begin, what they say, and to whom.

use std::io::{ErrorKind, Write};
use std::process::ExitCode;

use clap::Parser;
use clap::error::{ContextKind, ContextValue, ErrorKind as Misuse};

use crate::stop_signal;
use dcb_formats::Error;
use dcb_formats::terminal::for_terminal;
use dcb_formats::threads::start_workers;

/// Whether the user is told what goes on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Told {
    /// On standard error.
    Everything,
    /// Nothing but errors.
    Nothing,
}

impl Told {
    /// One line, if the user is told.
    pub fn say(self, kind: &str, message: &str) {
        if self == Self::Everything {
            print_to_stderr(kind, message);
        }
    }
}

/// Begins a program whose usual command takes a `file`, for example `PART.mtx`: listens to signals, reads the arguments and starts the worker
/// threads, as many as `common` finds in the arguments.
///
/// # Errors
/// The exit status after help, version, or what is wrong with the arguments.
pub fn begin<C: Parser>(
    file: &str,
    common: impl Fn(&C) -> (Option<u16>, Told),
) -> Result<C, ExitCode> {
    stop_signal::listen();
    let cli = C::try_parse().map_err(|error| refuse(&in_our_words::<C>(error, file)))?;
    let (threads, told) = common(&cli);
    if let Some(note) = start_workers(threads).note() {
        told.say("note", &note);
    }
    Ok(cli)
}

/// The help or the version, or what is wrong with the arguments: they may be names of anybody's files.
fn refuse(error: &clap::Error) -> ExitCode {
    if error.use_stderr() {
        let message = for_terminal(&error.render().to_string());
        let _ = std::io::stderr().write_all(message.as_bytes());
    } else {
        let _ = error.print();
    }
    ExitCode::from(u8::try_from(error.exit_code()).unwrap_or(2))
}

/// A second file, or a misspelt command before a file, is a conflict of commands to the parser: said as what it is.
fn in_our_words<C: Parser>(error: clap::Error, file: &str) -> clap::Error {
    match (error.kind(), error.get(ContextKind::InvalidSubcommand)) {
        (Misuse::ArgumentConflict, Some(ContextValue::String(word))) => {
            let message = format!(
                "{word:?} is one argument too many: one {file} is wanted, or the name of a command first (see --help)"
            );
            C::command().error(Misuse::TooManyValues, message)
        }
        _ => error,
    }
}

/// A reader that closes the pipe early (`| head`) is not an error.
///
/// # Errors
/// [`Error::Io`]: a full disk, for example.
pub fn print_to_stdout(text: &str) -> Result<(), Error> {
    let mut out = std::io::stdout().lock();
    let text = for_terminal(text);
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(source) if source.kind() != ErrorKind::BrokenPipe => Err(Error::Io {
            path: "standard output".into(),
            action: "cannot write",
            source,
        }),
        _ => Ok(()),
    }
}

/// One line on standard error; where nobody can read it, nobody is told.
pub fn print_to_stderr(kind: &str, message: &str) {
    let _ = writeln!(std::io::stderr(), "{kind}: {}", for_terminal(message));
}
