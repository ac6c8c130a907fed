//! With the feature `ranks`: compiles `mumps/dcb-mumps-factor.c`, the program that `reduce --ranks` starts under `mpirun`.

use std::path::PathBuf;
use std::process::{Command, ExitCode};

const SOURCE: &str = "mumps/dcb-mumps-factor.c";
const NEEDED: &str = "the feature `ranks` needs MUMPS for MPI and an MPI compiler (Debian: libmumps-dev libopenmpi-dev openmpi-bin); MUMPS_DIR tells where MUMPS is (include, lib), MUMPS_LIBS what to link, MPICC which compiler to use";

fn main() -> ExitCode {
    println!("cargo::rerun-if-changed=build.rs");
    if std::env::var_os("CARGO_FEATURE_RANKS").is_none() {
        return ExitCode::SUCCESS;
    }
    println!("cargo::rerun-if-changed={SOURCE}");
    for variable in ["MPICC", "MUMPS_DIR", "MUMPS_LIBS"] {
        println!("cargo::rerun-if-env-changed={variable}");
    }
    match compile() {
        Ok(program) => {
            println!("cargo::rustc-env=DCB_MUMPS_FACTOR={}", program.display());
            ExitCode::SUCCESS
        }
        Err(reason) => {
            println!("cargo::error={reason}; {NEEDED}");
            ExitCode::FAILURE
        }
    }
}

fn compile() -> Result<PathBuf, String> {
    let folder = std::env::var_os("OUT_DIR").ok_or("cargo gave no OUT_DIR")?;
    let program = PathBuf::from(folder).join("dcb-mumps-factor");
    let compiler = std::env::var("MPICC").unwrap_or_else(|_| "mpicc".into());
    let libraries = std::env::var("MUMPS_LIBS").unwrap_or_else(|_| "-ldmumps".into());
    let mut command = Command::new(&compiler);
    command.args(["-O2", "-std=c11", "-D_GNU_SOURCE", "-Wall", "-Wextra"]);
    command.arg(SOURCE).arg("-o").arg(&program);
    if let Ok(folder) = std::env::var("MUMPS_DIR") {
        command.arg(format!("-I{folder}/include"));
        command.arg(format!("-L{folder}/lib"));
        // Found without LD_LIBRARY_PATH.
        command.arg(format!("-Wl,-rpath,{folder}/lib"));
    }
    command.args(libraries.split_whitespace()).arg("-lpthread");
    let status = command
        .status()
        .map_err(|error| format!("cannot run {compiler}: {error}"))?;
    match status.success() {
        true => Ok(program),
        false => Err(format!("{compiler} failed on {SOURCE}")),
    }
}
