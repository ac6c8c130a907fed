//! Python with h5py, numpy, meshio, xarray, h5netcdf, pyuff and SciPy: programs that share nothing with this one.

use std::ffi::OsStr;
use std::path::Path;
use std::process::Command;

use serde_json::Value;

/// What a script of `tests/h5py` prints, or one with a full path.
///
/// # Errors
/// The script fails: what it says then.
///
/// # Panics
/// Python or one of its packages is missing.
pub fn run(script: impl AsRef<Path>, arguments: &[&OsStr]) -> Result<String, String> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("h5py");
    printed(python().arg(folder.join(script)).args(arguments))
}

/// What a program prints.
///
/// # Errors
/// The program fails: what it says then.
///
/// # Panics
/// Python or one of its packages is missing.
pub fn run_text(program: &str, arguments: &[&OsStr]) -> Result<String, String> {
    printed(python().args(["-c", program]).args(arguments))
}

/// The JSON that a program prints about a file.
///
/// # Panics
/// The program fails, or prints something else.
pub fn answer(program: &str, file: &Path) -> Value {
    let printed = run_text(program, &[file.as_os_str()]);
    serde_json::from_str(&printed.expect("an answer")).expect("JSON")
}

/// Lets h5py copy a file into another HDF5 layout: see `tests/h5py/recreate.py`.
///
/// # Errors
/// As [`run`].
///
/// # Panics
/// As [`run`].
pub fn recreate(file: &Path, copy: &Path, variant: &str) -> Result<String, String> {
    let arguments = [file.as_os_str(), copy.as_os_str(), OsStr::new(variant)];
    run("recreate.py", &arguments)
}

fn python() -> Command {
    let python = std::env::var_os("PYTHON").unwrap_or_else(|| "python3".into());
    let is_complete = Command::new(&python)
        .args([
            "-c",
            "import h5py, numpy, meshio, xarray, h5netcdf, pyuff, scipy",
        ])
        .output()
        .is_ok_and(|output| output.status.success());
    assert!(
        is_complete,
        "{python:?} with h5py, numpy, meshio, xarray, h5netcdf, pyuff and scipy is needed for this test: run .ci/setup"
    );
    let mut command = Command::new(python);
    // Another test's process may have inherited HDF5's lock on the file.
    command
        .env("HDF5_USE_FILE_LOCKING", "FALSE")
        .env("PYTHONDONTWRITEBYTECODE", "1");
    command
}

fn printed(command: &mut Command) -> Result<String, String> {
    let output = command.output().map_err(|error| error.to_string())?;
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    if output.status.success() {
        Ok(text(&output.stdout))
    } else {
        Err(text(&output.stderr))
    }
}
