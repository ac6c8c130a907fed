//! Limits that the system sets to threads and to address space, as in containers.
#![cfg(target_os = "linux")]

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::os::unix::process::ExitStatusExt;
use std::process::{Command, Output};

use crate::support::{Folder, REDUCE};

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// The program with so many kilobytes of address space.
fn within(kilobytes: u64, folder: &Folder, arguments: &str) -> Output {
    let script = format!("ulimit -v {kilobytes}; ulimit -c 0; exec \"$0\" {arguments}");
    Command::new("sh")
        .args(["-c", &script, REDUCE])
        .current_dir(folder.path(""))
        .output()
        .unwrap()
}

/// Allowed outcomes: done, or one message, status 1 and no file left.
#[test]
fn memory_that_is_refused_is_told_and_leaves_nothing() {
    let folder = Folder::with(&dcb_samples::connecting_rod(0));
    let before = folder.names();
    let (mut refused, mut told, mut done) = (0, 0, 0);
    for megabytes in [50, 60, 75, 90, 110, 130, 150, 180, 220, 260, 400, 2000] {
        let output = within(
            1024 * megabytes,
            &folder,
            "part.mtx --quiet -o out.dcb.h5 --force --threads 2",
        );
        let stderr = text(&output.stderr);
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
    let output = within(2_000_000, &folder, "rotor.mtx --threads 1000");
    let stderr = text(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{stderr}");
    assert!(
        stderr.starts_with("note: ") && stderr.contains("threads instead of 1000"),
        "{stderr}"
    );
}

/// With no thread beside the first one, the program works alone, and its results are the same.
#[test]
fn a_program_that_may_start_no_thread_works_alone() {
    let folder = Folder::rotor();
    folder.done("rotor.mtx -o free.dcb.h5");
    fs::set_permissions(folder.path(""), fs::Permissions::from_mode(0o777)).unwrap();
    let is_root = text(&Command::new("id").arg("-u").output().unwrap().stdout).trim() == "0";
    let program = folder.path("program");
    fs::copy(REDUCE, &program).unwrap();
    // Limits don't hold for root.
    let mut command = match is_root {
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
    let output = command
        .arg("--nproc=1")
        .arg(&program)
        .args(["rotor.mtx", "-o", "alone.dcb.h5", "--threads", "4"])
        .current_dir(folder.path(""))
        .output()
        .unwrap();
    let stderr = text(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{stderr}");
    assert!(
        stderr.starts_with("note: 1 thread instead of 4"),
        "{stderr}"
    );
    assert!(!stderr.contains("panicked"), "{stderr}");
    let digest = |name: &str| folder.inspected(name)["digest"].clone();
    assert!(digest("alone.dcb.h5").is_string());
    assert_eq!(digest("alone.dcb.h5"), digest("free.dcb.h5"));
}
