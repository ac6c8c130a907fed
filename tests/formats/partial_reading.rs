//! What of a large file is read: by bytes that the system counts, and by damage that isn't seen where nothing is read.

use std::io::{Seek, SeekFrom, Write};
use std::path::Path;
use std::time::Instant;

use dcb_formats::dcb::{Compression, Contents, SuperelementFile, WriteOptions, write_superelement};
use dcb_formats::mesh::{Dimension, Direction, Dof, Mesh};
use dcb_formats::superelement::RecoveryBasis;
use dcb_tests::own_process::alone;
use dcb_tests::synthetic;
use faer::Mat;

/// Bytes that this process has read from files, if the system tells.
fn bytes_read() -> Option<u64> {
    let counts = std::fs::read_to_string("/proc/self/io").ok()?;
    let line = counts
        .lines()
        .find_map(|line| line.strip_prefix("rchar: "))?;
    line.parse().ok()
}

/// What a function reads from files, bytes.
fn read_by<T>(work: impl FnOnce() -> T) -> (T, u64) {
    let before = bytes_read().unwrap_or(0);
    let result = work();
    (result, bytes_read().unwrap_or(0) - before)
}

const MODES: usize = 100;

/// Planar, 100 modes, 6 rows; (ux, uy, rz) at each node. Writes 2544 bytes of shapes a node.
fn write_large(path: &Path, nodes: usize, compression: Compression) -> RecoveryBasis {
    let element = synthetic::with_modes(MODES);
    let dofs: Vec<Dof> = (0..nodes as u32)
        .flat_map(|node| {
            let directions = [Direction::Ux, Direction::Uy, Direction::Rz];
            directions.map(|direction| Dof { node, direction })
        })
        .collect();
    let value = |seed: usize| move |i: usize, j: usize| ((i * 31 + j * 17 + seed) % 1009) as f64;
    let recovery = RecoveryBasis {
        modes: Mat::from_fn(dofs.len(), MODES, value(1)),
        residual: Mat::from_fn(dofs.len(), element.boundary_row_count(), value(2)),
        enrichment: None,
        dofs,
    };
    let mesh = Mesh {
        dimension: Dimension::Planar,
        coordinates: (0..2 * nodes).map(|i| i as f64).collect(),
        cells: Vec::new(),
        point_sets: std::collections::BTreeMap::new(),
    };
    let contents = Contents {
        superelement: &element,
        recovery: Some(&recovery),
        mesh: Some(&mesh),
    };
    let options = WriteOptions {
        compression,
        ..WriteOptions::default()
    };
    write_superelement(path, &contents, &options).unwrap();
    recovery
}

/// The rows of some nodes of the whole.
fn rows_of(whole: &RecoveryBasis, nodes: &[u32]) -> RecoveryBasis {
    let rows: Vec<usize> = (0..whole.dofs.len())
        .filter(|row| nodes.contains(&whole.dofs[*row].node))
        .collect();
    let of = |all: &Mat<f64>| Mat::from_fn(rows.len(), all.ncols(), |i, j| all[(rows[i], j)]);
    RecoveryBasis {
        dofs: rows.iter().map(|row| whole.dofs[*row]).collect(),
        modes: of(&whole.modes),
        residual: of(&whole.residual),
        enrichment: whole.enrichment.as_ref().map(of),
    }
}

/// 51 MB of shapes.
#[test]
fn only_the_datasets_in_use_are_read() {
    alone(|| {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("large.dcb.h5");
        let nodes = 20_000;
        let whole = write_large(&path, nodes, Compression::None);
        assert!(std::fs::metadata(&path).unwrap().len() > 50_000_000);

        let (file, opening) = read_by(|| SuperelementFile::open(&path).unwrap());
        let (element, dynamics) = read_by(|| file.superelement().unwrap());
        assert_eq!(element, synthetic::with_modes(MODES));
        let wanted = [19_999, 7, 8];
        let (basis, first_nodes) = read_by(|| file.recovery_of(&wanted).unwrap().unwrap());
        assert_eq!(basis, rows_of(&whole, &wanted));
        let (basis, other_node) = read_by(|| file.recovery_of(&[12_345]).unwrap().unwrap());
        assert_eq!(basis, rows_of(&whole, &[12_345]));
        let (position, _) = read_by(|| file.node_position(12_345).unwrap());
        assert_eq!(position, Some([24_690.0, 24_691.0, 0.0]));
        assert_eq!(file.node_position(nodes as u32).unwrap(), None);
        assert_eq!(file.node_count(), Some(nodes));
        assert_eq!(file.recovery_of(&[nodes as u32]).unwrap().unwrap().dofs, []);
        let (recovery, everything) = read_by(|| file.recovery().unwrap().unwrap());
        assert_eq!(recovery, whole);

        println!(
            "bytes read: opening {opening}, superelement {dynamics}, three nodes {first_nodes}, one more {other_node}, all fields {everything}"
        );
        if bytes_read().is_none() {
            println!("SKIPPED: the system doesn't count bytes");
            return;
        }
        let dofs = (16 * 3 * nodes) as u64;
        let pages_of_a_column = 106 * 2 * 4096;
        assert!(opening < 300_000, "{opening}");
        assert!(opening + dynamics < 1_000_000, "{dynamics}");
        assert!(
            first_nodes < dofs + 2 * pages_of_a_column + 100_000,
            "{first_nodes}"
        );
        assert!(other_node < pages_of_a_column + 100_000, "{other_node}");
        assert!(everything > 50_000_000, "{everything}");
    });
}

/// 2.1 GB of shapes: needs 5 GB of memory and 2.2 GB of disk.
///
/// `cargo test --release -p dcb-tests --test formats partial_reading:: -- --ignored --nocapture`
#[test]
#[ignore = "writes 2.1 GB"]
fn a_file_of_two_gigabytes_opens_at_once() {
    alone(|| {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("large.dcb.h5");
        let nodes = 850_000;
        let expected = rows_of(&write_large(&path, nodes, Compression::None), &[700_000]);
        assert!(std::fs::metadata(&path).unwrap().len() > 1 << 31);
        let timed = |what: &str, work: &mut dyn FnMut()| {
            let start = Instant::now();
            let ((), bytes) = read_by(work);
            let seconds = start.elapsed().as_secs_f64();
            println!("{what}: {seconds:.4} s, {bytes} bytes");
            seconds
        };
        let mut file = None;
        let opening = timed("opening", &mut || {
            file = Some(SuperelementFile::open(&path).unwrap());
        });
        let file = file.unwrap();
        let dynamics = timed("superelement", &mut || drop(file.superelement().unwrap()));
        timed("one node", &mut || {
            assert_eq!(file.recovery_of(&[700_000]).unwrap().unwrap(), expected);
        });
        let other = timed("another node", &mut || {
            drop(file.recovery_of(&[9]).unwrap())
        });
        timed("all fields", &mut || drop(file.recovery().unwrap()));
        assert!(opening + dynamics < 0.5, "{opening} s, {dynamics} s");
        assert!(other < 0.5, "{other} s");
    });
}

/// Nothing between the rows of a node is looked at, so damage there isn't seen; reading everything finds it.
#[test]
fn only_whole_arrays_are_compared_with_their_hash() {
    let folder = tempfile::tempdir().unwrap();
    for (compression, is_seen) in [(Compression::None, false), (Compression::Deflate, true)] {
        let path = folder.path().join(format!("{compression:?}.dcb.h5"));
        let whole = write_large(&path, 2000, compression);
        let file = SuperelementFile::open(&path).unwrap();
        assert_eq!(
            file.recovery_of(&[5]).unwrap().unwrap(),
            rows_of(&whole, &[5])
        );
        drop(file);
        // Damages the data in the middle of the file: shapes of some other node.
        let mut raw = std::fs::OpenOptions::new().write(true).open(&path).unwrap();
        let length = raw.metadata().unwrap().len();
        raw.seek(SeekFrom::Start(length / 2)).unwrap();
        raw.write_all(&[0x55; 64]).unwrap();
        drop(raw);
        let file = SuperelementFile::open(&path).unwrap();
        assert_eq!(file.recovery_of(&[5]).is_err(), is_seen, "{compression:?}");
        assert!(file.recovery().is_err());
        assert!(file.verify_digests().is_err());
    }
}
