//! `simulate prepare` is asked to end while it waits for a reduction.
#![cfg(unix)]

use std::os::unix::fs::PermissionsExt;
use std::process::Child;
use std::time::{Duration, Instant};

use crate::support::{Folder, send, stopped};

/// Stands for `reduce`: says that it runs, and does what is given when SIGTERM comes, which it has inherited as blocked.
fn waiting(then: &str) -> String {
    format!(
        "#!/usr/bin/env python3\nimport pathlib, signal, sys, time\nsignal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGTERM])\npathlib.Path('began').touch()\nsignal.sigwait([signal.SIGTERM])\n{then}\n"
    )
}

fn started(then: &str) -> (Folder, Child) {
    let folder = Folder::slider_crank();
    folder.write("rod.mtx", "isn't read");
    folder.write("reduce.py", waiting(then));
    let program = folder.path("reduce.py");
    std::fs::set_permissions(&program, std::fs::Permissions::from_mode(0o755)).unwrap();
    let child = folder.start("prepare scene.json --reduce ./reduce.py");
    wait_for(&folder, "began");
    (folder, child)
}

fn wait_for(folder: &Folder, name: &str) {
    let since = Instant::now();
    while !folder.path(name).exists() {
        assert!(since.elapsed() < Duration::from_secs(20), "no {name}");
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// A batch system sends SIGTERM to the program alone.
#[test]
fn the_reduction_is_told_and_waited_for() {
    let (folder, child) =
        started("time.sleep(0.3); pathlib.Path('cleaned').touch(); sys.exit(143)");
    assert_eq!(stopped("TERM", child).code, Some(143));
    assert!(folder.path("cleaned").exists());
    assert!(!folder.path("scene.prepared/scene.json").exists());
}

/// One that doesn't end doesn't hold the program either.
#[test]
fn a_second_signal_ends_the_program_at_once() {
    let (folder, mut child) = started("pathlib.Path('told').touch(); time.sleep(30)");
    send("TERM", &child);
    wait_for(&folder, "told");
    let since = Instant::now();
    send("TERM", &child);
    assert_eq!(child.wait().unwrap().code(), Some(143));
    assert!(since.elapsed() < Duration::from_secs(10));
}
