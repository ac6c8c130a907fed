//! With the feature `slepc`: compiles `slepc/dcb-slepc-eigen.c`, the program that `reduce` starts under `mpirun`.

use std::path::PathBuf;
use std::process::{Command, ExitCode};

const SOURCE: &str = "slepc/dcb-slepc-eigen.c";
const NEEDED: &str = "the feature `slepc` needs SLEPc, PETSc with MUMPS, and an MPI compiler (Debian: libslepc-real-dev openmpi-bin pkg-config); PKG_CONFIG_PATH tells where SLEPc is, MPICC which compiler to use";

fn main() -> ExitCode {
    println!("cargo::rerun-if-changed=build.rs");
    if std::env::var_os("CARGO_FEATURE_SLEPC").is_none() {
        return ExitCode::SUCCESS;
    }
    println!("cargo::rerun-if-changed={SOURCE}");
    println!("cargo::rerun-if-env-changed=MPICC");
    println!("cargo::rerun-if-env-changed=PKG_CONFIG_PATH");
    match compile() {
        Ok(program) => {
            println!("cargo::rustc-env=DCB_SLEPC_EIGEN={}", program.display());
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
    let program = PathBuf::from(folder).join("dcb-slepc-eigen");
    let compiler = std::env::var("MPICC").unwrap_or_else(|_| "mpicc".into());
    let libraries = pkg_config("--libs")?;
    let mut command = Command::new(&compiler);
    command.arg("-O2").args(pkg_config("--cflags")?);
    command.arg(SOURCE).arg("-o").arg(&program).args(&libraries);
    // Libraries outside the system's folders are found without LD_LIBRARY_PATH.
    for folder in libraries.iter().filter_map(|word| word.strip_prefix("-L")) {
        command.arg(format!("-Wl,-rpath,{folder}"));
    }
    let status = command
        .status()
        .map_err(|error| format!("cannot run {compiler}: {error}"))?;
    match status.success() {
        true => Ok(program),
        false => Err(format!("{compiler} failed on {SOURCE}")),
    }
}

/// Words that pkg-config says about SLEPc, which includes PETSc.
fn pkg_config(what: &str) -> Result<Vec<String>, String> {
    for name in ["slepc", "SLEPc"] {
        let output = Command::new("pkg-config")
            .args([what, name])
            .output()
            .map_err(|error| format!("cannot run pkg-config: {error}"))?;
        if output.status.success() {
            let text = String::from_utf8_lossy(&output.stdout);
            return Ok(text.split_whitespace().map(str::to_owned).collect());
        }
    }
    Err("pkg-config knows no slepc".into())
}
