//! Examples at the end of every help: lines that work as they stand, once the files have these names.

use clap::Command;

/// A command, empty for that without a name, and what is typed.
pub(crate) type Examples = (&'static str, &'static [&'static str]);

/// Those of `reduce`.
pub(crate) const REDUCE: &[Examples] = &[
    (
        "",
        &[
            "reduce part.mtx",
            "reduce part.mtx --max-frequency 500 -o part.dcb.h5",
            "reduce stiffness.mtx --mass mass.mtx --mesh part.json --modes 30",
        ],
    ),
    (
        "import",
        &["reduce import abaqus_STIF1.mtx abaqus_MASS1.mtx --mesh part.inp --units mm,t,s"],
    ),
    (
        "init",
        &["reduce init part.inp --units mm,t,s --interfaces HUB,TIP:rigid"],
    ),
    (
        "inspect",
        &[
            "reduce inspect part.dcb.h5",
            "reduce inspect part.dcb.h5 --json",
        ],
    ),
    (
        "verify",
        &[
            "reduce verify part.dcb.h5",
            "reduce verify part.dcb.h5 --component part.mtx",
        ],
    ),
    (
        "assemble",
        &[
            "reduce assemble machine.json",
            "reduce assemble machine.json --max-frequency 500 -o machine.dcb.h5",
        ],
    ),
    (
        "update",
        &[
            "reduce update part.dcb.h5 --measured modes.csv",
            "reduce update part.dcb.h5 --measured modes.csv --replace damping",
        ],
    ),
    ("compare", &["reduce compare coarse.dcb.h5 fine.dcb.h5"]),
    ("report", &["reduce report part.dcb.h5 -o part.html"]),
    ("export", &["reduce export part.dcb.h5 --to gltf"]),
    ("plan", &["reduce plan part.mtx --modes 20"]),
    ("study", &["reduce study part.mtx --modes 5,10,20,40"]),
    ("cache", &["reduce cache", "reduce cache --clear"]),
    ("batch", &["reduce batch parts.json"]),
    ("schema", &["reduce schema", "reduce schema assembly"]),
    ("completions", &["reduce completions bash"]),
    ("man", &["reduce man --out man"]),
];

/// Those of `simulate`.
pub(crate) const SIMULATE: &[Examples] = &[
    (
        "",
        &[
            "simulate scene.json",
            "simulate scene.json --step 1e-4 --end 0.5 -o short.h5 --force",
            "simulate - -o run.h5",
        ],
    ),
    (
        "init",
        &[
            "simulate init rod.dcb.h5 -o scene.json",
            "simulate init arm.dcb.h5 forearm.dcb.h5",
        ],
    ),
    (
        "study",
        &["simulate study scene.json --modes 2,5,10 --step 1e-4,5e-5"],
    ),
    ("prepare", &["simulate prepare scene.json -o prepared"]),
    ("linearize", &["simulate linearize scene.json --at static"]),
    (
        "campbell",
        &["simulate campbell rotor.json --rpm 1000:30000:30 --svg campbell.svg"],
    ),
    ("fmu", &["simulate fmu scene.json"]),
    (
        "plot",
        &[
            "simulate plot scene.h5",
            "simulate plot scene.h5 tip energy -o tip.svg",
        ],
    ),
    ("csv", &["simulate csv scene.h5 tip -o tip.csv"]),
    ("animate", &["simulate animate scene.h5"]),
    ("report", &["simulate report scene.h5 -o run.html"]),
    ("show", &["simulate show scene.h5"]),
    ("schema", &["simulate schema"]),
    ("completions", &["simulate completions zsh"]),
    ("man", &["simulate man --out man"]),
];

/// The command with examples in its help and those of its commands.
pub(crate) fn with_examples(command: Command, all: &[Examples]) -> Command {
    let names: Vec<String> = command
        .get_subcommands()
        .map(|one| one.get_name().to_owned())
        .collect();
    let command = names.iter().fold(command, |command, name| {
        command.mut_subcommand(name, |one| added(one, all, name))
    });
    added(command, all, "")
}

fn added(command: Command, all: &[Examples], name: &str) -> Command {
    let Some((_, lines)) = all.iter().find(|(known, _)| *known == name) else {
        return command;
    };
    let mut text = String::from("Examples:");
    for line in *lines {
        text += "\n  ";
        text += line;
    }
    if let Some(after) = command.get_after_help() {
        text += &format!("\n\n{after}");
    }
    command.after_help(text)
}

#[cfg(test)]
#[allow(clippy::panic, clippy::unwrap_used)]
mod tests {
    use super::*;

    fn check(command: Command, all: &[Examples]) {
        let program = command.get_name().to_owned();
        for one in command.get_subcommands() {
            let name = one.get_name();
            assert!(
                name == "help" || all.iter().any(|(known, _)| *known == name),
                "{program} {name} has no example"
            );
        }
        let command = with_examples(command, all);
        for line in all.iter().flat_map(|(_, lines)| *lines) {
            let found = command.clone().try_get_matches_from(line.split(' '));
            assert!(found.is_ok(), "{line}: {}", found.unwrap_err());
        }
        for (name, lines) in all {
            let mut command = command.clone();
            let of = match *name {
                "" => &mut command,
                name => command.find_subcommand_mut(name).unwrap(),
            };
            let help = of.render_long_help().to_string();
            assert!(
                help.contains("Examples:") && help.contains(lines[0]),
                "{help}"
            );
        }
    }

    #[test]
    fn every_command_has_examples_that_parse() {
        check(crate::reduce::command(), REDUCE);
        check(crate::simulate::command(), SIMULATE);
    }
}
