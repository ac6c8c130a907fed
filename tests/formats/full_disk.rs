//! A disk that fills while a superelement is written.

use std::fs;

use dcb_formats::dcb::{Compression, Contents, WriteOptions, write_superelement};
use dcb_formats::mesh::Dimension::Spatial;
use dcb_tests::synthetic;

/// On a file system of 64 KiB, where this machine lets the test make one.
#[test]
fn a_full_disk_is_told_and_nothing_is_left() {
    let folder = tempfile::tempdir().unwrap();
    let disk = folder.path().join("disk");
    fs::create_dir(&disk).unwrap();
    let mount = std::process::Command::new("mount")
        .args(["-t", "tmpfs", "-o", "size=64k", "tmpfs"])
        .arg(&disk)
        .output();
    if !mount.is_ok_and(|output| output.status.success()) {
        println!("SKIPPED: mounting a small file system needs root; the full disk wasn't tested");
        return;
    }
    let path = disk.join("rod.dcb.h5");
    let answers: Vec<_> = [Compression::None, Compression::Deflate]
        .map(|compression| {
            let superelement = synthetic::enriched(Spatial);
            let recovery = synthetic::recovery(&superelement);
            let contents = Contents {
                superelement: &superelement,
                recovery: Some(&recovery),
                mesh: None,
            };
            let answer = write_superelement(
                &path,
                &contents,
                &WriteOptions {
                    compression,
                    ..WriteOptions::default()
                },
            );
            (answer, fs::read_dir(&disk).unwrap().count())
        })
        .into_iter()
        .collect();
    let _ = std::process::Command::new("umount")
        .arg("-l")
        .arg(&disk)
        .status();
    for (answer, left) in answers {
        let message = answer
            .expect_err("64 KiB don't hold this superelement")
            .to_string();
        assert!(
            message.contains("rod.dcb.h5") && message.contains("No space left"),
            "{message}"
        );
        assert_eq!(left, 0, "{message}");
    }
}
