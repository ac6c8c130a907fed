//! h5py alone reads every dataset and recomputes every hash, by a program that shares nothing with this one.

use std::path::Path;

use dcb_formats::dcb::{
    Compression, Contents, FormatVersion, SuperelementFile, WriteOptions, write_superelement,
};
use dcb_formats::mesh::Dimension::{Planar, Spatial};
use dcb_tests::{python, synthetic};

fn check(file: &Path) -> Result<(), String> {
    python::run("check_superelement.py", &[file.as_os_str()]).map(drop)
}

#[test]
fn h5py_reads_every_dataset_and_recomputes_every_digest() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("rod.dcb.h5");
    for dimension in [Planar, Spatial] {
        for compression in [Compression::None, Compression::Deflate] {
            let superelement = synthetic::enriched(dimension);
            synthetic::write(&path, &superelement, compression).unwrap();
            check(&path).unwrap();
        }
        let superelement = synthetic::superelement(dimension);
        dcb_tests::write_bare(&path, &superelement);
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
    let superelement = synthetic::enriched(Spatial);
    let mesh = synthetic::mesh(Spatial);
    let contents = Contents {
        superelement: &superelement,
        recovery: None,
        mesh: Some(&mesh),
    };
    write_superelement(&path, &contents, &WriteOptions::default()).unwrap();
    python::run(script, &[path.as_os_str()]).unwrap();
}

#[test]
fn h5py_sees_a_changed_number() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("rod.dcb.h5");
    let superelement = synthetic::superelement(Planar);
    dcb_tests::write_bare(&path, &superelement);
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

/// Old and new HDF5 formats, chunks, filters, strings of fixed length: the format is about contents.
#[test]
fn files_that_h5py_wrote_say_the_same() {
    let folder = tempfile::tempdir().unwrap();
    for dimension in [Planar, Spatial] {
        let path = folder.path().join(format!("{dimension:?}.dcb.h5"));
        let superelement = synthetic::enriched(dimension);
        let (recovery, mesh) = (
            synthetic::recovery(&superelement),
            synthetic::mesh(dimension),
        );
        synthetic::write(&path, &superelement, Compression::None).unwrap();
        let right = SuperelementFile::open(&path).unwrap();
        for variant in ["default", "v114", "fixed"] {
            let copy = folder.path().join("copy.dcb.h5");
            python::recreate(&path, &copy, variant).unwrap();
            check(&copy).unwrap();
            let file = SuperelementFile::open(&copy).unwrap();
            assert_eq!(file.digest(), right.digest(), "{variant}");
            assert_eq!(file.superelement().unwrap(), right.superelement().unwrap());
            assert_eq!(file.recovery().unwrap(), Some(recovery.clone()));
            assert_eq!(file.mesh().unwrap(), Some(mesh.clone()));
            assert_eq!(
                file.verify_digests().unwrap(),
                right.verify_digests().unwrap()
            );
        }
    }
}

#[test]
fn what_a_later_minor_version_adds_is_ignored_but_verified() {
    let folder = tempfile::tempdir().unwrap();
    let (path, copy) = (
        folder.path().join("rod.dcb.h5"),
        folder.path().join("copy.dcb.h5"),
    );
    let superelement = synthetic::superelement(Spatial);
    dcb_tests::write_bare(&path, &superelement);
    python::recreate(&path, &copy, "extended").unwrap();
    check(&copy).unwrap();
    let (old, new) = (
        SuperelementFile::open(&path).unwrap(),
        SuperelementFile::open(&copy).unwrap(),
    );
    assert_eq!(new.format_version(), FormatVersion { major: 1, minor: 7 });
    assert_eq!(new.superelement().unwrap(), old.superelement().unwrap());
    assert_eq!(
        new.verify_digests().unwrap(),
        old.verify_digests().unwrap() + 1
    );
}

/// The lists of units of so many columns don't fit an HDF5 header.
#[test]
fn six_thousand_columns_are_fine() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("long.dcb.h5");
    let superelement = synthetic::with_modes(6000);
    dcb_tests::write_bare(&path, &superelement);
    let file = SuperelementFile::open(&path).unwrap();
    assert_eq!(file.superelement().unwrap(), superelement);
    check(&path).unwrap();
}
