//! Common part of the programs: how they begin, what they say, and to whom.

use std::ffi::OsString;
use std::io::{ErrorKind, IsTerminal, Write};

use anstream::ColorChoice;
use anstyle::AnsiColor;
use clap::error::{ContextKind, ContextValue, ErrorKind as Misuse};
use clap::{Args, Command, Parser, ValueEnum};

use crate::examples::{Examples, with_examples};
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
    /// Colour in messages.
    ///
    /// By default on a terminal, unless NO_COLOR is set.
    #[arg(long, global = true, value_name = "WHEN", value_enum, default_value_t)]
    pub color: Colour,
    /// Worker threads (default: one per processor). Results do not depend on it.
    #[arg(long, global = true, value_name = "N", allow_negative_numbers = true, value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
}

/// When messages have colours.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Colour {
    /// On a terminal, as `NO_COLOR` and `CLICOLOR` say.
    #[default]
    Auto,
    /// Also in files and pipes.
    Always,
    /// Nowhere.
    Never,
}

impl Colour {
    fn choice(self) -> ColorChoice {
        match self {
            Self::Auto => ColorChoice::Auto,
            Self::Always => ColorChoice::Always,
            Self::Never => ColorChoice::Never,
        }
    }
}

/// A program as its users meet it.
pub(crate) struct Program {
    /// Argument of its usual command, for example `PART.mtx`.
    pub file: &'static str,
    /// Lines at the end of each help.
    pub examples: &'static [Examples],
    /// The other program, which may have an option that this one hasn't.
    pub other: fn() -> Command,
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

/// Begins a program: listens to signals, reads the arguments, of which the first is the program's name, and starts the worker threads, as many as
/// the arguments have in `common`.
///
/// # Errors
/// The exit status after help, version, or what is wrong with the arguments.
pub(crate) fn begin<C: Parser>(
    arguments: impl IntoIterator<Item = OsString>,
    program: &Program,
    common: impl Fn(&C) -> &CommonArguments,
) -> Result<C, u8> {
    stop_signal::listen();
    let command = with_examples(C::command(), program.examples);
    let parsed = command
        .try_get_matches_from(arguments)
        .and_then(|matches| C::from_arg_matches(&matches));
    let cli = parsed.map_err(|error| refuse(&in_our_words::<C>(error, program)))?;
    let common = common(&cli);
    common.color.choice().write_global();
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

/// What the parser says, where users know more than it: a second file, or a misspelt command before a file, is a conflict of commands to it, and
/// an option of another command is unknown.
fn in_our_words<C: Parser>(error: clap::Error, program: &Program) -> clap::Error {
    let said = match (
        error.kind(),
        error.get(ContextKind::InvalidSubcommand),
        error.get(ContextKind::InvalidArg),
    ) {
        (Misuse::ArgumentConflict, Some(ContextValue::String(word)), _) => Some((
            Misuse::TooManyValues,
            format!(
                "{word:?} is one argument too many: one {} is wanted, or the name of a command first (see --help)",
                program.file
            ),
        )),
        (Misuse::UnknownArgument, _, Some(ContextValue::String(option))) => {
            let mut owners = owners_of(option, &C::command());
            owners.extend(owners_of(option, &(program.other)()));
            (!owners.is_empty()).then(|| {
                (
                    Misuse::UnknownArgument,
                    format!(
                        "unexpected argument '{option}' here: it is an option of {}",
                        owners.join(", ")
                    ),
                )
            })
        }
        _ => None,
    };
    match said {
        Some((kind, message)) => C::command().error(kind, message),
        None => error,
    }
}

/// Commands of a program that have an option, `--step` for example.
fn owners_of(option: &str, program: &Command) -> Vec<String> {
    let has = |command: &Command| {
        command
            .get_arguments()
            .filter_map(|known| known.get_long())
            .any(|long| option.strip_prefix("--") == Some(long))
    };
    let name = program.get_name();
    let own = has(program).then(|| format!("`{name}`"));
    let of_commands = program.get_subcommands().filter(|command| has(command));
    own.into_iter()
        .chain(of_commands.map(|command| format!("`{name} {}`", command.get_name())))
        .collect()
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
    let style = match kind {
        "error" => AnsiColor::Red.on_default().bold(),
        "warning" => AnsiColor::Yellow.on_default().bold(),
        _ => AnsiColor::Cyan.on_default(),
    };
    let message = for_terminal(message);
    let _ = writeln!(anstream::stderr(), "{style}{kind}{style:#}: {message}");
}
