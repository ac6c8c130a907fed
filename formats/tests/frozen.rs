//! The sample file of every released format version, read forever.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod support;

use std::path::Path;

use dcb_formats::dcb::SuperelementFile;

#[test]
fn frozen_files_of_version_1_0_read_as_when_they_were_written() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/data/frozen");
    for name in ["planar-1.0", "spatial-1.0"] {
        let file = SuperelementFile::open(folder.join(format!("{name}.dcb.h5"))).unwrap();
        let json = std::fs::read_to_string(folder.join(format!("{name}.json"))).unwrap();
        let expected: serde_json::Value = serde_json::from_str(&json).unwrap();
        // serde_json reads some numbers a digit off: both sides take the same way.
        let found = support::summary(&file).unwrap().to_string();
        let found: serde_json::Value = serde_json::from_str(&found).unwrap();
        assert_eq!(found, expected, "{name}");
        file.verify_digests().unwrap();
    }
}
