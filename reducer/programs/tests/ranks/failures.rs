//! Failures of MPI or SLEPc: one message, the right status, and nothing left behind.

use std::os::unix::fs::PermissionsExt;

use dcb_reducer::modes::slepc::SlepcRun;
use dcb_reducer::{EigenSolver, Reduction, reduce};

use crate::MPIRUN;
use crate::support::{Answer, Folder, answer, says};

/// Runs the rotor with this in place of `mpirun`.
fn with_mpirun(folder: &Folder, mpirun: &str) -> Answer {
    let scratch = folder.path("scratch");
    std::fs::create_dir_all(&scratch).unwrap();
    let mut command = folder.command("rotor.mtx --modes 12 --eigen-solver slepc --ranks 2");
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
    let find =
        "#!/bin/sh\nall=\"$*\"\nwhile [ \"$1\" != -dcb_folder ]; do shift; done\nfolder=$2\n";
    folder.write("mpi.sh", format!("{find}{does}\n"));
    let executable = std::fs::Permissions::from_mode(0o755);
    std::fs::set_permissions(folder.path("mpi.sh"), executable).unwrap();
    "./mpi.sh"
}

#[test]
fn options_that_do_not_go_together() {
    let folder = Folder::rotor();
    for (arguments, says) in [
        ("rotor.mtx --eigen-solver slepc", "--ranks"),
        ("rotor.mtx --ranks 2", "--eigen-solver slepc"),
        ("rotor.mtx --mpirun mpirun", "--eigen-solver slepc"),
        ("rotor.mtx --eigen-solver slepc --ranks 0", "--ranks"),
        ("rotor.mtx --eigen-solver arpack", "block-lanczos, slepc"),
        (
            "rotor.mtx --eigen-solver slepc --ranks 2 --mpirun '",
            "quote",
        ),
    ] {
        folder.refused(arguments, &[says]);
    }
}

#[test]
fn more_modes_than_krylov_schur_is_for() {
    let folder = Folder::rotor();
    let says = ["rotor.mtx: ", "208 eigenpairs", "of 339", "built-in"];
    folder.refused(
        "rotor.mtx --modes 200 --eigen-solver slepc --ranks 2",
        &says,
    );
}

#[test]
fn a_missing_mpirun() {
    let folder = Folder::rotor();
    let answer = with_mpirun(&folder, "no-such-mpirun --hostfile hosts");
    answer.is_error(2, &["cannot start no-such-mpirun", "docs/slepc.md"]);
}

#[test]
fn a_missing_program() {
    let component = dcb_samples::hard::square_block();
    let run = SlepcRun {
        program: "/no/such/dcb-slepc-eigen".into(),
        ..SlepcRun::with_ranks(2)
    };
    let options = Reduction {
        eigen_solver: EigenSolver::Slepc(run),
        ..Reduction::lowest(5)
    };
    let error = reduce(&component, &options, &mut ()).unwrap_err();
    assert!(error.is_unusable_input());
    says!(error.to_string(), "/no/such/dcb-slepc-eigen");
}

#[test]
fn an_mpirun_that_fails() {
    let folder = Folder::rotor();
    let mpirun = script(&folder, "echo 'not enough slots available' >&2; exit 7");
    with_mpirun(&folder, mpirun).is_error(1, &["status: 7", "not enough slots available"]);
    let real = format!("{MPIRUN} --hostfile no-such-hosts");
    with_mpirun(&folder, &real).is_error(1, &["no-such-hosts"]);
}

/// PETSc's own words are repeated, without its description of the installation.
#[test]
fn a_rank_that_fails() {
    let folder = Folder::rotor();
    let does = format!("echo garbage > \"$folder/mass\"; exec {MPIRUN} $all");
    let failed = with_mpirun(&folder, script(&folder, &does));
    // PETSc's own words, of whichever rank speaks first: "Read past end of file" or "Read from file failed".
    let says = ["slepc: `./mpi.sh -n 2", "ended with", "Read "];
    failed.is_error(1, &says);
    assert!(!failed.stderr.contains("Configure options"), "{failed:?}");
}

#[test]
fn an_answer_that_is_missing_or_damaged() {
    let folder = Folder::rotor();
    for (does, says) in [
        ("true", "`eigenvalues`"),
        ("echo 1 > \"$folder/eigenvalues\"", "`eigenvalues`"),
        (
            "head -c 4000 /dev/zero > \"$folder/eigenvalues\"",
            "`eigenvalues`",
        ),
        (
            // 1 value 1.0, 1 value 1.0; no shapes.
            "v='\\000\\022\\173\\116\\000\\000\\000\\001\\077\\360\\000\\000\\000\\000\\000\\000'; printf \"$v$v\" > \"$folder/eigenvalues\"",
            "`shapes`",
        ),
    ] {
        let mpirun = script(&folder, does);
        with_mpirun(&folder, mpirun).is_error(1, &["left no usable file", says]);
    }
}

/// Fewer pairs than asked for are not taken for all there are.
#[test]
fn a_search_that_stops_early() {
    let folder = Folder::rotor();
    let mut command = folder.command("rotor.mtx --modes 12 --eigen-solver slepc --ranks 2");
    command
        .args(["--mpirun", MPIRUN])
        .env("PETSC_OPTIONS", "-eps_max_it 1 -eps_tol 1e-30");
    answer(&mut command).is_error(1, &["of 20 pairs converged", "ask for fewer modes"]);
    assert!(!folder.path("rotor.dcb.h5").exists());
}
