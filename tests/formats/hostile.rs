//! Damaged and hostile `.dcb.h5` files: every one is refused with a message, none makes the program fall over.

use std::fs;
use std::path::{Path, PathBuf};

use dcb_formats::Error;
use dcb_formats::dcb::{Compression, SuperelementFile};
use dcb_formats::mesh::Dimension::{self, Planar, Spatial};
use dcb_tests::synthetic;
use hdf5::file::LibraryVersion;
use hdf5::types::{IntSize, TypeDescriptor};

use crate::hdf5_file::{self, set_text, unlocked};

fn full(folder: &Path, dimension: Dimension, compression: Compression) -> PathBuf {
    let path = folder.join("rod.dcb.h5");
    let superelement = synthetic::superelement(dimension);
    synthetic::write(&path, &superelement, compression).unwrap();
    path
}

/// Everything that a reader may ask of a file.
fn read_all(path: &Path) -> Result<(), Error> {
    let file = SuperelementFile::open(path)?;
    file.superelement()?;
    file.recovery()?;
    file.mesh()?;
    file.verify_digests()?;
    Ok(())
}

fn refusal(path: &Path) -> String {
    read_all(path).unwrap_err().to_string()
}

fn edit(path: &Path, change: impl FnOnce(&hdf5::File)) {
    hdf5_file::edit(path, LibraryVersion::V110, change);
}

#[test]
fn a_changed_byte_of_any_real_is_found_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let path = full(folder.path(), Planar, Compression::None);
    let right = fs::read(&path).unwrap();
    let offsets: Vec<(String, u64)> = {
        let file = unlocked(|| hdf5::File::open(&path));
        [
            "/modes/eigenvalues",
            "/inertia/L3",
            "/modes/shapes",
            "/residual/shapes",
            "/fields/dofs",
            "/mesh/points",
            "/mesh/cells/0/data",
        ]
        .map(|name| {
            (
                name.to_owned(),
                file.dataset(name).unwrap().offset().unwrap(),
            )
        })
        .to_vec()
    };
    for (name, offset) in offsets {
        let mut bytes = right.clone();
        bytes[offset as usize + 9] ^= 0x10;
        fs::write(&path, bytes).unwrap();
        let message = refusal(&path);
        assert!(
            message.contains(&name) && message.contains("sha256"),
            "{name}: {message}"
        );
    }
}

#[test]
fn a_changed_attribute_is_found() {
    let folder = tempfile::tempdir().unwrap();
    for (object, name) in [
        ("/", "name"),
        ("/frame", "kind"),
        ("/modes/eigenvalues", "units"),
        ("/inertia/L1", "symbol"),
        ("/inertia/mass", "sha256"),
    ] {
        let path = full(folder.path(), Planar, Compression::None);
        edit(&path, |file| match object.matches('/').count() {
            2 => set_text(&file.dataset(object).unwrap(), name, &"0".repeat(64)),
            _ => set_text(&file.group(object).unwrap(), name, "something else"),
        });
        let message = refusal(&path);
        assert!(message.contains("digest"), "{object} {name}: {message}");
        fs::remove_file(&path).unwrap();
    }
}

#[test]
fn what_is_only_said_to_people_may_change() {
    let folder = tempfile::tempdir().unwrap();
    let path = full(folder.path(), Planar, Compression::None);
    edit(&path, |file| {
        set_text(&file.group("/provenance").unwrap(), "warnings", "[]");
        set_text(
            &file.dataset("/inertia/mass").unwrap(),
            "description",
            "Masse",
        );
    });
    read_all(&path).unwrap();
}

#[test]
fn a_higher_major_version_and_a_foreign_format_are_refused_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let path = full(folder.path(), Planar, Compression::None);
    edit(&path, |file| set_text(file, "format_version", "2.0"));
    let message = refusal(&path);
    assert!(
        message.contains("2.0") && message.contains("1.x"),
        "{message}"
    );
    edit(&path, |file| set_text(file, "format_version", "newest"));
    assert!(
        refusal(&path).contains("format_version"),
        "{}",
        refusal(&path)
    );
    edit(&path, |file| set_text(file, "format", "dcb-results"));
    assert!(refusal(&path).contains("dcb-results"), "{}", refusal(&path));
}

#[test]
fn what_isnt_hdf5_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("rod.dcb.h5");
    assert!(
        matches!(read_all(&path), Err(Error::Io { .. })),
        "missing file"
    );
    for bytes in [
        &b""[..],
        b"\x89HDF",
        b"%%MatrixMarket matrix coordinate real symmetric\n",
        b"\x89HDF\r\n\x1a\n",
    ] {
        fs::write(&path, bytes).unwrap();
        assert!(refusal(&path).contains("HDF5"), "{}", refusal(&path));
    }
    assert!(refusal(folder.path()).contains("isn't a file"));
}

#[test]
fn a_shape_that_the_file_cannot_hold_is_refused_before_memory_is_taken() {
    let folder = tempfile::tempdir().unwrap();
    let path = full(folder.path(), Planar, Compression::None);
    edit(&path, |file| {
        file.unlink("modes/shapes").unwrap();
        let huge = file
            .new_dataset::<f64>()
            .chunk([1, 1000])
            .deflate(9)
            .shape([1_000_000, 1_000_000])
            .create("modes/shapes")
            .unwrap();
        set_text(&huge, "sha256", &"0".repeat(64));
    });
    let message = refusal(&path);
    assert!(
        message.contains("/modes/shapes") && message.contains("can't hold"),
        "{message}"
    );
}

/// Gives a changed file the digest that it should have.
fn sign(path: &Path) {
    let message = refusal(path);
    let digest = message.rsplit_once("give ").expect(&message).1[..64].to_owned();
    edit(path, |file| set_text(file, "digest", &digest));
}

#[test]
fn data_outside_the_file_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = full(folder.path(), Planar, Compression::None);
    let outside = folder.path().join("secret");
    fs::write(&outside, [0; 8]).unwrap();
    edit(&path, |file| {
        file.unlink("inertia/mass").unwrap();
        let external = file
            .new_dataset::<f64>()
            .external(outside.to_str().unwrap(), 0, 8)
            .shape([1])
            .create("inertia/mass")
            .unwrap();
        for name in ["sha256", "units", "symbol"] {
            set_text(&external, name, &"0".repeat(64));
        }
    });
    sign(&path);
    edit(&path, |file| {
        file.unlink("inertia/tensor").unwrap();
        file.link_external("other.h5", "/inertia/tensor", "inertia/tensor")
            .unwrap();
    });
    sign(&path);
    let message = refusal(&path);
    assert!(
        message.contains("/inertia/mass") && message.contains("shape"),
        "{message}"
    );
}

#[test]
fn groups_in_groups_for_ever_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = full(folder.path(), Planar, Compression::None);
    edit(&path, |file| {
        for index in 0..50 {
            file.link_hard("/", &format!("inertia/{index}")).unwrap();
        }
    });
    let message = refusal(&path);
    assert!(message.contains("groups deep"), "{message}");
}

#[test]
fn a_missing_dataset_is_named() {
    let folder = tempfile::tempdir().unwrap();
    for name in [
        "/modes/damping",
        "/modes/eigenvalues",
        "/residual/shapes",
        "/inertia/I2",
        "/mesh/points",
        "/interfaces/names",
    ] {
        let path = full(folder.path(), Spatial, Compression::None);
        edit(&path, |file| file.unlink(name).unwrap());
        sign(&path);
        let message = refusal(&path);
        assert!(
            message.contains(name) && message.contains("missing"),
            "{message}"
        );
        fs::remove_file(&path).unwrap();
    }
}

/// HDF5 describes nested element types by nesting, and the library follows by recursion.
#[test]
fn an_element_type_nested_thousands_deep_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = full(folder.path(), Planar, Compression::None);
    let nest = {
        let path = path.clone();
        move || {
            let bottom = TypeDescriptor::Integer(IntSize::U1);
            let deep = (0..7000).fold(bottom, |base, _| {
                TypeDescriptor::VarLenArray(Box::new(base))
            });
            edit(&path, |file| {
                let attribute = file.group("inertia").unwrap().new_attr_builder();
                attribute.empty_as(&deep).create("deep").unwrap();
            });
        }
    };
    let large = std::thread::Builder::new().stack_size(1 << 30);
    large.spawn(nest).unwrap().join().unwrap();
    let message = refusal(&path);
    assert!(message.contains("attribute deep"), "{message}");
}
