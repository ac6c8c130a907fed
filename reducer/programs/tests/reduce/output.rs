//! Where the output may go.

use std::fs;
use std::os::unix::fs::{PermissionsExt, symlink};
use std::os::unix::process::CommandExt;

use crate::part_folder::{is_root, skipped};
use crate::support::{Folder, answer};

#[test]
fn an_existing_output_is_kept_unless_forced() {
    let folder = Folder::rotor();
    folder.write("rotor.dcb.h5", "precious");
    folder.refused("rotor.mtx", &["rotor.dcb.h5", "exists already", "--force"]);
    // A failing reduction keeps it as well.
    folder.refused("rotor.mtx --force --mesh rotor.mtx", &["rotor.mtx"]);
    folder.done("rotor.mtx --force");
    folder.done("verify rotor.dcb.h5");
}

#[test]
fn an_output_needs_a_folder_and_a_name() {
    let folder = Folder::rotor();
    folder.refused_each(&[
        ("rotor.mtx -o .", &[".", "is a folder"]),
        (
            "rotor.mtx -o no/x.dcb.h5",
            &["no/x.dcb.h5", "doesn't exist"],
        ),
        (
            "rotor.mtx -o rotor.json/x.dcb.h5",
            &["rotor.json", "doesn't exist"],
        ),
    ]);
}

#[test]
fn an_input_is_never_written_over() {
    let folder = Folder::rod();
    symlink("rod.json", folder.path("alias.h5")).unwrap();
    fs::hard_link(folder.path("rod.mtx"), folder.path("hard.h5")).unwrap();
    for name in [
        "rod.mtx",
        "./rod.mass.mtx",
        "rod.json",
        "rod.mass.xx.mtx",
        "alias.h5",
        "hard.h5",
    ] {
        folder.refused_each(&[
            (&format!("rod.mtx --force -o {name}"), &["is an input"]),
            (&format!("rod.mtx --timings {name}"), &["is an input"]),
        ]);
    }
}

#[test]
fn timings_are_not_the_output_and_their_place_is_checked_first() {
    let folder = Folder::rotor();
    folder.refused_each(&[
        (
            "rotor.mtx --timings rotor.dcb.h5",
            &["rotor.dcb.h5", "is the output"],
        ),
        ("rotor.mtx --timings ./rotor.dcb.h5", &["is the output"]),
        (
            "rotor.mtx --timings no/times.json",
            &["no/times.json", "doesn't exist"],
        ),
        ("rotor.mtx --timings .", &["is a folder"]),
    ]);
}

/// As `nobody` where the test is root, whom nothing stops.
#[test]
fn a_folder_or_file_without_permission_is_refused() {
    let folder = Folder::rotor();
    let allow = |name: &str, mode: u32| {
        fs::set_permissions(folder.path(name), fs::Permissions::from_mode(mode)).unwrap()
    };
    let run = |arguments: &str| {
        let mut command = folder.command(arguments);
        if is_root() {
            command.uid(65534).gid(65534);
        }
        let runs = command.output().is_ok();
        runs.then(|| answer(&mut command))
    };
    allow(".", 0o555);
    let Some(first) = run("rotor.mtx") else {
        allow(".", 0o755);
        return skipped("nobody may not run the program; permissions weren't tested");
    };
    first.is_error(2, &["cannot write in this folder", "Permission denied"]);
    allow(".", 0o755);
    allow("rotor.mass.mtx", 0);
    let second = run("rotor.mtx -o /tmp/never-written.dcb.h5").unwrap();
    allow("rotor.mass.mtx", 0o644);
    second.is_error(2, &["rotor.mass.mtx", "cannot read", "Permission denied"]);
    assert_eq!(
        folder.names(),
        ["rotor.json", "rotor.mass.mtx", "rotor.mtx"]
    );
}
