//! Help, version, schema and slips on the command line.

use crate::support::{Folder, says, stored};

#[test]
fn every_command_has_help() {
    let folder = Folder::empty();
    for (arguments, says) in [
        ("--help", "Usage: reduce [OPTIONS] <PART.mtx>"),
        ("-h", "Usage: reduce [OPTIONS] <PART.mtx>"),
        ("help", "Exit status: 0 done"),
        ("inspect --help", "Usage: reduce inspect [OPTIONS] <FILE>"),
        ("verify --help", "--component <PART.mtx>"),
        ("compare --help", "Usage: reduce compare [OPTIONS] <A> <B>"),
        ("schema --help", "JSON schema"),
        ("plan --help", "Usage: reduce plan [OPTIONS] <PART.mtx>"),
        ("study --help", "Usage: reduce study [OPTIONS] <PART.mtx>"),
        (
            "import --help",
            "Usage: reduce import [OPTIONS] <STIFFNESS> [MASS]",
        ),
        ("init --help", "Usage: reduce init [OPTIONS]"),
        ("export --help", "Usage: reduce export"),
        ("cache --help", "Usage: reduce cache [OPTIONS]"),
        (
            "batch --help",
            "Usage: reduce batch [OPTIONS] <MANIFEST.json>",
        ),
        ("--version", env!("CARGO_PKG_VERSION")),
    ] {
        let shown = folder.done(arguments);
        assert!(shown.contains(says), "{arguments}: {shown}");
        assert!(
            shown.lines().all(|line| line.chars().count() <= 120),
            "{arguments}: {shown}"
        );
    }
    assert!(folder.names().is_empty());
}

#[test]
fn help_names_every_option_of_a_reduction() {
    let shown = Folder::empty().done("--help");
    says!(
        shown,
        "--output",
        "--modes",
        "--max-frequency",
        "--interface-modes",
        "--scene",
        "--tolerance",
        "--keep-all",
        "--body",
        "--mass",
        "--mesh",
        "--boundary",
        "--force",
        "--without-fields",
        "--compress",
        "--timings",
        "--quiet",
        "--verbose",
        "--threads",
        "--allow-grounded",
        "--allow-loose",
        "--ranks",
        "--mpirun",
        "--ranks",
        "--mpirun",
        "--memory",
        "--factor",
        "--scratch",
        "--cache",
        "--cache-limit"
    );
}

#[test]
fn the_schema_is_the_documented_one() {
    let folder = Folder::empty();
    let shown = folder.done("schema");
    assert_eq!(
        shown,
        std::fs::read_to_string(stored("docs/component.schema.json")).unwrap()
    );
    let schema: serde_json::Value = serde_json::from_str(&shown).unwrap();
    assert_eq!(schema["title"], "Component description");
    assert_eq!(folder.done("schema --quiet"), shown);
}

#[test]
fn the_schema_of_manifests_is_the_documented_one() {
    let shown = Folder::empty().done("schema batch");
    let documented = std::fs::read_to_string(stored("docs/batch.schema.json")).unwrap();
    assert_eq!(shown, documented);
    let schema: serde_json::Value = serde_json::from_str(&shown).unwrap();
    let of = |place: &str| schema.pointer(place).unwrap();
    assert_eq!(of("/title"), "Manifest of `reduce batch`");
    assert_eq!(of("/properties/parts/items/$ref"), "#/$defs/PartEntry");
    assert!(of("/properties/defaults/properties/modes").is_object());
    assert!(schema["properties"]["defaults"]["properties"]["part"].is_null());
}

#[test]
fn the_schema_of_assemblies_is_the_documented_one() {
    let shown = Folder::empty().done("schema assembly");
    let documented = std::fs::read_to_string(stored("docs/assembly.schema.json")).unwrap();
    assert_eq!(shown, documented);
    let schema: serde_json::Value = serde_json::from_str(&shown).unwrap();
    assert_eq!(schema["title"], "Assembly");
    assert!(schema.pointer("/properties/interfaces").is_some());
}

#[test]
fn slips_on_the_command_line_are_refused() {
    let folder = Folder::rotor();
    for (arguments, says) in [
        ("", "<PART.mtx>"),
        ("rotor.mtx --mode 3", "'--modes'"),
        (
            "rotor.mtx --modes 3 --max-frequency 100",
            "cannot be used with",
        ),
        ("rotor.mtx --modes -1", "0 or more"),
        ("rotor.mtx --modes many", "0 or more"),
        ("rotor.mtx --max-frequency -5", "positive number of Hz"),
        ("rotor.mtx --max-frequency nan", "positive number of Hz"),
        ("rotor.mtx --max-frequency inf", "positive number of Hz"),
        ("rotor.mtx --interface-modes -1", "0 or more"),
        (
            "rotor.mtx --interface-modes few",
            "interface modes is wanted",
        ),
        ("rotor.mtx --interface-modes 2.5", "0 or more"),
        ("rotor.mtx --interface-modes", "a value is required"),
        ("rotor.mtx --threads 0", "1..=1024"),
        ("inspect", "<FILE>"),
        ("batch", "<MANIFEST.json>"),
        ("batch m.json --shard 0/4", "I from 1 to N"),
        ("batch m.json --shard 5/4", "I from 1 to N"),
        ("batch m.json --jobs 0", "1..=1024"),
        ("batch m.json --no-cache --cache", "cannot be used with"),
        ("cache --clear --json", "cannot be used with"),
        ("rotor.mtx --cache --cache-limit 5", "a size such as"),
        ("compare rotor.dcb.h5", "<B>"),
        ("verify rotor.dcb.h5 --json", "'--json'"),
    ] {
        folder.refused(arguments, &[says]);
    }
}

#[cfg(not(feature = "ranks"))]
#[test]
fn a_build_without_ranks_says_so() {
    let folder = Folder::rotor();
    let says = [
        "built without the feature ranks",
        "--features ranks",
        "--factor disk",
    ];
    folder.refused_each(&[
        ("rotor.mtx --ranks 2", &says),
        ("plan rotor.mtx --ranks 2 --mpirun mpirun", &says),
        ("rotor.mtx --mpirun mpirun", &["say with --ranks"]),
    ]);
}

#[test]
fn the_page_of_commands_says_what_the_helps_say() {
    let documented = std::fs::read_to_string(stored("docs/commands.md")).unwrap();
    assert!(
        documented == dcb_programs::command_page::page(),
        "run: cargo run --release -p dcb-programs --example commands_page > docs/commands.md"
    );
    // Options that the page must have, whoever made it.
    let shown = Folder::empty().done("study --help");
    for option in ["--variants", "--tolerance", "--loss-factor"] {
        says!(shown, option);
        says!(documented, format!("`{option} "));
    }
}

/// Options of every command stand under their own heading.
#[test]
fn options_of_every_command_are_not_those_of_other_programs() {
    let shown = Folder::empty().done("--help");
    let (_, rest) = shown.split_once("Files of other programs").unwrap();
    for option in ["--force", "--memory", "--cache", "--quiet", "--threads"] {
        assert!(!rest.contains(option), "{option}: {shown}");
    }
    says!(rest, "--units", "--repair-order");
}

#[test]
fn a_misspelt_command_is_told_from_a_file() {
    let folder = Folder::rotor();
    folder.refused("inspekt rotor.dcb.h5", &["did you mean `inspect`?"]);
    folder.refused(
        "inspect rotor.dcb.h5 --modes 3",
        &["--modes", "Usage: reduce inspect"],
    );
}
