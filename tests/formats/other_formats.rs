//! Files of other programs, given where Matrix Market is expected: each is named by its content, and none of its bytes are shown.

use dcb_formats::matrix::{check_operator_header, read_matrix, read_symmetric_operator};

use crate::matrix_market::gzip;

/// The refusal of a file, which is the same for every reader, plain or gzipped, under whatever name.
fn refusal(content: &[u8]) -> String {
    let folder = tempfile::tempdir().unwrap();
    let mut messages = Vec::new();
    let packed = gzip(content);
    for (name, bytes) in [
        ("k.mtx", content),
        ("k.npz", content),
        ("k.mtx.gz", &packed),
    ] {
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        let shown = path.display().to_string();
        let errors = [
            read_matrix(&path).map(drop),
            read_symmetric_operator(&path).map(drop),
            check_operator_header(&path),
        ];
        for error in errors {
            let message = error.expect_err("expected a refusal").to_string();
            messages.push(message.replace(&shown, "FILE"));
        }
    }
    messages.dedup();
    let [message] = &messages[..] else {
        panic!("refused differently: {messages:?}");
    };
    let is_clean = |letter: char| !letter.is_control() && letter != '\u{fffd}';
    assert!(message.chars().all(is_clean), "{message:?}");
    assert!(
        message.len() < 450,
        "{} characters: {message}",
        message.len()
    );
    message.clone()
}

#[track_caller]
fn assert_named(content: impl AsRef<[u8]>, name: &str, remedy: &str) {
    let message = refusal(content.as_ref());
    assert!(message.contains(name), "no {name:?} in {message}");
    assert!(message.contains(remedy), "no {remedy:?} in {message}");
}

/// 32-bit integers, then bytes.
fn record(numbers: &[i32], big_endian: bool, rest: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::new();
    for number in numbers {
        bytes.extend(match big_endian {
            true => number.to_be_bytes(),
            false => number.to_le_bytes(),
        });
    }
    [&bytes, rest].concat()
}

const PAGE: &str = "`reduce import` read such a file";

#[test]
fn nastran() {
    for big_endian in [false, true] {
        let end = record(&[24, 652, 1, 0, 160], big_endian, b"\x01\x02\xff");
        let narrow = record(&[24, 240, -240, 6, 2], big_endian, b"KGG     ");
        assert_named([narrow, end].concat(), "OUTPUT4 file (OP4, binary)", PAGE);
        let wide = |number: i32| match big_endian {
            true => [0, number],
            false => [number, 0],
        };
        let numbers = [vec![48], [240, 240, 2, 2].map(wide).concat()].concat();
        let name = b"C1              ";
        let end = record(&[48, 652], big_endian, &[0; 24]);
        let bytes = [record(&numbers, big_endian, name), end].concat();
        assert_named(bytes, "OUTPUT4 file (OP4, binary)", PAGE);
    }
    for header in [
        &b"     240    -240       6       2KGG     1P,3E23.16\n"[..],
        b"      31     -25       2       21MAT\x00\x00\x00\x001P,5E16.9\n",
        b"10000001      25       2       2RMAT    1P,3E23.16|I16\n",
    ] {
        let text = [header, b"       1       0     160\n       7       1\n"].concat();
        assert_named(text, "OUTPUT4 file (OP4, ASCII)", PAGE);
    }
    for text in [
        "\n$-----\n$ DMIG Matrix KAAX\nDMIG*               KAAX               0               6               2\n",
        "$TITLE\r\nBEGIN SUPER      101\r\nGRID           3\r\nDMIG        KAAX       0       6       1       0\r\n",
        "dmig,kaax,0,6,1,0\n",
    ] {
        assert_named(text, "bulk data with DMIG matrices", PAGE);
    }
}

#[test]
fn harwell_boeing() {
    for (kind, formats) in [
        ("RSA", "(1I14)          (1I14)          (1D25.15)"),
        ("rua", "(10I8)          (10I8)          (1P,3E25.16)"),
    ] {
        let text = format!(
            "stiffness matrix\n         19437           241          9478          9478             0\n\
             {kind}                      240           240          9478             0\n{formats}\n             1\n"
        );
        assert_named(text, "Harwell-Boeing file", PAGE);
    }
}

#[test]
fn matlab() {
    let mut header = b"MATLAB 5.0 MAT-file Platform: posix".to_vec();
    header.resize(124, b' ');
    for end in [b"\x00\x01IM", b"\x01\x00MI"] {
        let bytes = [&header[..], end, b"\x0f\0\0\0\xe7\x07\0\0x\x9c"].concat();
        assert_named(bytes, "MATLAB file (.mat)", PAGE);
    }
    for big_endian in [false, true] {
        let kind = i32::from(big_endian) * 1000 + 2;
        let bytes = record(&[kind, 18717, 3, 0, 2], big_endian, b"K\0\0\0\0\xf0\x3f");
        assert_named(bytes, "MATLAB file (.mat)", PAGE);
    }
    let mut hdf = b"MATLAB 7.3 MAT-file, Platform: GLNXA64".to_vec();
    hdf.resize(512, 0);
    hdf.extend(b"\x89HDF\r\n\x1a\n");
    assert_named(hdf, "MATLAB file of version 7.3", PAGE);
}

#[test]
fn python_and_petsc() {
    let member = |name: &[u8]| {
        let head =
            b"PK\x03\x04\x2d\0\0\0\x08\0\0\0\x21\0\x4d\xcf\x88\x1b\xff\xff\xff\xff\xff\xff\xff\xff";
        let lengths = [name.len() as u8, 0, 0x14, 0];
        [head, &lengths[..], name, b"\x01\0\x10\0"].concat()
    };
    assert_named(member(b"indices.npy"), "(.npz)", PAGE);
    assert_named(member(b"part.mtx"), "a zip archive", "unpack it");
    let array = b"\x93NUMPY\x01\0\x76\0{'descr': '<f8'";
    assert_named(array, "(.npy)", PAGE);
    for class in [1_211_216, 1_211_214] {
        let bytes = record(&[class, 240, 240, 18716, 60], true, b"");
        assert_named(bytes, "PETSc binary file", PAGE);
        let wide = record(&[0, class, 0, 240, 0, 240], true, b"");
        assert_named(wide, "PETSc binary file", PAGE);
    }
    assert_named(b"\x89HDF\r\n\x1a\n\0\0", "an HDF5 file", PAGE);
}

#[test]
fn packed_or_unknown() {
    assert_named(b"BZh91AY&SY\x01", "compressed with bzip2", "bunzip2 it");
    assert_named(b"\xfd7zXZ\0\0\x04", "compressed with xz", "unxz it");
    assert_named(b"\x28\xb5\x2f\xfd\x04", "compressed with zstd", "unzstd it");
    assert_named(b"\xff\xfe%\0%\0M\0", "UTF-16 text", "save it as UTF-8");
    assert_named(
        b"\x64\0\0\0\x80junk\xff\x01",
        "binary data of a kind that isn't known",
        "expected Matrix Market",
    );
    assert_named("*HEADING\n", "`*HEADING`", "expected the banner");
}

/// `row column value` without a banner.
#[test]
fn coordinates() {
    for text in [
        "1 1  1.3181755644047e+06\n1 2  1.8020104895105e+05\n",
        "1 1 8.05e-07\n2 2 8.05e-07\n",
    ] {
        assert_named(text, "CalculiX or Abaqus (FORMAT=COORDINATE)", PAGE);
    }
}

#[test]
fn abaqus_with_labels() {
    for line in [
        "1,1, 1,1,  8.2e+09\n",
        "-1,1, -1,1,  9.999999999999946e+06\n",
    ] {
        assert_named(line, "FORMAT=MATRIX INPUT", PAGE);
    }
    let text = "**\n** GENERATION OF SUBSTRUCTURE Z1\n*USER ELEMENT, NODES=         6, LINEAR\n** ELEMENT NODES\n";
    assert_named(text, "(*SUBSTRUCTURE MATRIX OUTPUT)", PAGE);
}
