//! Files that are missing, damaged, or not what their place asks for.

use std::fs;
use std::io::Write;
use std::time::Instant;

use flate2::Compression;
use flate2::write::GzEncoder;

use crate::support::{Folder, stored};

#[test]
fn a_missing_sibling_is_named_with_the_option_that_replaces_it() {
    for (name, option) in [("rotor.mass.mtx", "--mass"), ("rotor.json", "--mesh")] {
        let folder = Folder::rotor();
        folder.remove(name);
        folder.refused_each(&[
            ("rotor.mtx", &[name, "is not there", option]),
            (
                &format!("rotor.mtx {option} nowhere"),
                &["nowhere", "is not there", option, "existing file"],
            ),
        ]);
    }
    let folder = Folder::rotor();
    folder.refused_each(&[
        ("nowhere.mtx", &["nowhere.mtx", "is not there", "PART.mtx"]),
        ("rotor.mtx --boundary nowhere", &["nowhere", "--boundary"]),
    ]);
}

#[test]
fn component_masses_come_together_and_add_up() {
    let folder = Folder::rod();
    folder.remove("rod.mass.xx.mtx");
    folder.refused(
        "rod.mtx",
        &[
            "rod.mass.xx.mtx",
            "missing",
            "xx yy xy",
            "all of them or none",
        ],
    );
    let folder = Folder::rod();
    folder.write("rod.mass.xx.mtx", folder.read("rod.mass.yy.mtx"));
    folder.refused(
        "rod.mtx",
        &["rod.mass.mtx", "don't add up", "row 1, column 1"],
    );
}

#[test]
fn coupling_masses_have_the_moments_of_the_mass_matrix() {
    let entries = |folder: &Folder, change: fn([&str; 3]) -> String| {
        let text = folder.read("rod.mass.xy.mtx");
        let mut lines = text.lines().map(str::to_owned);
        let mut changed: Vec<String> = lines.by_ref().take(2).collect();
        changed.extend(lines.map(|line| {
            let words: Vec<&str> = line.split_whitespace().collect();
            change([words[0], words[1], words[2]])
        }));
        folder.write("rod.mass.xy.mtx", changed.join("\n") + "\n");
    };
    let transposed = Folder::rod();
    entries(&transposed, |[row, column, value]| {
        format!("{column} {row} {value}")
    });
    let zero = Folder::rod();
    entries(&zero, |[row, column, _]| format!("{row} {column} 0.0"));
    for folder in [transposed, zero] {
        folder.refused(
            "rod.mtx",
            &[
                "rod.mass.xy.mtx: is not the component mass xy",
                "it gives",
                "but the mass matrix",
            ],
        );
    }
    // Unit translations don't see a rotation's column; the rotation does.
    let turned = Folder::rod();
    entries(&turned, |[row, column, value]| {
        let factor = if column == "3" { -1.0 } else { 1.0 };
        format!(
            "{row} {column} {:?}",
            factor * value.parse::<f64>().unwrap()
        )
    });
    turned.refused("rod.mtx", &["rod.mass.xy.mtx", "rigid motions", "rz"]);
}

#[test]
fn matrices_of_different_size_are_refused_with_both_sizes() {
    let folder = Folder::rotor();
    fs::copy(
        Folder::rod().path("rod.mass.mtx"),
        folder.path("rotor.mass.mtx"),
    )
    .unwrap();
    folder.refused(
        "rotor.mtx",
        &[
            "rotor.mass.mtx: is 15 x 15",
            "the stiffness matrix is 345 x 345",
            "of one model",
        ],
    );
    let folder = Folder::rotor();
    folder.write(
        "rotor.boundary.mtx",
        "%%MatrixMarket matrix coordinate real general\n2 12 1\n1 1 1\n",
    );
    folder.refused(
        "rotor.mtx",
        &["rotor.boundary.mtx", "12 columns", "345 dofs", "n_b x n_e"],
    );
}

#[test]
fn values_that_are_not_finite_are_named_by_line() {
    for file in ["rotor.mtx", "rotor.mass.mtx"] {
        for value in ["NaN", "Inf", "-inf", "1e999"] {
            let folder = Folder::rotor();
            let line = folder.set_diagonal(file, 7, |_| value.into());
            folder.refused("rotor.mtx", &[&format!("{file}:{line}:"), value, "finite"]);
        }
    }
}

#[test]
fn a_damaged_or_truncated_archive_is_refused() {
    let folder = Folder::rotor();
    let mut packer = GzEncoder::new(Vec::new(), Compression::default());
    packer
        .write_all(folder.read("rotor.mtx").as_bytes())
        .unwrap();
    let whole = packer.finish().unwrap();
    folder.remove("rotor.mtx");
    let mut flipped = whole.clone();
    flipped[whole.len() / 2] ^= 0xff;
    for bytes in [
        &whole[..whole.len() / 2],
        &whole[..whole.len() - 3],
        &flipped,
    ] {
        folder.write("rotor.mtx.gz", bytes);
        folder.refused("rotor.mtx.gz", &["rotor.mtx.gz", "damaged or cut off"]);
    }
    folder.write("rotor.mtx.gz", &whole);
    folder.done("rotor.mtx.gz");
    assert!(
        folder.names().contains(&"rotor.dcb.h5".into()),
        "{:?}",
        folder.names()
    );
}

#[test]
fn announced_sizes_are_not_believed() {
    let folder = Folder::rotor();
    let header = "%%MatrixMarket matrix coordinate real symmetric\n";
    let start = Instant::now();
    for (sizes, says) in [
        ("4000000000 4000000000 3", "at most 2147483647"),
        ("2000000000 2000000000 3", "plausible"),
        ("345 345 3000000000000", "3000000000000"),
    ] {
        folder.write(
            "rotor.mtx",
            format!("{header}{sizes}\n1 1 1\n2 2 1\n3 3 1\n"),
        );
        folder.refused("rotor.mtx", &["rotor.mtx:", says]);
    }
    let seconds = start.elapsed().as_secs_f64();
    assert!(seconds < 5.0, "three refusals took {seconds} s");
}

#[test]
fn a_folder_in_place_of_a_file_is_refused() {
    for name in ["rotor.mtx", "rotor.mass.mtx", "rotor.json"] {
        let folder = Folder::rotor();
        folder.remove(name);
        fs::create_dir(folder.path(name)).unwrap();
        let message = folder.refused("rotor.mtx", &[name]);
        assert!(
            message.contains("folder") || message.contains("directory"),
            "{message}"
        );
    }
    let folder = Folder::rotor();
    folder.refused_each(&[
        (".", &[".: is a folder", "PART.mtx"]),
        ("/", &["/: is a folder"]),
    ]);
}

#[test]
fn other_files_are_refused_for_what_they_are() {
    let folder = Folder::rotor();
    folder.refused("rotor.json", &["rotor.json", "no matrix of a format"]);
    folder.write("rotor.mtx", "");
    folder.refused("rotor.mtx", &["rotor.mtx", "empty"]);
    let folder = Folder::rotor();
    folder.write("rotor.json", "");
    folder.refused("rotor.mtx", &["rotor.json", "empty", "component"]);
}

/// Also where the siblings are missing, which is the smaller problem.
#[test]
fn abaqus_coordinate_output_is_recognised() {
    let folder = Folder::empty();
    let name = "rotorDiscTestSTIF1.mtx.gz";
    fs::copy(stored("tests/data/exudyn").join(name), folder.path(name)).unwrap();
    folder.refused(
        name,
        &[
            "rotorDiscTestSTIF1.mtx.gz",
            "Abaqus COORDINATE",
            "without a mass",
        ],
    );
}

/// Something that never ends is no file to read.
#[test]
#[cfg(unix)]
fn devices_are_not_read() {
    let folder = Folder::rotor();
    for option in ["--mass", "--boundary", "--mesh"] {
        folder.refused(
            &format!("rotor.mtx {option} /dev/zero"),
            &["/dev/zero", "is a device"],
        );
    }
    folder.refused(
        "/dev/zero --mass rotor.mass.mtx",
        &["/dev/zero", "is a device"],
    );
}

/// A few kilobytes can become gigabytes.
#[test]
fn a_packed_matrix_is_unpacked_within_the_memory_only() {
    let folder = Folder::rotor();
    let mut packed = GzEncoder::new(Vec::new(), Compression::best());
    let entries = 12_000_000;
    writeln!(
        packed,
        "%%MatrixMarket matrix coordinate real symmetric\n345 345 {entries}"
    )
    .unwrap();
    let line = b"345 345 1.000000000000000\n".repeat(10_000);
    for _ in 0..entries / 10_000 {
        packed.write_all(&line).unwrap();
    }
    let bytes = packed.finish().unwrap();
    assert!(bytes.len() < 2_000_000, "{} bytes", bytes.len());
    folder.remove("rotor.mtx");
    folder.write("rotor.mtx.gz", bytes);
    let clock = Instant::now();
    folder.refused(
        "rotor.mtx.gz --memory 100M",
        &["rotor.mtx.gz", "memory", "100 MB"],
    );
    assert!(clock.elapsed().as_secs() < 20);
}
