//! Every output goes through one writer, which is whole or nothing: nothing else in the sources makes or renames files.

use std::fs;

use super::{crates, program, root, sources};

/// What makes, replaces or changes a file.
const WRITING: [&str; 14] = [
    "File::create",
    "fs::write",
    "fs::copy",
    "fs::rename",
    "OpenOptions",
    "File::options",
    "with_options",
    "Writer::from_path",
    "BufWriter::new(File",
    "NamedTempFile",
    ".persist(",
    ".persist_noclobber(",
    "tempfile_in",
    "process::id",
];

/// Who may, and why.
const ALLOWED: [(&str, &str); 8] = [
    ("formats/src/output/whole_file.rs", "is the writer"),
    (
        "formats/src/hdf5_files/create.rs",
        "HDF5 into an unfinished file",
    ),
    (
        "formats/src/results/reserve.rs",
        "room behind an open results file",
    ),
    (
        "formats/report/src/shared_lines.rs",
        "adds lines to a file under its lock, and takes half ones back",
    ),
    ("reducer/workflow/src/lock_file.rs", "locks"),
    (
        "reducer/workflow/src/cache/claim.rs",
        "notes the time of use",
    ),
    ("reducer/sparse/src/factor_store.rs", "a file without name"),
    ("python/src/threads.rs", "knows a fork by its number"),
];

/// What is exchanged with MPI processes, in a folder of its own.
const EXCHANGE: &str = "reducer/sparse/src/ranks/mod.rs";

#[test]
fn nothing_else_writes_files() {
    let root = root();
    let mut found = Vec::new();
    let mut used = Vec::new();
    for crate_name in crates() {
        for path in sources(&root.join(&crate_name).join("src")) {
            let name = path
                .strip_prefix(&root)
                .unwrap()
                .to_str()
                .unwrap()
                .to_owned();
            let is_allowed =
                name == EXCHANGE || ALLOWED.iter().any(|(allowed, _)| *allowed == name);
            for (number, line) in program(&fs::read_to_string(&path).unwrap()) {
                let writes = WRITING.iter().any(|word| line.contains(word));
                if writes && !is_allowed {
                    found.push(format!("{name}:{number}: {}", line.trim()));
                } else if writes {
                    used.push(name.clone());
                }
            }
        }
    }
    assert!(
        found.is_empty(),
        "write through output::write_stream, write_text or write_superelement:\n{}",
        found.join("\n")
    );
    for (allowed, why) in ALLOWED {
        assert!(
            used.iter().any(|name| name == allowed),
            "{allowed} ({why}) writes nothing"
        );
    }
}
