//! Matrix files that change while they are read, that have no end, or that hold more than memory may take.
#![cfg(unix)]

use std::collections::BTreeMap;
use std::fs::{File, OpenOptions};
use std::io::{Seek, Write};
use std::os::unix::fs::FileExt;
use std::path::Path;
use std::process::Command;
use std::sync::atomic::{AtomicBool, Ordering};

use dcb_formats::Error;
use dcb_formats::matrix::{MatrixReader, read_matrix, read_symmetric_operator};
use dcb_tests::own_process::{alone, peak_memory};

const SIZE: usize = 200_000;

/// A diagonal matrix of one value, some megabytes; every version is as long as every other.
fn diagonal(digit: u8) -> String {
    let mut text =
        format!("%%MatrixMarket matrix coordinate real symmetric\n{SIZE} {SIZE} {SIZE}\n");
    for row in 1..=SIZE {
        text += &format!("{row} {row} {digit}.000000000000000e+00\n");
    }
    text
}

/// Whatever a writer does meanwhile, what is read is one version with the digest of that version, or a refusal.
#[test]
fn a_file_that_is_rewritten_while_it_is_read_gives_one_version_or_none() {
    let folder = tempfile::tempdir().unwrap();
    let versions: Vec<String> = (1..=4).map(diagonal).collect();
    let digests: BTreeMap<String, f64> = versions
        .iter()
        .enumerate()
        .map(|(index, text)| {
            let path = folder.path().join("alone.mtx");
            std::fs::write(&path, text).unwrap();
            let (_, report) = read_matrix(&path).unwrap();
            (report.sha256, index as f64 + 1.0)
        })
        .collect();
    let path = folder.path().join("k.mtx");
    std::fs::write(&path, &versions[0]).unwrap();
    let is_over = AtomicBool::new(false);
    let (mut read_count, mut refused_count) = (0, 0);
    std::thread::scope(|scope| {
        scope.spawn(|| {
            let file = OpenOptions::new().write(true).open(&path).unwrap();
            for text in versions.iter().cycle() {
                for (number, piece) in text.as_bytes().chunks(1 << 16).enumerate() {
                    file.write_all_at(piece, (number << 16) as u64).unwrap();
                    if is_over.load(Ordering::Relaxed) {
                        return;
                    }
                }
                std::thread::sleep(std::time::Duration::from_millis(60));
            }
        });
        for _ in 0..60 {
            match read_symmetric_operator(&path) {
                Ok((matrix, report)) => {
                    let value = digests[&report.sha256];
                    assert!(matrix.val().iter().all(|entry| *entry == value));
                    read_count += 1;
                }
                Err(error) => {
                    let text = error.to_string();
                    assert!(text.contains("was changed while it was read"), "{text}");
                    refused_count += 1;
                }
            }
        }
        is_over.store(true, Ordering::Relaxed);
    });
    assert!(refused_count > 0, "{read_count} read, none refused");
}

/// Cutting off a mapped file would end the process with SIGBUS.
#[test]
fn a_file_that_is_cut_off_while_it_is_read_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("k.mtx");
    let text = diagonal(1);
    std::fs::write(&path, &text).unwrap();
    let is_over = AtomicBool::new(false);
    let mut refused_count = 0;
    std::thread::scope(|scope| {
        scope.spawn(|| {
            let mut file = OpenOptions::new().write(true).open(&path).unwrap();
            while !is_over.load(Ordering::Relaxed) {
                file.set_len(4096).unwrap();
                file.rewind().unwrap();
                file.write_all(text.as_bytes()).unwrap();
                std::thread::sleep(std::time::Duration::from_millis(5));
            }
        });
        for _ in 0..60 {
            match read_matrix(&path) {
                Ok((matrix, _)) => assert_eq!(matrix.compute_nnz(), SIZE),
                Err(_) => refused_count += 1,
            }
        }
        is_over.store(true, Ordering::Relaxed);
    });
    assert!(refused_count > 0);
}

#[test]
fn devices_are_refused_and_pipes_are_read() {
    for device in ["/dev/zero", "/dev/urandom", "/dev/null"] {
        let error = read_matrix(Path::new(device)).unwrap_err().to_string();
        assert_eq!(
            error,
            format!("{device}: is a device; expected a file or a pipe")
        );
    }
    let folder = tempfile::tempdir().unwrap();
    let pipe = |name: &str, first: &str, then: Vec<u8>| {
        let path = folder.path().join(name);
        let made = Command::new("mkfifo").arg(&path).status().unwrap();
        assert!(made.success());
        let (to, first) = (path.clone(), first.to_owned());
        std::thread::spawn(move || {
            let mut file = File::options().write(true).open(to).unwrap();
            let mut written = file.write_all(first.as_bytes());
            // The reader ends first.
            while written.is_ok() && !then.is_empty() {
                written = file.write_all(&then);
            }
        });
        path
    };
    let text = diagonal(2);
    let (matrix, report) = read_matrix(&pipe("whole", &text, Vec::new())).unwrap();
    assert_eq!(matrix.compute_nnz(), SIZE);
    let path = folder.path().join("k.mtx");
    std::fs::write(&path, &text).unwrap();
    assert_eq!(report.sha256, read_matrix(&path).unwrap().1.sha256);
    let banner = "%%MatrixMarket matrix coordinate real general\n";
    let sizes = format!("{banner}1 1 3\n");
    for (name, first, then, expected) in [
        ("zeros", "", vec![0; 1 << 20], "binary data"),
        (
            "comments",
            banner,
            b"% \n%\n".repeat(1 << 18),
            "no size line in the first 67108864 bytes",
        ),
        (
            "entries",
            &sizes,
            b"1 1 1\n".repeat(1 << 17),
            ":6: one entry more than the 3 announced in line 2",
        ),
        (
            "blanks",
            &sizes,
            vec![b'\n'; 1 << 20],
            "more than 268438528 bytes of text for 3 announced entries",
        ),
        (
            "line",
            &sizes,
            vec![b'%'; 1 << 20],
            "has a line of more than 262144 bytes",
        ),
    ] {
        let error = read_matrix(&pipe(name, first, then)).unwrap_err();
        let error = error.to_string();
        assert!(error.contains(expected), "{name}: {error}");
    }
}

/// A packed file of some kilobytes can hold gigabytes of entries.
#[test]
fn packed_entries_take_no_more_memory_than_they_may() {
    alone(|| {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("k.mtx.gz");
        let count = 20_000_000;
        let mut packed = flate2::write::GzEncoder::new(
            File::create(&path).unwrap(),
            flate2::Compression::fast(),
        );
        write!(
            packed,
            "%%MatrixMarket matrix coordinate pattern general\n1 1 {count}\n"
        )
        .unwrap();
        let lines = b"1 1\n".repeat(1000);
        for _ in 0..count / 1000 {
            packed.write_all(&lines).unwrap();
        }
        packed.finish().unwrap();
        let limit = 50 << 20;
        let before = peak_memory();
        let error = MatrixReader::new(Some(limit))
            .read_matrix(&path)
            .unwrap_err();
        assert!(
            matches!(&error, Error::NotEnoughMemory { needed, allowed: Some(50_u64..), .. } if *needed > limit),
            "{error}"
        );
        let text = error.to_string();
        let said = "MB or more, and 50 MB may be taken; allow more with --memory";
        assert!(text.contains(said), "{text}");
        let taken = peak_memory() - before;
        assert!(taken < limit + (40 << 20), "{} MB", taken >> 20);
        // What is kept of an earlier matrix counts.
        let small = folder.path().join("k.mtx");
        std::fs::write(&small, diagonal(1)).unwrap();
        let mut reader = MatrixReader::new(Some(16 << 20));
        for _ in 0..3 {
            assert!(reader.read_matrix(&small).is_ok());
        }
        assert!(matches!(
            reader.read_matrix(&small),
            Err(Error::NotEnoughMemory { .. })
        ));
    });
}
