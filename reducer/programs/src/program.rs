//! Common part of the programs: how they begin, what they say, and to whom.

use std::ffi::OsString;
use std::io::{ErrorKind, IsTerminal, Write};
use std::path::Path;

use anstream::ColorChoice;
use anstyle::AnsiColor;
use clap::error::{ContextKind, ContextValue, ErrorKind as Misuse};
use clap::{Args, Command, Parser, ValueEnum};

use crate::examples::{Examples, with_examples};
use crate::stop_signal;
use dcb_formats::Error;
use dcb_formats::description::nearest_name;
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

/// How much is said.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Detail {
    /// What came of it, how good it is, and what to look at.
    Verdict,
    /// The tables besides.
    Tables,
}

/// Options of every command.
#[derive(Debug, Args)]
pub struct CommonArguments {
    /// Print no summary, warnings or progress.
    #[arg(long, short, global = true)]
    pub quiet: bool,
    /// Say more: tables, counts, costs and every note.
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
    /// How much is said.
    pub fn detail(&self) -> Detail {
        match self.verbose {
            true => Detail::Tables,
            false => Detail::Verdict,
        }
    }

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
    let arguments: Vec<OsString> = arguments.into_iter().collect();
    let command = with_examples(C::command(), program.examples);
    let parsed = command
        .clone()
        .try_get_matches_from(&arguments)
        .and_then(|matches| C::from_arg_matches(&matches));
    let cli = parsed.map_err(|error| {
        colour_asked(&arguments).choice().write_global();
        refuse(&in_our_words(error, command, program, &arguments))
    })?;
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
        let choice = anstream::AutoStream::choice(&std::io::stderr());
        let rendered = error.render();
        let message = match choice {
            // Styles are put in by this program, control characters of names are not let through.
            ColorChoice::Never => for_terminal(&rendered.to_string()),
            _ => styled(&rendered.ansi().to_string(), &rendered.to_string()),
        };
        let _ = std::io::stderr().write_all(message.as_bytes());
    } else {
        let _ = error.print();
    }
    u8::try_from(error.exit_code()).unwrap_or(2)
}

/// A text with styles, if they are all that a terminal would obey in it; else without them.
fn styled(with_styles: &str, plain: &str) -> String {
    match for_terminal(plain) == plain && !plain.contains('\u{1b}') {
        true => with_styles.to_owned(),
        false => for_terminal(plain),
    }
}

/// When messages have colours, where the arguments can't be read as a whole.
fn colour_asked(arguments: &[OsString]) -> Colour {
    let mut values = arguments.iter().zip(arguments.iter().skip(1));
    let beside = values.find(|(option, _)| *option == "--color");
    let joined = || {
        let mut texts = arguments.iter().filter_map(|text| text.to_str());
        texts.find_map(|text| text.strip_prefix("--color=").map(str::to_owned))
    };
    let value = match beside {
        Some((_, value)) => value.to_str().map(str::to_owned),
        None => joined(),
    };
    let value = value.and_then(|value| Colour::from_str(&value, true).ok());
    value.unwrap_or_default()
}

/// The command that the arguments name, with the usage that belongs to it.
fn named_command(mut command: Command, arguments: &[OsString]) -> Command {
    command.build();
    let words = arguments.iter().skip(1).filter_map(|word| word.to_str());
    let mut commands = words.filter_map(|word| command.find_subcommand(word));
    match commands.next().cloned() {
        Some(named) => named,
        None => command,
    }
}

/// What the parser says, where users know more than it: a second file, or a misspelt command before a file, is a conflict of commands to it, and
/// an option of another command is unknown.
fn in_our_words(
    error: clap::Error,
    command: Command,
    program: &Program,
    arguments: &[OsString],
) -> clap::Error {
    let said = match (
        error.kind(),
        error.get(ContextKind::InvalidSubcommand),
        error.get(ContextKind::InvalidArg),
    ) {
        (Misuse::ArgumentConflict, Some(ContextValue::String(word)), _) => Some((
            Misuse::TooManyValues,
            match misspelt(&command, arguments) {
                Some((found, meant)) => {
                    format!("there is no command {found:?}; did you mean `{meant}`?")
                }
                None => format!(
                    "{word:?} is one argument too many: one {} is wanted, or the name of a command first (see --help)",
                    program.file
                ),
            },
        )),
        (Misuse::UnknownArgument, _, Some(ContextValue::String(option))) => {
            let mut owners = owners_of(option, &command);
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
        Some((kind, message)) => named_command(command, arguments).error(kind, message),
        None => error,
    }
}

/// The first word that is nearly the name of a command and no file.
fn misspelt<'a>(command: &'a Command, arguments: &'a [OsString]) -> Option<(&'a str, &'a str)> {
    let words = arguments.iter().skip(1).filter_map(|word| word.to_str());
    let mut words = words
        .filter(|word| !word.starts_with('-') && !word.contains('.') && !Path::new(word).exists());
    words.find_map(|word| {
        let names = command.get_subcommands().map(Command::get_name);
        nearest_name(word, names).map(|meant| (word, meant))
    })
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
