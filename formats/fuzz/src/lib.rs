//! Common to the fuzz targets: the readers take files.

use std::alloc::{GlobalAlloc, Layout, System};
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;
use std::sync::atomic::{AtomicUsize, Ordering};

use dcb_import::MatrixFile;
use dcb_import::dof_table;
use dcb_import::mesh::read_mesh;

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

/// The system's allocator, counted.
struct Counting;

static HELD: AtomicUsize = AtomicUsize::new(0);
static MOST: AtomicUsize = AtomicUsize::new(0);

// SAFETY: the system's own answers, with counters beside.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        let held = HELD.fetch_add(layout.size(), Ordering::Relaxed) + layout.size();
        MOST.fetch_max(held, Ordering::Relaxed);
        // SAFETY: passed on.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        HELD.fetch_sub(layout.size(), Ordering::Relaxed);
        // SAFETY: passed on.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Buffers that any file takes, whatever its length: those of the blocks of text and of the threads.
const BUFFERS: usize = 24 << 20;
/// Bytes that may be allocated for each byte of a file.
const BYTES_PER_BYTE: usize = 4;

/// One thread, this one: small inputs would spend most of their time in waking others.
static ALONE: LazyLock<()> = LazyLock::new(|| {
    let builder = rayon::ThreadPoolBuilder::new().num_threads(1);
    let built = builder.use_current_thread().build_global();
    built.unwrap_or_else(|error| panic!("{error}"));
});

/// Runs a reader, which may not allocate more than its file justifies.
fn within_memory(data: &[u8], read: impl FnOnce()) {
    LazyLock::force(&ALONE);
    let before = HELD.load(Ordering::Relaxed);
    MOST.store(before, Ordering::Relaxed);
    read();
    let taken = MOST.load(Ordering::Relaxed).saturating_sub(before);
    let allowed = BUFFERS + BYTES_PER_BYTE * data.len();
    assert!(taken <= allowed, "{taken} bytes for a file of {}", data.len());
}

/// Matrices that are read of one file.
const MOST_MATRICES: usize = 3;

/// Another program's matrices: recognised, listed, read.
pub fn matrices(data: &[u8]) {
    let path = file("matrix", data);
    within_memory(data, || match MatrixFile::recognised(&path) {
        Err(error) => refused(&error.to_string()),
        Ok(None) => {}
        Ok(Some(file)) => {
            for number in 0..file.listed().len().min(MOST_MATRICES) {
                if let Err(error) = file.read(&[number]) {
                    refused(&error.to_string());
                }
            }
        }
    });
}

/// Another program's mesh.
pub fn mesh(data: &[u8]) {
    let path = file("mesh", data);
    within_memory(data, || {
        if let Err(error) = read_mesh(&path) {
            refused(&error.to_string());
        }
    });
}

/// A table of dofs, for as many rows as it has lines, and for three a line.
pub fn table_of_dofs(data: &[u8]) {
    let path = file("table", data);
    let lines = data.iter().filter(|byte| **byte == b'\n').count();
    within_memory(data, || {
        for rows in [lines, 3 * lines] {
            if let Err(error) = dof_table::read(&path, None, rows) {
                refused(&error.to_string());
            }
        }
    });
}
