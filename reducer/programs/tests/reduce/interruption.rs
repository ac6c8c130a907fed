//! Ctrl-C and other signals, and what killed runs leave.

use std::process::Child;
use std::time::Duration;

use crate::support::{Answer, Folder, stopped};

/// At several moments of a reduction that takes seconds.
#[test]
fn an_interrupted_reduction_leaves_nothing() {
    let folder = Folder::with(&dcb_samples::connecting_rod(1));
    let wait = |milliseconds| std::thread::sleep(Duration::from_millis(milliseconds));
    let interrupted = [200, 500, 1000].map(|time| interrupted(&folder, |_| wait(time)));
    assert!(
        interrupted.contains(&true),
        "all of it is done within 200 ms"
    );
}

/// Batch systems and containers send SIGTERM, a terminal that is closed SIGHUP.
#[test]
fn a_reduction_that_is_asked_to_end_leaves_nothing() {
    let folder = Folder::with(&dcb_samples::connecting_rod(1));
    let before = folder.names();
    // So many modes take seconds, also on a fast machine that has nothing else to do.
    for (signal, status, word) in [
        ("TERM", 143, "terminated (SIGTERM)"),
        ("HUP", 129, "hung up (SIGHUP)"),
    ] {
        if signal == "HUP" && ignores_hang_ups() {
            continue;
        }
        let mut came_in_time = false;
        for milliseconds in [50, 100, 150, 200, 300, 400, 500, 1000] {
            let child = folder.start("part.mtx --modes 150 --force");
            std::thread::sleep(Duration::from_millis(milliseconds));
            let Answer { code, stderr, .. } = stopped(signal, child);
            if code == Some(status) {
                came_in_time = true;
                // Nothing is said of what hadn't begun.
                let told = format!("{word}: nothing was written\n");
                assert!(stderr.is_empty() || stderr == told, "{stderr}");
                assert_eq!(folder.names(), before);
            } else {
                assert_eq!(code, Some(0), "{stderr}");
                folder.remove("part.dcb.h5");
            }
        }
        assert!(came_in_time, "all of it was done before the signal came");
    }
}

/// Whether these tests run under `nohup`, or the like: what they start ignores hang-ups then, as it should.
fn ignores_hang_ups() -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let ignored = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let ignored = ignored.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok());
    // SIGHUP is number 1.
    ignored.is_some_and(|mask| mask & 1 == 1)
}

/// When there is an unfinished file to remove.
#[test]
fn a_reduction_interrupted_while_writing_leaves_nothing() {
    let folder = Folder::with(&dcb_samples::connecting_rod(0));
    for _ in 0..5 {
        interrupted(&folder, |running| wait_for_writing(&folder, running));
    }
}

fn wait_for_writing(folder: &Folder, running: &mut Child) {
    while !is_writing(folder) && running.try_wait().unwrap().is_none() {
        std::hint::spin_loop();
    }
}

/// Whether there is an unfinished `part.dcb.h5`.
fn is_writing(folder: &Folder) -> bool {
    let entries = std::fs::read_dir(folder.path(".")).unwrap();
    let mut folders = entries.flatten().map(|entry| entry.path());
    folders.any(|path| {
        path.to_string_lossy().ends_with(".partial") && path.join("part.dcb.h5").exists()
    })
}

/// Runs a reduction, interrupts it at a moment, and says whether that came in time. Either nothing is left or all is done.
fn interrupted(folder: &Folder, moment: impl FnOnce(&mut Child)) -> bool {
    let before = folder.names();
    let mut child = folder.start("part.mtx --modes 20");
    moment(&mut child);
    let Answer { code, stderr, .. } = stopped("INT", child);
    if folder.path("part.dcb.h5").exists() {
        folder.done("verify part.dcb.h5");
        folder.remove("part.dcb.h5");
    } else {
        let told = "interrupted: nothing was written\n";
        assert_eq!((code, stderr.as_str()), (Some(130), told));
    }
    assert_eq!(folder.names(), before, "{stderr}");
    code == Some(130)
}

/// Files of a killed run are removed by the next one that writes this file, and by no other.
#[test]
fn leftovers_of_killed_runs_are_removed() {
    let folder = Folder::with(&dcb_samples::connecting_rod(0));
    let before = folder.names();
    let mut killed = 0;
    for _ in 0..20 {
        let mut running = folder.start("part.mtx --modes 20");
        wait_for_writing(&folder, &mut running);
        running.kill().unwrap();
        running.wait().unwrap();
        match folder.path("part.dcb.h5").exists() {
            true => folder.remove("part.dcb.h5"),
            false => killed += usize::from(is_writing(&folder)),
        }
    }
    assert!(killed > 0, "none was killed while it wrote");
    folder.write(".part.dcb.h5.1.partial", "left by an older version");
    folder.write(".other.dcb.h5.1.partial", "another's");
    folder.done("part.mtx --modes 20");
    folder.done("verify part.dcb.h5");
    folder.remove("part.dcb.h5");
    folder.remove(".other.dcb.h5.1.partial");
    assert_eq!(folder.names(), before);
}

/// Neither removes what the other one writes.
#[test]
fn two_reductions_of_one_part_at_a_time_end_well() {
    let folder = Folder::with(&dcb_samples::connecting_rod(0));
    let before = folder.names();
    for (options, refused) in [("", 1), ("--force", 0)] {
        for _ in 0..4 {
            let start = || folder.start(&format!("part.mtx --modes 20 {options}"));
            let both = [start(), start()].map(Answer::at_end);
            let ends = both.each_ref().map(|answer| answer.code);
            let failed = ends.iter().filter(|code| **code == Some(2)).count();
            assert!(failed == refused && ends.contains(&Some(0)), "{both:?}");
            folder.done("verify part.dcb.h5");
            folder.remove("part.dcb.h5");
            assert_eq!(folder.names(), before);
        }
    }
}
