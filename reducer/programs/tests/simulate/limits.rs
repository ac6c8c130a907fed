//! Limits that the system sets to threads and to address space, as in containers.
#![cfg(target_os = "linux")]

use std::os::unix::process::ExitStatusExt;

use crate::support::{Answer, Folder, says};

/// Allowed outcomes: done, or one message and status 1.
#[test]
fn memory_that_is_refused_is_told() {
    let folder = Folder::slider_crank();
    let (mut refused, mut done) = (0, 0);
    for megabytes in [30, 35, 40, 45, 50, 60, 70, 85, 100, 150, 300, 2000] {
        let output = folder.run_in_memory(1024 * megabytes, "scene.json --quiet --force");
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.signal(), None, "{megabytes} MB: {stderr}");
        match output.status.code() {
            Some(0) => done += 1,
            Some(1) => {
                refused += 1;
                assert!(
                    stderr.starts_with("error: ") && stderr.contains("out of memory"),
                    "{stderr}"
                );
                assert_eq!(stderr.lines().count(), 1, "{megabytes} MB: {stderr}");
            }
            // Libraries that can't be loaded.
            Some(127) => {}
            other => panic!("{megabytes} MB: {other:?} {stderr}"),
        }
    }
    assert!(refused > 0 && done > 0, "{refused} refused, {done} done");
}

#[test]
fn threads_are_fewer_where_their_stacks_have_no_room() {
    let folder = Folder::slider_crank();
    let answer = Answer::of(folder.run_in_memory(1_000_000, "scene.json --threads 1000"));
    assert_eq!(answer.code, Some(0), "{answer:?}");
    says!(
        answer.stderr,
        "thread",
        " instead of 1000: the system allows no more"
    );
}
