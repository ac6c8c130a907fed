//! h5py alone reads every dataset and recomputes every hash, by a program that shares nothing with this one.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod support;

use std::path::{Path, PathBuf};
use std::process::Command;

use dcb_formats::dcb::{Compression, Contents, WriteOptions, write_superelement};
use dcb_formats::mesh::Dimension::{Planar, Spatial};

fn check(file: &Path) -> Result<(), String> {
    run(
        &Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/h5py/check_superelement.py"),
        file,
    )
}

fn run(script: &Path, file: &Path) -> Result<(), String> {
    let python = std::env::var_os("PYTHON").map_or_else(|| PathBuf::from("python3"), PathBuf::from);
    let has_h5py = Command::new(&python)
        .args(["-c", "import h5py, numpy"])
        .output()
        .is_ok_and(|output| output.status.success());
    assert!(
        has_h5py,
        "{} with h5py and numpy is needed for this test: run .ci/setup",
        python.display()
    );
    // Another test's child process may have inherited HDF5's lock on the file.
    let output = Command::new(&python)
        .env("HDF5_USE_FILE_LOCKING", "FALSE")
        .arg(script)
        .arg(file)
        .output()
        .unwrap();
    if output.status.success() {
        Ok(())
    } else {
        Err(String::from_utf8_lossy(&output.stderr).into_owned())
    }
}

#[test]
fn h5py_reads_every_dataset_and_recomputes_every_digest() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("rod.dcb.h5");
    for dimension in [Planar, Spatial] {
        for compression in [Compression::None, Compression::Deflate] {
            let _ = std::fs::remove_file(&path);
            let superelement = support::enriched(dimension);
            let (recovery, mesh) = (support::recovery(&superelement), support::mesh(dimension));
            let contents = Contents {
                superelement: &superelement,
                recovery: Some(&recovery),
                mesh: Some(&mesh),
            };
            write_superelement(
                &path,
                &contents,
                &WriteOptions {
                    compression,
                    ..WriteOptions::default()
                },
            )
            .unwrap();
            check(&path).unwrap();
        }
        let _ = std::fs::remove_file(&path);
        let superelement = support::superelement(dimension);
        let contents = Contents {
            superelement: &superelement,
            recovery: None,
            mesh: None,
        };
        write_superelement(&path, &contents, &WriteOptions::default()).unwrap();
        check(&path).unwrap();
    }
}

/// The program that the format's documentation gives its readers.
#[test]
fn the_documented_program_verifies_a_file() {
    let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/format.md");
    let docs = std::fs::read_to_string(docs).unwrap();
    let (_, program) = docs.split_once("```python\n").unwrap();
    let (program, _) = program.split_once("```").unwrap();
    let folder = tempfile::tempdir().unwrap();
    let (script, path) = (
        folder.path().join("verify.py"),
        folder.path().join("rod.dcb.h5"),
    );
    std::fs::write(&script, program).unwrap();
    let superelement = support::enriched(Spatial);
    let mesh = support::mesh(Spatial);
    let contents = Contents {
        superelement: &superelement,
        recovery: None,
        mesh: Some(&mesh),
    };
    write_superelement(&path, &contents, &WriteOptions::default()).unwrap();
    run(&script, &path).unwrap();
}

#[test]
fn h5py_sees_a_changed_number() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("rod.dcb.h5");
    let superelement = support::superelement(Planar);
    write_superelement(
        &path,
        &Contents {
            superelement: &superelement,
            recovery: None,
            mesh: None,
        },
        &WriteOptions::default(),
    )
    .unwrap();
    let mut bytes = std::fs::read(&path).unwrap();
    let mass = superelement.inertia.mass.to_le_bytes();
    let at = bytes.windows(8).position(|window| window == mass).unwrap();
    bytes[at] ^= 1;
    std::fs::write(&path, bytes).unwrap();
    let findings = check(&path).unwrap_err();
    assert!(
        findings.contains("/inertia/mass: sha256 differs"),
        "{findings}"
    );
}
