//! Limits that the system sets to threads and to address space, as in containers.
#![cfg(target_os = "linux")]

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::os::unix::process::ExitStatusExt;
use std::process::Command;

use crate::PROGRAM;
use crate::part_folder::is_root;
use crate::support::{Answer, Folder, answer, says};

/// Allowed outcomes: done, or one message, status 1 and no file left.
#[test]
fn memory_that_is_refused_is_told_and_leaves_nothing() {
    let folder = Folder::with(&dcb_samples::connecting_rod(0));
    let before = folder.names();
    let (mut refused, mut told, mut done) = (0, 0, 0);
    for megabytes in [50, 60, 75, 90, 110, 130, 150, 180, 220, 260, 400, 2000] {
        let arguments = "part.mtx --quiet -o out.dcb.h5 --force --threads 2";
        let output = folder.run_in_memory(1024 * megabytes, arguments);
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.signal(), None, "{megabytes} MB: {stderr}");
        match output.status.code() {
            Some(0) => {
                done += 1;
                folder.remove("out.dcb.h5");
            }
            Some(1) => {
                refused += 1;
                assert!(stderr.starts_with("error: "), "{stderr}");
                assert_eq!(stderr.lines().count(), 1, "{megabytes} MB: {stderr}");
                // The system's own words where a file is read, ours elsewhere.
                let is_ours = stderr.starts_with("error: out of memory in the stage \"");
                for says in [" MB more are needed", "ulimit -v", "allow more"] {
                    assert!(
                        !is_ours || stderr.contains(says),
                        "{megabytes} MB: {stderr}"
                    );
                }
                assert!(
                    is_ours || stderr.contains("memory"),
                    "{megabytes} MB: {stderr}"
                );
                told += usize::from(is_ours);
            }
            // Libraries that can't be loaded.
            Some(127) => assert!(!stderr.contains("out of memory"), "{stderr}"),
            other => panic!("{megabytes} MB: {other:?} {stderr}"),
        }
        assert_eq!(folder.names(), before, "{megabytes} MB");
    }
    assert!(
        refused > 2 && told > 1 && done > 0,
        "{refused} refused, {told} by us, {done} done"
    );
}

#[test]
fn threads_are_fewer_where_their_stacks_have_no_room() {
    let folder = Folder::rotor();
    let answer = Answer::of(folder.run_in_memory(2_000_000, "rotor.mtx --threads 1000"));
    assert_eq!(answer.code, Some(0), "{answer:?}");
    says!(
        answer.stderr,
        "note: ",
        "thread",
        " instead of 1000: the system allows no more"
    );
}

/// With no thread beside the first one, the program works alone, and its results are the same.
#[test]
fn a_program_that_may_start_no_thread_works_alone() {
    let folder = Folder::rotor();
    folder.done("rotor.mtx -o free.dcb.h5");
    fs::set_permissions(folder.path(""), fs::Permissions::from_mode(0o777)).unwrap();
    let program = folder.path("program");
    fs::copy(PROGRAM, &program).unwrap();
    // Limits don't hold for root.
    let mut command = match is_root() {
        true => {
            let mut command = Command::new("setpriv");
            command.args([
                "--reuid=65534",
                "--regid=65534",
                "--clear-groups",
                "prlimit",
            ]);
            command
        }
        false => Command::new("prlimit"),
    };
    command.arg("--nproc=1").arg(&program);
    command.args(["rotor.mtx", "-o", "alone.dcb.h5", "--threads", "4"]);
    let answer = answer(command.current_dir(folder.path("")));
    assert_eq!(answer.code, Some(0), "{answer:?}");
    says!(answer.stderr, "note: 1 thread instead of 4");
    assert_eq!(folder.digest("alone.dcb.h5"), folder.digest("free.dcb.h5"));
}
