//! `.dcb.h5` there and back, and everything that may go wrong on the way.

use std::fs;
use std::path::Path;

use dcb_formats::dcb::{
    Compression, Contents, FormatVersion, SuperelementFile, WriteOptions, read_superelement,
    write_superelement,
};

use dcb_formats::mesh::Dimension::{self, Planar, Spatial};
use dcb_formats::output::{Replace, check_output};
use dcb_formats::{Error, Superelement};
use dcb_tests::synthetic;

const FORCE: WriteOptions = WriteOptions {
    replace_existing: Replace::Overwrite,
    compression: Compression::None,
};

fn bare(superelement: &Superelement) -> Contents<'_> {
    Contents {
        superelement,
        recovery: None,
        mesh: None,
    }
}

fn write_full(path: &Path, dimension: Dimension, compression: Compression) -> Superelement {
    let superelement = synthetic::enriched(dimension);
    synthetic::write(path, &superelement, compression).unwrap();
    superelement
}

/// Angles lose a digit on their way through atan2, nothing else does.
fn assert_same(found: &Superelement, right: &Superelement) {
    let mut found = found.clone();
    for (found, right) in found.interfaces.iter_mut().zip(&right.interfaces) {
        for (a, b) in found
            .orientation
            .iter()
            .flatten()
            .zip(right.orientation.iter().flatten())
        {
            assert!((a - b).abs() < 1e-15, "{a} {b}");
        }
        found.orientation = right.orientation;
    }
    assert_eq!(&found, right);
}

fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<_> = fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}

#[test]
fn everything_comes_back() {
    let folder = tempfile::tempdir().unwrap();
    for dimension in [Planar, Spatial] {
        for compression in [Compression::None, Compression::Deflate] {
            let path = folder.path().join("rod.dcb.h5");
            let right = write_full(&path, dimension, compression);
            let file = SuperelementFile::open(&path).unwrap();
            assert_same(&file.superelement().unwrap(), &right);
            assert_eq!(
                file.recovery().unwrap().unwrap(),
                synthetic::recovery(&right)
            );
            assert_eq!(file.mesh().unwrap().unwrap(), synthetic::mesh(dimension));
            assert_eq!(file.format_version(), FormatVersion { major: 1, minor: 6 });
            assert_eq!(file.digest().len(), 64);
            assert!(file.verify_digests().unwrap() > 30);
            assert_eq!(names(folder.path()), ["rod.dcb.h5"]);
        }
    }
}

#[test]
fn without_fields_nothing_of_the_inside_is_left() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("rod.dcb.h5");
    for dimension in [Planar, Spatial] {
        let right = synthetic::superelement(dimension);
        write_superelement(&path, &bare(&right), &FORCE).unwrap();
        let file = SuperelementFile::open(&path).unwrap();
        assert_same(&file.superelement().unwrap(), &right);
        assert_eq!(file.recovery().unwrap(), None);
        assert_eq!(file.mesh().unwrap(), None);
    }
}

#[test]
fn the_same_superelement_gives_the_same_bytes_and_digest() {
    let folder = tempfile::tempdir().unwrap();
    let (a, b) = (
        folder.path().join("a.dcb.h5"),
        folder.path().join("b.dcb.h5"),
    );
    write_full(&a, Spatial, Compression::None);
    write_full(&b, Spatial, Compression::None);
    assert_eq!(fs::read(&a).unwrap(), fs::read(&b).unwrap());
    let plain = SuperelementFile::open(&a).unwrap().digest().to_owned();
    write_full(&b, Spatial, Compression::Deflate);
    assert_eq!(
        SuperelementFile::open(&b).unwrap().digest(),
        plain,
        "compression doesn't change the digest"
    );
}

#[test]
fn no_modes_and_no_interfaces_are_fine() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("rigid.dcb.h5");
    for dimension in [Planar, Spatial] {
        let mut rigid = synthetic::superelement(dimension);
        let d = dimension.coordinate_count();
        let axes = rigid.inertia.l3.len();
        rigid.interfaces.clear();
        rigid.rows.clear();
        rigid.modes.eigenvalues.clear();
        rigid.modes.damping.clear();
        rigid.modes.interface_shapes = faer::Mat::zeros(0, 0);
        rigid.residual.flexibility = faer::Mat::zeros(0, 0);
        rigid.residual.mass = faer::Mat::zeros(0, 0);
        rigid.residual.mass_diagonal0.clear();
        rigid.residual.transform = faer::Mat::zeros(0, 0);
        rigid.residual.sigma_squared.clear();
        rigid.residual.output_shapes = None;
        rigid.inertia.l1 = faer::Mat::zeros(d, 0);
        rigid.inertia.i1.clear();
        rigid.inertia.i3 = faer::Mat::zeros(axes, 0);
        rigid.inertia.l3 = vec![faer::Mat::zeros(0, 0); axes];
        rigid.inertia.i2 = vec![faer::Mat::zeros(0, 0); if dimension == Planar { 0 } else { 6 }];
        write_superelement(&path, &bare(&rigid), &FORCE).unwrap();
        assert_eq!(read_superelement(&path).unwrap(), rigid);
        SuperelementFile::open(&path)
            .unwrap()
            .verify_digests()
            .unwrap();
    }
}

#[test]
fn an_existing_output_stays_unless_it_may_be_replaced() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("rod.dcb.h5");
    fs::write(&path, "mine").unwrap();
    let rod = synthetic::superelement(Planar);
    let refused = write_superelement(&path, &bare(&rod), &WriteOptions::default()).unwrap_err();
    assert!(matches!(refused, Error::OutputExists { .. }), "{refused}");
    assert!(matches!(
        check_output(&path, Replace::Refuse),
        Err(Error::OutputExists { .. })
    ));
    assert_eq!(fs::read(&path).unwrap(), b"mine");
    check_output(&path, Replace::Overwrite).unwrap();
    write_superelement(&path, &bare(&rod), &FORCE).unwrap();
    read_superelement(&path).unwrap();
    assert_eq!(names(folder.path()), ["rod.dcb.h5"]);
}

#[test]
fn a_refused_superelement_leaves_the_old_file_and_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("rod.dcb.h5");
    fs::write(&path, "mine").unwrap();
    let mut rod = synthetic::superelement(Planar);
    rod.residual.mass[(0, 1)] += 1.0;
    let message = write_superelement(&path, &bare(&rod), &FORCE)
        .unwrap_err()
        .to_string();
    assert!(
        message.contains("/residual/mass") && message.contains("symmetric"),
        "{message}"
    );
    rod = synthetic::superelement(Planar);
    rod.modes.eigenvalues[1] = f64::NAN;
    let message = write_superelement(&path, &bare(&rod), &FORCE)
        .unwrap_err()
        .to_string();
    assert!(message.contains("/modes/eigenvalues"), "{message}");
    assert_eq!(fs::read(&path).unwrap(), b"mine");
    assert_eq!(names(folder.path()), ["rod.dcb.h5"]);
}

#[test]
fn a_folder_or_a_missing_folder_is_no_output() {
    let folder = tempfile::tempdir().unwrap();
    let rod = synthetic::superelement(Planar);
    let missing = folder.path().join("no/such/rod.dcb.h5");
    for (path, words) in [
        (folder.path(), "is a folder"),
        (missing.as_path(), "doesn't exist"),
    ] {
        for replace in [Replace::Refuse, Replace::Overwrite] {
            let message = check_output(path, replace).unwrap_err().to_string();
            assert!(message.contains(words), "{message}");
        }
        let message = write_superelement(path, &bare(&rod), &FORCE)
            .unwrap_err()
            .to_string();
        assert!(message.contains(words), "{message}");
    }
    assert!(names(folder.path()).is_empty());
}

/// Two programs with one process number, as in two containers, are two threads of one process.
#[test]
fn writers_of_one_output_never_touch_each_others_files() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("rod.dcb.h5");
    let rod = synthetic::superelement(Planar);
    for options in [WriteOptions::default(), FORCE] {
        for _ in 0..20 {
            let write = || write_superelement(&path, &bare(&rod), &options);
            let (one, other) = std::thread::scope(|scope| {
                let other = scope.spawn(write);
                (write(), other.join().unwrap())
            });
            let refused = [&one, &other].map(|told| match told {
                Ok(()) => 0,
                Err(Error::OutputExists { .. }) => 1,
                Err(error) => panic!("{error}"),
            });
            let expected = usize::from(options.replace_existing == Replace::Refuse);
            assert_eq!(refused.iter().sum::<usize>(), expected);
            SuperelementFile::open(&path)
                .unwrap()
                .verify_digests()
                .unwrap();
            assert_eq!(names(folder.path()), ["rod.dcb.h5"]);
            fs::remove_file(&path).unwrap();
        }
    }
}
