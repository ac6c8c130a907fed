//! Python with h5py, numpy and meshio: programs that share nothing with this one.

use std::ffi::OsStr;
use std::path::Path;
use std::process::Command;

/// Runs a Python script of `tests/h5py`, or one with a full path.
pub fn run(script: impl AsRef<Path>, arguments: &[&OsStr]) -> Result<(), String> {
    let python = std::env::var_os("PYTHON").unwrap_or_else(|| "python3".into());
    let has_h5py = Command::new(&python)
        .args(["-c", "import h5py, numpy"])
        .output()
        .is_ok_and(|output| output.status.success());
    assert!(
        has_h5py,
        "{python:?} with h5py and numpy is needed for this test: run .ci/setup"
    );
    // Another test's child process may have inherited HDF5's lock on the file.
    let output = Command::new(&python)
        .env("HDF5_USE_FILE_LOCKING", "FALSE")
        .env("PYTHONDONTWRITEBYTECODE", "1")
        .arg(
            Path::new(env!("CARGO_MANIFEST_DIR"))
                .join("h5py")
                .join(script),
        )
        .args(arguments)
        .output()
        .map_err(|error| error.to_string())?;
    if output.status.success() {
        Ok(())
    } else {
        Err(String::from_utf8_lossy(&output.stderr).into_owned())
    }
}

/// Lets h5py copy a file into another HDF5 layout: see `tests/h5py/recreate.py`.
pub fn recreate(file: &Path, copy: &Path, variant: &str) -> Result<(), String> {
    let arguments = [file.as_os_str(), copy.as_os_str(), OsStr::new(variant)];
    run("recreate.py", &arguments)
}
