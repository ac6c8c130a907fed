//! Ctrl-C, and the end without a word, while MPI runs.

use std::time::Duration;

use crate::MPIRUN;
use crate::processes::{processes, ranks_in, waited_for};
use crate::support::{Answer, Folder, send, start, stopped};

/// At several moments after the ranks have begun: they end, and no file of theirs is left.
#[test]
fn an_interruption_ends_the_ranks() {
    let folder = Folder::with(&dcb_samples::connecting_rod(0));
    let scratch = folder.path("scratch");
    std::fs::create_dir(&scratch).unwrap();
    let before = folder.names();
    for milliseconds in [0, 100, 400] {
        let mut command = folder.command("part.mtx --modes 300 --ranks 2");
        let command = command.args(["--mpirun", MPIRUN]).env("TMPDIR", &scratch);
        let child = start(command);
        assert!(waited_for(|| !ranks_in(&scratch).is_empty()));
        std::thread::sleep(Duration::from_millis(milliseconds));
        let answer = stopped("INT", child);
        assert_eq!(answer.code, Some(130));
        assert_eq!(answer.stderr, "interrupted: nothing was written\n");
        assert!(
            waited_for(|| processes(&scratch).is_empty()),
            "{:?}",
            processes(&scratch)
        );
        assert_eq!(folder.names(), before);
    }
}

/// An `mpirun` that does not listen is killed, with what it started.
#[test]
fn a_deaf_mpirun_is_killed() {
    let folder = Folder::rotor();
    let scratch = folder.path("scratch");
    std::fs::create_dir(&scratch).unwrap();
    let mut command = folder.command("rotor.mtx --modes 12 --ranks 2");
    let deaf = "sh -c 'trap \"\" TERM; while :; do sleep 1; done'";
    let child = start(command.args(["--mpirun", deaf]).env("TMPDIR", &scratch));
    assert!(waited_for(|| processes(&scratch)
        .iter()
        .any(|line| line.starts_with("sh "))));
    assert_eq!(stopped("INT", child).code, Some(130));
    assert!(waited_for(|| processes(&scratch).is_empty()));
    assert_eq!(std::fs::read_dir(&scratch).unwrap().count(), 0);
}

/// Killed at several moments, `reduce` says nothing to its ranks: they end by the end of their input, and remove their files.
#[test]
fn ranks_end_with_a_reduction_that_is_killed() {
    let folder = Folder::with(&dcb_samples::connecting_rod(0));
    let scratch = folder.path("scratch");
    std::fs::create_dir(&scratch).unwrap();
    for milliseconds in [0, 300, 1500] {
        let mut command = folder.command("part.mtx --modes 300 --ranks 2");
        let child = start(command.args(["--mpirun", MPIRUN]).env("TMPDIR", &scratch));
        assert!(waited_for(|| ranks_in(&scratch).len() == 2));
        std::thread::sleep(Duration::from_millis(milliseconds));
        send("KILL", &child);
        assert_eq!(Answer::at_end(child).code, None);
        assert!(
            waited_for(|| processes(&scratch).is_empty()),
            "{:?}",
            processes(&scratch)
        );
        assert_eq!(std::fs::read_dir(&scratch).unwrap().count(), 0);
    }
}
