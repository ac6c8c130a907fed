//! Failures of MPI or of ranks: one message, the right status, and nothing left behind.

use std::os::unix::fs::PermissionsExt;

use dcb_reducer::resources::memory_limit::MemoryLimit;
use dcb_reducer::{Reduction, reduce};
use dcb_sparse::ranks::RanksRun;

use crate::MPIRUN;
use crate::processes::{ranks_in, waited_for};
use crate::support::{Answer, Folder, answer, says, start};

/// Runs the rotor with this in place of `mpirun`.
fn with_mpirun(folder: &Folder, mpirun: &str) -> Answer {
    let scratch = folder.path("scratch");
    std::fs::create_dir_all(&scratch).unwrap();
    let mut command = folder.command("rotor.mtx --modes 12 --ranks 2");
    let answer = answer(command.args(["--mpirun", mpirun]).env("TMPDIR", &scratch));
    assert_eq!(
        std::fs::read_dir(&scratch).unwrap().count(),
        0,
        "{answer:?}"
    );
    assert!(!folder.path("rotor.dcb.h5").exists());
    answer
}

/// A script in place of `mpirun` that finds its arguments in `$all` and the private folder in `$folder`.
fn script(folder: &Folder, does: &str) -> &'static str {
    let find = "#!/bin/sh\nall=\"$*\"\nfor folder; do :; done\n";
    folder.write("mpi.sh", format!("{find}{does}\n"));
    let executable = std::fs::Permissions::from_mode(0o755);
    std::fs::set_permissions(folder.path("mpi.sh"), executable).unwrap();
    "./mpi.sh"
}

#[test]
fn options_that_do_not_go_together() {
    let folder = Folder::rotor();
    for (arguments, says) in [
        ("rotor.mtx --mpirun mpirun", "--ranks"),
        ("rotor.mtx --ranks 0", "--ranks"),
        ("rotor.mtx --ranks 2 --factor disk", "--factor"),
        ("rotor.mtx --ranks 2 --mpirun '", "quote"),
        ("plan rotor.mtx --ranks 2 --factor single", "--factor"),
    ] {
        folder.refused(arguments, &[says]);
    }
}

#[test]
fn a_missing_mpirun() {
    let folder = Folder::rotor();
    let answer = with_mpirun(&folder, "no-such-mpirun --hostfile hosts");
    answer.is_error(2, &["cannot start no-such-mpirun", "docs/ranks.md"]);
}

#[test]
fn a_missing_program() {
    let component = dcb_samples::hard::square_block();
    let run = RanksRun {
        program: "/no/such/dcb-mumps-factor".into(),
        ..RanksRun::with_ranks(2)
    };
    let memory = MemoryLimit {
        ranks: Some(run),
        ..MemoryLimit::default()
    };
    let options = Reduction {
        memory,
        ..Reduction::lowest(5)
    };
    let error = reduce(&component, &options, &mut ()).unwrap_err();
    assert!(error.is_unusable_input());
    says!(error.to_string(), "/no/such/dcb-mumps-factor");
}

#[test]
fn an_mpirun_that_fails() {
    let folder = Folder::rotor();
    let mpirun = script(&folder, "echo 'not enough slots available' >&2; exit 7");
    with_mpirun(&folder, mpirun).is_error(1, &["status: 7", "not enough slots available"]);
    let real = format!("{MPIRUN} --hostfile no-such-hosts");
    with_mpirun(&folder, &real).is_error(1, &["no-such-hosts"]);
}

/// Each process takes itself for the only one.
#[test]
fn an_mpirun_of_another_mpi() {
    let folder = Folder::rotor();
    let mpirun = script(&folder, "echo 'dcb ready 1'; cat > /dev/null");
    with_mpirun(&folder, mpirun).is_error(1, &["2 processes were started that know of 1"]);
}

#[test]
fn a_rank_that_fails() {
    let folder = Folder::rotor();
    // The folder is named to the ranks, and is none.
    let does = format!("exec {MPIRUN} ${{all%\"$folder\"}} \"$folder/none\"");
    let failed = with_mpirun(&folder, script(&folder, &does));
    failed.is_error(1, &["ranks: cannot open", "none/matrix"]);
}

#[test]
fn replies_that_make_no_sense() {
    let folder = Folder::rotor();
    for (does, says) in [
        ("echo dcb hello", "answered \"hello\""),
        (
            "echo dcb ready 2; read line; echo dcb ready 2",
            "answered \"ready 2\"",
        ),
        (
            "echo dcb ready 2; read line; echo dcb counted x 0",
            "answered \"counted x 0\"",
        ),
        (
            "echo dcb ready 2; read line; echo dcb failed MUMPS: too small",
            "ranks: MUMPS: too small",
        ),
        (
            "echo dcb ready 2; read line; exit 0",
            "ended with exit status: 0",
        ),
    ] {
        let mpirun = script(&folder, does);
        with_mpirun(&folder, mpirun).is_error(1, &[says]);
    }
}

/// Killed from outside, as by a system without memory: all others end, and one message says so.
#[test]
fn a_rank_that_is_killed() {
    let folder = Folder::with(&dcb_samples::connecting_rod(0));
    let scratch = folder.path("scratch");
    std::fs::create_dir(&scratch).unwrap();
    for victim in [0, 1] {
        let mut command = folder.command("part.mtx --modes 300 --ranks 2");
        let command = command.args(["--mpirun", MPIRUN]).env("TMPDIR", &scratch);
        let child = start(command);
        assert!(waited_for(|| ranks_in(&scratch).len() == 2));
        std::thread::sleep(std::time::Duration::from_millis(500));
        let ranks = ranks_in(&scratch);
        let process = ranks[victim].to_string();
        let killed = std::process::Command::new("kill")
            .args(["-9", &process])
            .status();
        assert!(killed.unwrap().success());
        let answer = Answer::at_end(child);
        answer.is_error(1, &["ranks: `mpirun ", "signal 9"]);
        assert!(waited_for(|| ranks_in(&scratch).is_empty()));
        assert_eq!(std::fs::read_dir(&scratch).unwrap().count(), 0);
        assert!(!folder.path("part.dcb.h5").exists());
    }
}

/// Refused as with a factor in this process, but for the places.
#[test]
fn an_indefinite_stiffness_is_refused() {
    let component = dcb_samples::connecting_rod(0);
    let rows = component.stiffness.row_idx_of_col_raw(0);
    let diagonal = rows.iter().position(|row| *row == 0).unwrap();
    let indefinite = component
        .changed(|draft| draft.stiffness.val_mut()[diagonal] *= 1e-3)
        .unwrap();
    let folder = Folder::with(&indefinite);
    let says = ["negative pivot(s), at "];
    folder.failed(2, "part.mtx --modes 5", &says);
    let mut command = folder.command("part.mtx --modes 5 --ranks 2");
    let answer = answer(command.args(["--mpirun", MPIRUN]));
    answer.is_error(2, &[says[0], "without --ranks"]);
}
