//! A disk without room, where this machine lets the tests make one.

use std::fs;
use std::path::Path;
use std::process::Command;

use crate::part_folder::skipped;
use crate::support::{Folder, answer};

/// A file system of so many KiB, unmounted when dropped.
struct SmallDisk<'a> {
    place: &'a Path,
}

impl<'a> SmallDisk<'a> {
    fn mount(place: &'a Path, kilobytes: u32) -> Option<Self> {
        fs::create_dir(place).unwrap();
        let size = format!("size={kilobytes}k");
        let mount = Command::new("mount")
            .args(["-t", "tmpfs", "-o", &size, "tmpfs"])
            .arg(place)
            .output();
        mount
            .is_ok_and(|output| output.status.success())
            .then_some(Self { place })
    }
}

impl Drop for SmallDisk<'_> {
    fn drop(&mut self) {
        let _ = Command::new("umount").arg("-l").arg(self.place).status();
    }
}

#[test]
fn a_full_disk_is_told_and_keeps_the_old_output() {
    let folder = Folder::rotor();
    let place = folder.path("disk");
    let Some(_disk) = SmallDisk::mount(&place, 64) else {
        return skipped("mounting a small file system needs root; the full disk wasn't tested");
    };
    folder.refused(
        "rotor.mtx -o disk/rotor.dcb.h5",
        &["disk/rotor.dcb.h5: disk full: needs ", "No space left"],
    );
    folder.write("disk/rotor.dcb.h5", "precious");
    for options in ["", "--compress"] {
        let arguments = format!("rotor.mtx -o disk/rotor.dcb.h5 --force {options}");
        folder.refused(&arguments, &["disk/rotor.dcb.h5", "No space left"]);
    }
}

#[test]
fn a_disk_too_small_for_the_factor_is_told() {
    let folder = Folder::rotor();
    let place = folder.path("disk");
    let Some(_disk) = SmallDisk::mount(&place, 64) else {
        return skipped("mounting a small file system needs root; the full disk wasn't tested");
    };
    let says = ["disk: cannot keep the factor here", "No space left"];
    folder.refused("rotor.mtx --factor disk --scratch disk", &says);
    assert!(!folder.names().contains(&"rotor.dcb.h5".to_owned()));
}

/// A full disk, as `ulimit -f` makes one for everybody.
#[test]
fn a_superelement_without_room_is_told_and_keeps_the_old_output() {
    let folder = Folder::rotor();
    folder.write("rotor.dcb.h5", "precious");
    folder.write("t.json", "precious");
    let before = folder.contents();
    for options in ["", "--compress"] {
        let answer = folder.run_within(16, &format!("rotor.mtx --force {options}"));
        answer.is_error(
            2,
            &["rotor.dcb.h5: larger than a file may be here", "needs "],
        );
        assert_eq!(folder.contents(), before);
    }
    let answer = folder.run_within(16, "rotor.mtx --force --factor disk");
    answer.is_error(2, &["cannot keep the factor here, which needs ", "MB"]);
    assert_eq!(folder.contents(), before);
}

#[test]
fn a_full_standard_output_is_an_error() {
    let folder = Folder::rotor();
    folder.done("rotor.mtx");
    let Ok(full) = fs::File::options().write(true).open("/dev/full") else {
        return skipped("no /dev/full here");
    };
    let mut command = folder.command("inspect rotor.dcb.h5 --json");
    let answer = answer(command.stdout(full));
    answer.is_error(2, &["standard output", "No space left"]);
}

#[test]
fn a_reader_that_closes_the_pipe_early_is_no_error() {
    let folder = Folder::rotor();
    folder.done("rotor.mtx");
    for arguments in [
        "inspect rotor.dcb.h5",
        "verify rotor.dcb.h5",
        "--help",
        "schema",
    ] {
        let script = format!("\"$0\" {arguments} | true; exit ${{PIPESTATUS[0]}}");
        let answer = answer(&mut folder.shell(&script));
        assert_eq!((answer.code, answer.stderr.as_str()), (Some(0), ""));
    }
}

#[test]
fn nobody_listening_to_errors_is_no_crash() {
    let folder = Folder::rotor();
    let mut shell = folder.shell("\"$0\" nowhere.mtx 2>&-");
    assert_eq!(answer(&mut shell).code, Some(2));
}
