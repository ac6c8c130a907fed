//! Common to the fuzz targets: the readers take files.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;

use tempfile::TempDir;

/// In memory where the system has a place for that.
static FOLDER: LazyLock<TempDir> = LazyLock::new(|| {
    let memory = Path::new("/dev/shm");
    let folder = match memory.is_dir() {
        true => tempfile::tempdir_in(memory),
        false => tempfile::tempdir(),
    };
    folder.unwrap_or_else(|error| panic!("no folder for the inputs: {error}"))
});

/// The path of a file with these bytes.
pub fn file(name: &str, bytes: &[u8]) -> PathBuf {
    let path = FOLDER.path().join(name);
    fs::write(&path, bytes).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    path
}

/// Shows a refusal as a program would: the message must be short and can't command a terminal.
pub fn refused(message: &str) {
    let shown = dcb_formats::terminal::for_terminal(message);
    assert!(
        !shown.contains(|c: char| c.is_control() && c != '\n' && c != '\t'),
        "{shown:?}"
    );
    assert!(shown.len() < 1 << 15, "a message of {} bytes", shown.len());
}
