//! Ctrl-C while MPI runs.

use std::path::Path;
use std::time::{Duration, Instant};

use crate::MPIRUN;
use crate::support::{Folder, start, stopped};

/// Command lines of processes that name this folder.
fn processes(folder: &Path) -> Vec<String> {
    let name = folder.to_str().unwrap();
    let lines = std::fs::read_dir("/proc").unwrap().filter_map(|entry| {
        let line = std::fs::read(entry.ok()?.path().join("cmdline")).ok()?;
        Some(String::from_utf8_lossy(&line).replace('\0', " "))
    });
    lines.filter(|line| line.contains(name)).collect()
}

fn waited_for(mut what: impl FnMut() -> bool) -> bool {
    let start = Instant::now();
    while !what() {
        if start.elapsed() > Duration::from_secs(60) {
            return false;
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    true
}

/// At several moments after the ranks have begun: they end, and no file of theirs is left.
#[test]
fn an_interruption_ends_the_ranks() {
    let folder = Folder::with(&dcb_samples::connecting_rod(0));
    let scratch = folder.path("scratch");
    std::fs::create_dir(&scratch).unwrap();
    let before = folder.names();
    for milliseconds in [0, 100, 400] {
        let mut command = folder.command("part.mtx --modes 300 --eigen-solver slepc --ranks 2");
        let command = command.args(["--mpirun", MPIRUN]).env("TMPDIR", &scratch);
        let child = start(command);
        let started = || {
            processes(&scratch)
                .iter()
                .any(|line| !line.starts_with("mpirun"))
        };
        assert!(waited_for(started));
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
    let mut command = folder.command("rotor.mtx --modes 12 --eigen-solver slepc --ranks 2");
    let deaf = "sh -c 'trap \"\" TERM; while :; do sleep 1; done'";
    let child = start(command.args(["--mpirun", deaf]).env("TMPDIR", &scratch));
    assert!(waited_for(|| processes(&scratch)
        .iter()
        .any(|line| line.starts_with("sh "))));
    assert_eq!(stopped("INT", child).code, Some(130));
    assert!(waited_for(|| processes(&scratch).is_empty()));
    assert_eq!(std::fs::read_dir(&scratch).unwrap().count(), 0);
}
