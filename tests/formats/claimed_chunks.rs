//! Files whose chunk indices claim more than the file has: refused by name, and before memory is taken for them.

use std::fs;
use std::path::{Path, PathBuf};

use dcb_formats::component::Units;
use dcb_formats::dcb::{Contents, SuperelementFile, WriteOptions, write_superelement};
use dcb_formats::mesh::Dimension::Planar;
use dcb_formats::output::Replace;
use dcb_formats::results::{Channel, Header, Outcome, Results, ResultsWriter};
use dcb_tests::own_process::alone_within;
use dcb_tests::synthetic;
use hdf5::file::LibraryVersion;
use serde_json::json;

use crate::hdf5_file::{edit, set_text};

/// What a claim of some GB must not cost, bytes. The tests themselves need a tenth of it.
const MOST_MEMORY: u64 = 300_000_000;
/// Sorted first, so its data are the first that `verify_digests` reads.
const STRANGE: &str = "a_strange";
/// Values of a chunk: 64 KiB, so that its stored size has four bytes.
const CHUNK: usize = 1 << 13;

/// Jenkins' lookup3, the checksum of HDF5's structures.
fn lookup3(bytes: &[u8]) -> u32 {
    let start = 0xdead_beef_u32.wrapping_add(bytes.len() as u32);
    let (mut a, mut b, mut c) = (start, start, start);
    let word = |block: &[u8], at: usize| {
        (0..4).fold(0_u32, |word, i| {
            word | u32::from(block.get(at + i).copied().unwrap_or(0)) << (8 * i)
        })
    };
    let mut rest = bytes;
    while rest.len() > 12 {
        (a, b, c) = (
            a.wrapping_add(word(rest, 0)),
            b.wrapping_add(word(rest, 4)),
            c.wrapping_add(word(rest, 8)),
        );
        for turn in [4, 6, 8, 16, 19, 4] {
            a = a.wrapping_sub(c) ^ c.rotate_left(turn);
            c = c.wrapping_add(b);
            (a, b, c) = (b, c, a);
        }
        rest = &rest[12..];
    }
    if rest.is_empty() {
        return c;
    }
    (a, b, c) = (
        a.wrapping_add(word(rest, 0)),
        b.wrapping_add(word(rest, 4)),
        c.wrapping_add(word(rest, 8)),
    );
    for turn in [14, 11, 25, 16, 4, 14, 24] {
        c = (c ^ b).wrapping_sub(b.rotate_left(turn));
        (a, b, c) = (b, c, a);
    }
    b
}

/// Changes a structure of the file, found by its signature, and makes its checksum right again.
fn change(path: &Path, signature: &[u8], length: usize, change: impl Fn(&mut [u8])) {
    let mut bytes = fs::read(path).unwrap();
    let at = bytes.windows(4).position(|window| window == signature);
    let structure = &mut bytes[at.unwrap()..][..length];
    let stored = |structure: &[u8]| u32::from_le_bytes(structure[length - 4..].try_into().unwrap());
    assert_eq!(lookup3(&structure[..length - 4]), stored(structure));
    change(structure);
    let sum = lookup3(&structure[..length - 4]).to_le_bytes();
    structure[length - 4..].copy_from_slice(&sum);
    fs::write(path, bytes).unwrap();
}

/// Makes the last chunk of every B-tree of version 1 with several chunks claim 3.9 GB.
fn enlarge_in_trees(path: &Path) {
    let mut bytes = fs::read(path).unwrap();
    let word = |bytes: &[u8], at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap());
    let mut changed = 0;
    for at in 0..bytes.len() - 64 {
        let entries = usize::from(bytes[at + 6]);
        if bytes[at..at + 4] != *b"TREE" || bytes[at + 4..at + 6] != [1, 0] || entries < 3 {
            continue;
        }
        // A key of size, mask and an offset for each axis and one more, then an address; all chunks are of one size here.
        let stride = [32, 40]
            .into_iter()
            .find(|stride| word(&bytes, at + 24 + stride) == word(&bytes, at + 24))
            .unwrap();
        let last = at + 24 + stride * (entries - 1);
        bytes[last..last + 4].copy_from_slice(&0xe800_0000_u32.to_le_bytes());
        changed += 1;
    }
    assert!(changed > 0);
    fs::write(path, bytes).unwrap();
}

/// A small superelement with a right digest and one dataset more, made by `build` with this version of HDF5's format.
fn superelement_with(
    folder: &Path,
    version: LibraryVersion,
    build: impl Fn(&hdf5::File) -> hdf5::Dataset,
) -> PathBuf {
    let path = folder.join("rod.dcb.h5");
    let superelement = synthetic::superelement(Planar);
    let contents = Contents {
        superelement: &superelement,
        recovery: None,
        mesh: None,
    };
    write_superelement(&path, &contents, &WriteOptions::default()).unwrap();
    edit(&path, version, |file| {
        let dataset = build(file);
        dataset.write_raw(&vec![0.25; 4 * CHUNK]).unwrap();
        for name in ["sha256", "units", "symbol"] {
            set_text(&dataset, name, &"0".repeat(64));
        }
    });
    let message = SuperelementFile::open(&path).unwrap_err().to_string();
    let digest = message.rsplit_once("give ").expect(&message).1[..64].to_owned();
    edit(&path, version, |file| set_text(file, "digest", &digest));
    path
}

/// The refusal, after all data were asked for.
#[track_caller]
fn refusal(path: &Path) -> String {
    let read = SuperelementFile::open(path).and_then(|file| file.verify_digests());
    read.unwrap_err().to_string()
}

#[track_caller]
fn assert_refused(path: &Path, says: &str) {
    let message = refusal(path);
    assert!(
        message.contains(&format!("/{STRANGE}")) && message.contains(says),
        "{message}"
    );
}

#[test]
fn chunks_in_a_tree_that_claim_gigabytes_are_refused() {
    alone_within(MOST_MEMORY, || {
        let folder = tempfile::tempdir().unwrap();
        let path = superelement_with(folder.path(), LibraryVersion::V18, |file| {
            let builder = file.new_dataset::<f64>().chunk([CHUNK]).deflate(9);
            builder.shape([4 * CHUNK]).create(STRANGE).unwrap()
        });
        assert_refused(&path, "its sha256");
        enlarge_in_trees(&path);
        assert_refused(&path, "has a chunk of 3892314112 bytes");
    });
}

#[test]
fn chunks_in_a_fixed_array_that_claim_gigabytes_are_refused() {
    alone_within(MOST_MEMORY, || {
        let folder = tempfile::tempdir().unwrap();
        let path = superelement_with(folder.path(), LibraryVersion::V110, |file| {
            let builder = file.new_dataset::<f64>().chunk([CHUNK]).deflate(9);
            builder.shape([4 * CHUNK]).create(STRANGE).unwrap()
        });
        assert_refused(&path, "its sha256");
        // Signature, version, client and header's address, then address, size and mask of each chunk.
        change(&path, b"FADB", 14 + 4 * 16 + 4, |block| {
            block[14 + 3 * 16 + 8..][..4].copy_from_slice(&0xe800_0000_u32.to_le_bytes());
        });
        assert_refused(&path, "has a chunk of 3892314112 bytes");
    });
}

fn extensible(folder: &Path) -> PathBuf {
    superelement_with(folder, LibraryVersion::V110, |file| {
        let builder = file.new_dataset::<f64>().chunk([CHUNK]).deflate(9);
        let dataset = builder.shape(0..).create(STRANGE).unwrap();
        dataset.resize(4 * CHUNK).unwrap();
        dataset
    })
}

#[test]
fn chunks_in_an_extensible_array_that_claim_gigabytes_are_refused() {
    alone_within(MOST_MEMORY, || {
        let folder = tempfile::tempdir().unwrap();
        let path = extensible(folder.path());
        assert_refused(&path, "its sha256");
        // As above for four chunks, then the addresses of 6 blocks and 25 blocks of blocks.
        change(&path, b"EAIB", 14 + 4 * 16 + 31 * 8 + 4, |block| {
            block[14 + 3 * 16 + 8..][..4].copy_from_slice(&0xe800_0000_u32.to_le_bytes());
        });
        assert_refused(&path, "has a chunk of 3892314112 bytes");
    });
}

/// The library makes a list of 2^32 blocks from these 72 bytes.
#[test]
fn an_extensible_array_with_blocks_without_end_is_refused() {
    alone_within(MOST_MEMORY, || {
        let folder = tempfile::tempdir().unwrap();
        let path = extensible(folder.path());
        change(&path, b"EAHD", 72, |header| {
            (header[7], header[10]) = (64, 60);
        });
        assert_refused(&path, "an extensible array of chunks has the sizes");
    });
}

/// Bytes named again and again: a file of some kB could become any number of chunks in memory.
#[test]
fn chunks_that_share_their_bytes_are_refused() {
    alone_within(MOST_MEMORY, || {
        let folder = tempfile::tempdir().unwrap();
        let path = superelement_with(folder.path(), LibraryVersion::V110, |file| {
            let builder = file.new_dataset::<f64>().chunk([CHUNK]).deflate(9);
            builder.shape([4 * CHUNK]).create(STRANGE).unwrap()
        });
        let half = fs::metadata(&path).unwrap().len() as u32 / 2;
        change(&path, b"FADB", 14 + 4 * 16 + 4, |block| {
            for chunk in block[14..14 + 4 * 16].chunks_exact_mut(16) {
                chunk[..8].copy_from_slice(&64_u64.to_le_bytes());
                chunk[8..12].copy_from_slice(&half.to_le_bytes());
            }
        });
        assert_refused(&path, "bytes together");
    });
}

#[test]
fn chunks_too_small_for_what_they_become_are_refused() {
    alone_within(MOST_MEMORY, || {
        let folder = tempfile::tempdir().unwrap();
        let path = superelement_with(folder.path(), LibraryVersion::V110, |file| {
            let builder = file.new_dataset::<f64>().chunk([CHUNK]).deflate(9);
            builder.shape([4 * CHUNK]).create(STRANGE).unwrap()
        });
        change(&path, b"FADB", 14 + 4 * 16 + 4, |block| {
            block[14 + 3 * 16 + 8..][..4].copy_from_slice(&20_u32.to_le_bytes());
        });
        assert_refused(
            &path,
            "has a chunk of 20 bytes; its shape needs 63 at least",
        );
    });
}

#[test]
fn histories_that_claim_gigabytes_are_refused() {
    alone_within(MOST_MEMORY, || {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("results.h5");
        let header = Header {
            units: Units {
                length: "m".to_owned(),
                mass: "kg".to_owned(),
                time: "s".to_owned(),
            },
            generator: "a test".to_owned(),
            scene: json!({}),
            inputs: Vec::new(),
            options: json!({}),
            warnings: Vec::new(),
        };
        let channels = [Channel::scalar("outputs/tip", "m", "position")];
        let mut writer = ResultsWriter::create(&path, &channels, &header, Replace::Refuse).unwrap();
        for step in 0..2000 {
            writer.append(f64::from(step), &[1.0]).unwrap();
        }
        writer.finish(&Outcome::Complete, &json!({})).unwrap();
        assert_eq!(Results::open(&path).unwrap().time().unwrap().len(), 2000);

        enlarge_in_trees(&path);
        let results = Results::open(&path).unwrap();
        for refused in [
            results.time().map(|_| ()),
            results.history("tip").map(|_| ()),
        ] {
            let message = refused.unwrap_err().to_string();
            assert!(
                message.contains("has a chunk of 3892314112 bytes"),
                "{message}"
            );
        }
    });
}
