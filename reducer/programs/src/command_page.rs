//! All commands of both programs and their options as one page: `docs/commands.md`. It says what the programs' helps say.

use std::fmt::Write as _;

use clap::{Arg, Command};

use crate::examples::{Examples, REDUCE, SIMULATE};
use crate::{reduce, simulate};

const BEGIN: &str = "\
# Commands

Every command of `reduce` and `simulate`, with its options. Behind a command, `--help` says the same at more length. `man --out FOLDER` writes it as manual pages, `completions SHELL`
teaches it to your shell.

Results go to standard output, everything else to standard error; progress bars only on a terminal. Exit status: 0 done, 1 numerical failure or broken quality limit, 2 unusable input or no
room for the output, 130 interrupted (143 by SIGTERM, 129 by SIGHUP). A file that is there already is kept unless `--force` is given.

This page is made of the programs' own helps: `cargo run --release -p dcb-programs --example commands_page > docs/commands.md`.
";

/// The page, in Markdown.
pub fn page() -> String {
    let mut text = BEGIN.to_owned();
    program(&mut text, reduce::command(), "PART.mtx", REDUCE);
    program(&mut text, simulate::command(), "SCENE.json", SIMULATE);
    text
}

/// A program: its commands, the options of all of them, and each command by itself. Its usual command is that with a `file` and no name.
fn program(text: &mut String, mut command: Command, file: &str, examples: &[Examples]) {
    command.build();
    let name = command.get_name().to_owned();
    let commands: Vec<&Command> = command
        .get_subcommands()
        .filter(|one| one.get_name() != "help")
        .collect();
    let _ = write!(text, "\n## {name}\n\n| command | does |\n| --- | --- |\n");
    let mut row = |title: &str, of: &Command| {
        let anchor = title.to_lowercase().replace(' ', "-").replace('.', "");
        let _ = writeln!(text, "| [`{title}`](#{anchor}) | {} |", about(of));
    };
    let usual = format!("{name} {file}");
    row(&usual, &command);
    for one in &commands {
        row(&format!("{name} {}", one.get_name()), one);
    }
    let global = command.get_arguments().filter(|one| one.is_global_set());
    let _ = write!(text, "\nOptions of every command:\n\n");
    table(text, global);
    one_command(text, &usual, &command, examples);
    for one in commands {
        one_command(text, &format!("{name} {}", one.get_name()), one, examples);
    }
}

/// A command: what it does, examples, and its options under the headings of its help.
fn one_command(text: &mut String, title: &str, command: &Command, all: &[Examples]) {
    let _ = write!(text, "\n### {title}\n\n{}\n", about(command));
    let name = match command.get_subcommands().next() {
        Some(_) => "",
        None => command.get_name(),
    };
    if let Some((_, lines)) = all.iter().find(|(known, _)| *known == name) {
        let _ = write!(text, "\n```sh\n{}\n```\n", lines.join("\n"));
    }
    let own = |one: &&Arg| {
        let is_ours = !one.is_global_set() && !one.is_hide_set();
        is_ours && one.get_id() != "help" && one.get_id() != "version"
    };
    let options: Vec<&Arg> = command.get_arguments().filter(own).collect();
    let mut headings: Vec<Option<&str>> = Vec::new();
    for one in &options {
        if !headings.contains(&one.get_help_heading()) {
            headings.push(one.get_help_heading());
        }
    }
    headings.sort_by_key(Option::is_some);
    for heading in headings {
        match heading {
            Some(heading) => _ = write!(text, "\n{heading}:\n\n"),
            None => text.push('\n'),
        }
        let options = options.iter().copied();
        table(
            text,
            options.filter(|one| one.get_help_heading() == heading),
        );
    }
}

fn table<'a>(text: &mut String, options: impl Iterator<Item = &'a Arg>) {
    text.push_str("| option | what |\n| --- | --- |\n");
    for one in options {
        let _ = writeln!(text, "| `{}` | {} |", spelling(one), meaning(one));
    }
}

fn about(command: &Command) -> String {
    let about = command.get_about().map(ToString::to_string);
    let about = cell(&about.unwrap_or_default());
    match about.ends_with('.') {
        true => about,
        false => about + ".",
    }
}

/// As it is typed, with what it takes.
fn spelling(one: &Arg) -> String {
    let values = one.get_value_names().unwrap_or_default();
    let values: Vec<&str> = values.iter().map(clap::builder::Str::as_str).collect();
    let short = one.get_short().map(|letter| format!("-{letter}"));
    let long = one.get_long().map(|name| format!("--{name}"));
    let mut names: Vec<String> = short.into_iter().chain(long).collect();
    if names.is_empty() {
        return values.join(" ");
    }
    if one.get_action().takes_values()
        && let Some(last) = names.last_mut()
    {
        *last += &format!(" {}", values.join(" "));
    }
    names.join(", ")
}

/// What it does, what it may be and what it is if it isn't given.
fn meaning(one: &Arg) -> String {
    let help = one.get_help().map(ToString::to_string);
    let mut meaning = cell(&help.unwrap_or_default());
    if !meaning.ends_with('.') {
        meaning.push('.');
    }
    if one.get_action().takes_values() {
        let choices = one.get_possible_values();
        let choices = choices.iter().filter(|choice| !choice.is_hide_set());
        let choices: Vec<String> = choices
            .map(|choice| format!("`{}`", choice.get_name()))
            .collect();
        if !choices.is_empty() {
            meaning += &format!(" One of {}.", choices.join(", "));
        }
        let defaults = one.get_default_values().iter();
        let defaults: Vec<_> = defaults
            .map(|value| format!("`{}`", value.to_string_lossy()))
            .collect();
        if !defaults.is_empty() {
            meaning += &format!(" Default {}.", defaults.join(", "));
        }
    }
    meaning
}

/// Text in a table: one line, nothing in it that Markdown would obey outside of code.
fn cell(text: &str) -> String {
    let mut cell = String::new();
    let mut is_code = false;
    for letter in text.replace('\n', " ").chars() {
        is_code ^= letter == '`';
        if letter == '|' || !is_code && matches!(letter, '<' | '*' | '_' | '[') {
            cell.push('\\');
        }
        cell.push(letter);
    }
    cell
}
