//! `completions` and `man` of both programs: what a shell and `man` know of them.

use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

use clap::{Args, Command};
use clap_complete::Shell;
use dcb_formats::output::{Replace, write_stream};

use crate::outcome::Outcome;

/// Whose completions.
#[derive(Debug, Args)]
pub(crate) struct CompletionArguments {
    /// Shell that is to complete the program's commands and options.
    #[arg(value_enum)]
    shell: Shell,
}

/// Where the manual goes.
#[derive(Debug, Args)]
pub(crate) struct ManualArguments {
    /// Folder for the pages, one a command; it must exist.
    #[arg(long, value_name = "FOLDER", default_value = ".")]
    out: PathBuf,
}

/// The completions of a program, to be read by the shell.
pub(crate) fn completions(mut command: Command, arguments: &CompletionArguments) -> Outcome {
    let name = command.get_name().to_owned();
    let mut script = Vec::new();
    clap_complete::generate(arguments.shell, &mut command, name, &mut script);
    Outcome::done(String::from_utf8_lossy(&script).into_owned())
}

/// Writes the pages of a program's manual; older ones are replaced.
///
/// # Errors
/// [`dcb_formats::Error::Io`].
pub(crate) fn manual(
    mut command: Command,
    arguments: &ManualArguments,
) -> Result<Outcome, dcb_formats::Error> {
    command.build();
    let mut written = String::new();
    let mut write = |command: &Command, name: &str| -> Result<(), dcb_formats::Error> {
        let path = arguments.out.join(format!("{name}.1"));
        let page = page(command.clone().display_name(name.to_owned()))
            .map_err(|source| dcb_formats::Error::io(&path, "cannot write", source))?;
        write_stream(&path, Replace::Overwrite, |out| out.write_all(&page))?;
        written += &told(&path);
        Ok(())
    };
    write(&command, command.get_name())?;
    for one in command.get_subcommands() {
        if one.get_name() != "help" {
            write(one, &format!("{}-{}", command.get_name(), one.get_name()))?;
        }
    }
    Ok(Outcome::done(written))
}

fn page(command: Command) -> io::Result<Vec<u8>> {
    let mut page = Vec::new();
    clap_mangen::Man::new(command).render(&mut page)?;
    Ok(page)
}

fn told(path: &Path) -> String {
    format!("{}\n", path.display())
}
