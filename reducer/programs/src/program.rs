//! Common part of the programs: how they begin, what they say, and to whom.

use std::ffi::OsString;
use std::io::{ErrorKind, IsTerminal, Write};

use clap::error::{ContextKind, ContextValue, ErrorKind as Misuse};
use clap::{Args, Parser};

use crate::stop_signal;
use dcb_formats::Error;
use dcb_formats::terminal::for_terminal;
use dcb_formats::threads::start_workers;
use dcb_workflow::progress_bar::Display;

/// Whether the user is told what goes on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Told {
    /// On standard error.
    Everything,
    /// Nothing but errors.
    Nothing,
}

impl Told {
    /// Bars if the user is told, on a terminal.
    pub fn display(self) -> Display {
        match self == Self::Everything && std::io::stderr().is_terminal() {
            true => Display::Bars,
            false => Display::Silent,
        }
    }

    /// One line, if the user is told.
    pub fn say(self, kind: &str, message: &str) {
        if self == Self::Everything {
            print_to_stderr(kind, message);
        }
    }
}

/// Options of every command.
#[derive(Debug, Args)]
pub struct CommonArguments {
    /// Print no summary, warnings or progress.
    #[arg(long, short, global = true)]
    pub quiet: bool,
    /// List every mode, and say beforehand what the reduction will cost.
    #[arg(long, short, global = true)]
    pub verbose: bool,
    /// Worker threads (default: one per processor). Results do not depend on it.
    #[arg(long, global = true, value_name = "N", allow_negative_numbers = true, value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
}

impl CommonArguments {
    /// Whether the user is told what goes on.
    pub fn told(&self) -> Told {
        match self.quiet {
            true => Told::Nothing,
            false => Told::Everything,
        }
    }
}

/// Begins a program whose usual command takes a `file`, for example `PART.mtx`: listens to signals, reads the arguments, of which the first is the
/// program's name, and starts the worker threads, as many as the arguments have in `common`.
///
/// # Errors
/// The exit status after help, version, or what is wrong with the arguments.
pub fn begin<C: Parser>(
    arguments: impl IntoIterator<Item = OsString>,
    file: &str,
    common: impl Fn(&C) -> &CommonArguments,
) -> Result<C, u8> {
    stop_signal::listen();
    let cli =
        C::try_parse_from(arguments).map_err(|error| refuse(&in_our_words::<C>(error, file)))?;
    let common = common(&cli);
    if let Some(note) = start_workers(common.threads).note() {
        common.told().say("note", &note);
    }
    Ok(cli)
}

/// The help or the version, or what is wrong with the arguments: they may be names of anybody's files.
fn refuse(error: &clap::Error) -> u8 {
    if error.use_stderr() {
        let message = for_terminal(&error.render().to_string());
        let _ = std::io::stderr().write_all(message.as_bytes());
    } else {
        let _ = error.print();
    }
    u8::try_from(error.exit_code()).unwrap_or(2)
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
        Err(source) if source.kind() != ErrorKind::BrokenPipe => Err(Error::io(
            "standard output".as_ref(),
            "cannot write",
            source,
        )),
        _ => Ok(()),
    }
}

/// One line on standard error; where nobody can read it, nobody is told.
pub fn print_to_stderr(kind: &str, message: &str) {
    let _ = writeln!(std::io::stderr(), "{kind}: {}", for_terminal(message));
}
