//! The sample file of every released format version, read forever.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod support;

use std::path::Path;

use dcb_formats::dcb::SuperelementFile;

/// Whether a file still says what it said when it was frozen; later versions may have more to say.
fn read_as_then(name: &str) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/data/frozen");
    let file = SuperelementFile::open(folder.join(format!("{name}.dcb.h5"))).unwrap();
    let json = std::fs::read_to_string(folder.join(format!("{name}.json"))).unwrap();
    let expected: serde_json::Value = serde_json::from_str(&json).unwrap();
    // serde_json reads some numbers a digit off: both sides take the same way.
    let found = support::summary(&file).unwrap().to_string();
    let found: serde_json::Value = serde_json::from_str(&found).unwrap();
    let expected = expected.as_object().unwrap();
    assert!(expected.len() > 30, "{name}");
    for (key, value) in expected {
        assert_eq!(&found[key], value, "{name}: {key}");
    }
    file.verify_digests().unwrap();
}

#[test]
fn frozen_files_of_version_1_0_read_as_when_they_were_written() {
    read_as_then("planar-1.0");
    read_as_then("spatial-1.0");
}

#[test]
fn frozen_files_of_version_1_3_read_as_when_they_were_written() {
    read_as_then("planar-1.3");
    read_as_then("spatial-1.3");
}

#[test]
fn frozen_files_of_version_1_2_read_as_when_they_were_written() {
    read_as_then("planar-1.2");
    read_as_then("spatial-1.2");
}

#[test]
fn frozen_files_of_version_1_1_read_as_when_they_were_written() {
    read_as_then("planar-1.1");
    read_as_then("spatial-1.1");
}
