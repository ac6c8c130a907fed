//! Damaged `.dcb.h5` files, this project's and h5py's: every one is refused, or says what it said before.

use std::fs;
use std::path::{Path, PathBuf};

use dcb_formats::Superelement;
use dcb_formats::dcb::{Compression, SuperelementFile};
use dcb_formats::mesh::Dimension::{Planar, Spatial};
use dcb_samples::PseudoRandom;
use dcb_tests::{python, synthetic};

/// Four files of all the ways that HDF5 has to store things.
fn samples(folder: &Path) -> Vec<PathBuf> {
    let (plain, small) = (folder.join("plain.dcb.h5"), folder.join("small.dcb.h5"));
    let written = |path, dimension, compression| {
        synthetic::write(path, &synthetic::superelement(dimension), compression).unwrap();
    };
    written(&plain, Planar, Compression::None);
    written(&small, Spatial, Compression::Deflate);
    let mut samples = vec![plain.clone(), small];
    for variant in ["default", "v114", "fixed"] {
        let copy = folder.join(format!("{variant}.dcb.h5"));
        python::recreate(&plain, &copy, variant).unwrap();
        samples.push(copy);
    }
    samples
}

/// Everything but what the digest doesn't cover.
fn read(path: &Path) -> Option<Superelement> {
    let file = SuperelementFile::open(path).ok()?;
    let _ = file.recovery();
    let _ = file.mesh();
    let _ = file.verify_digests();
    let mut superelement = file.superelement().ok()?;
    superelement.provenance = synthetic::superelement(superelement.dimension).provenance;
    Some(superelement)
}

#[test]
fn a_truncated_file_is_refused_at_every_length() {
    let folder = tempfile::tempdir().unwrap();
    for path in samples(folder.path()) {
        let right = fs::read(&path).unwrap();
        let short = folder.path().join("short.dcb.h5");
        for length in (0..right.len()).step_by(197).chain([right.len() - 1]) {
            fs::write(&short, &right[..length]).unwrap();
            let bytes = right.len();
            assert!(
                SuperelementFile::open(&short).is_err(),
                "{length} of {bytes} bytes of {path:?}"
            );
        }
    }
}

/// One byte after the other, and a few at a time: an error or, where nothing reads the byte, the same answer.
#[test]
fn flipped_bytes_never_bring_the_reader_down() {
    let folder = tempfile::tempdir().unwrap();
    let broken = folder.path().join("broken.dcb.h5");
    let rounds: usize =
        std::env::var("DCB_FUZZ_ROUNDS").map_or(2000, |rounds| rounds.parse().unwrap());
    for path in samples(folder.path()) {
        let right = fs::read(&path).unwrap();
        let expected = read(&path).unwrap();
        let mut random = PseudoRandom::new(1);
        let mut accepted = 0;
        for round in 0..rounds {
            let mut bytes = right.clone();
            let at = round * right.len() / rounds;
            bytes[at] ^= 1 << (random.below(8));
            if round % 2 == 1 {
                for _ in 0..random.below(8) {
                    let near = (at + random.below(64)).min(right.len() - 1);
                    bytes[near] = [0, 0xff, 0x7f, 0x80, 1][random.below(5)];
                }
            }
            fs::write(&broken, &bytes).unwrap();
            if let Some(found) = read(&broken) {
                assert_eq!(
                    found, expected,
                    "byte {at} of {path:?} changed the answer unnoticed"
                );
                accepted += 1;
            }
        }
        println!("{path:?}: {rounds} broken files, {accepted} of them harmless");
    }
}
