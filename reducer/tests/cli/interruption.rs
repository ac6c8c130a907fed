//! Ctrl-C.

use std::process::{Child, Command, Stdio};
use std::time::Duration;

use crate::support::{Folder, answer};

/// At several moments of a reduction that takes seconds.
#[test]
fn an_interrupted_reduction_leaves_nothing() {
    let folder = Folder::with(&dcb_samples::connecting_rod(1));
    let interrupted = [200, 500, 1000].map(|milliseconds| {
        interrupted(&folder, |_| {
            std::thread::sleep(Duration::from_millis(milliseconds))
        })
    });
    assert!(
        interrupted.contains(&true),
        "all of it is done within 200 ms"
    );
}

/// When there is an unfinished file to remove.
#[test]
fn a_reduction_interrupted_while_writing_leaves_nothing() {
    let folder = Folder::with(&dcb_samples::connecting_rod(0));
    for _ in 0..5 {
        interrupted(&folder, |running| {
            let unfinished = folder.path(&format!(".part.dcb.h5.{}.partial", running.id()));
            while !unfinished.exists() && running.try_wait().unwrap().is_none() {
                std::hint::spin_loop();
            }
        });
    }
}

/// Runs a reduction, interrupts it at a moment, and says whether that came in time. Either nothing is left or all is done.
fn interrupted(folder: &Folder, moment: impl FnOnce(&mut Child)) -> bool {
    let before = folder.names();
    let mut command = folder.command("part.mtx --modes 20");
    let mut child = command
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    moment(&mut child);
    let _ = Command::new("kill")
        .args(["-INT", &child.id().to_string()])
        .status();
    let output = child.wait_with_output().unwrap();
    let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
    if folder.path("part.dcb.h5").exists() {
        folder.done("verify part.dcb.h5");
        folder.remove("part.dcb.h5");
    } else {
        assert_eq!(
            (output.status.code(), stderr.as_str()),
            (Some(130), "interrupted: nothing was written\n")
        );
    }
    assert_eq!(folder.names(), before, "{output:?}");
    output.status.code() == Some(130)
}

/// A file that a killed run left behind is in nobody's way.
#[test]
fn a_stale_unfinished_file_is_no_obstacle() {
    let folder = Folder::rotor();
    folder.write(".rotor.dcb.h5.1.partial", "left by a killed run");
    let answer = answer(&mut folder.command("rotor.mtx"));
    assert_eq!(answer.code, Some(0), "{answer:?}");
}
