//! Damaged and hostile `.dcb.h5` files: every one is refused with a message, none makes the program fall over.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod support;

use std::fs;
use std::path::{Path, PathBuf};

use dcb_formats::Error;
use dcb_formats::dcb::{Compression, Contents, SuperelementFile, WriteOptions, write_superelement};
use dcb_formats::mesh::Dimension::{self, Planar, Spatial};
use hdf5::types::VarLenUnicode;

fn full(folder: &Path, dimension: Dimension, compression: Compression) -> PathBuf {
    let path = folder.join("rod.dcb.h5");
    let superelement = support::superelement(dimension);
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
    let file = hdf5::File::with_options()
        .with_fapl(|access| {
            access.libver_bounds(
                hdf5::file::LibraryVersion::V110,
                hdf5::file::LibraryVersion::V110,
            )
        })
        .open_rw(path)
        .unwrap();
    change(&file);
    file.close().unwrap();
}

fn set_text(object: &hdf5::Location, name: &str, text: &str) {
    let _ = object.delete_attr(name);
    object
        .new_attr::<VarLenUnicode>()
        .create(name)
        .unwrap()
        .write_scalar(&text.parse::<VarLenUnicode>().unwrap())
        .unwrap();
}

#[test]
fn a_changed_byte_of_any_real_is_found_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let path = full(folder.path(), Planar, Compression::None);
    let right = fs::read(&path).unwrap();
    let offsets: Vec<(String, u64)> = {
        let file = hdf5::File::open(&path).unwrap();
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
fn a_truncated_file_is_refused_at_every_length() {
    let folder = tempfile::tempdir().unwrap();
    let path = full(folder.path(), Planar, Compression::None);
    let right = fs::read(&path).unwrap();
    let short = folder.path().join("short.dcb.h5");
    for length in (0..right.len()).step_by(37).chain([right.len() - 1]) {
        fs::write(&short, &right[..length]).unwrap();
        assert!(
            read_all(&short).is_err(),
            "{length} of {} bytes",
            right.len()
        );
    }
}

/// One byte after the other, and a few at a time: an error or, where nothing reads the byte, the same answer.
#[test]
fn flipped_bytes_never_bring_the_reader_down() {
    let folder = tempfile::tempdir().unwrap();
    for (dimension, compression) in [(Planar, Compression::None), (Spatial, Compression::Deflate)] {
        let path = full(folder.path(), dimension, compression);
        let right = fs::read(&path).unwrap();
        let superelement = SuperelementFile::open(&path)
            .unwrap()
            .superelement()
            .unwrap();
        let broken = folder.path().join("broken.dcb.h5");
        let mut state = 0x9e37_79b9_7f4a_7c15_u64;
        let mut random = move || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) as usize
        };
        let (mut accepted, mut tried) = (0, 0);
        for start in 0..right.len().min(6000) {
            let mut bytes = right.clone();
            let at = if start < 4000 {
                start * right.len() / 4000
            } else {
                random() % right.len()
            };
            bytes[at] ^= 1 << (random() % 8);
            if start >= 4000 {
                for _ in 0..random() % 8 {
                    let near = (at + random() % 64).min(right.len() - 1);
                    bytes[near] = [0, 0xff, 0x7f, 0x80, 1][random() % 5];
                }
            }
            fs::write(&broken, &bytes).unwrap();
            tried += 1;
            let Ok(file) = SuperelementFile::open(&broken) else {
                continue;
            };
            let _ = file.recovery();
            let _ = file.mesh();
            let _ = file.verify_digests();
            if let Ok(mut read) = file.superelement() {
                read.provenance = superelement.provenance.clone();
                assert_eq!(read, superelement, "byte {at} changed the answer unnoticed");
                accepted += 1;
            }
        }
        println!("{dimension:?}: {tried} broken files, {accepted} of them harmless");
        fs::remove_file(&path).unwrap();
    }
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
        set_text(&external, "sha256", &"0".repeat(64));
    });
    assert!(
        refusal(&path).contains("another file"),
        "{}",
        refusal(&path)
    );
    edit(&path, |file| {
        file.unlink("inertia/mass").unwrap();
        file.link_external("other.h5", "/inertia/mass", "inertia/mass")
            .unwrap();
    });
    assert!(
        refusal(&path).contains("soft or external link"),
        "{}",
        refusal(&path)
    );
    edit(&path, |file| {
        file.unlink("inertia/mass").unwrap();
        file.link_hard("/inertia", "inertia/mass").unwrap();
    });
    assert!(
        refusal(&path).contains("linked twice"),
        "{}",
        refusal(&path)
    );
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
        let digest = refusal(&path).rsplit_once("give ").unwrap().1[..64].to_owned();
        edit(&path, |file| set_text(file, "digest", &digest));
        let message = refusal(&path);
        assert!(
            message.contains(name) && message.contains("missing"),
            "{message}"
        );
        fs::remove_file(&path).unwrap();
    }
}
