//! Files that are not Matrix Market: told by their content what they are. Nothing is read of them here; `reduce import` does.
//!
//! A file's name says nothing, and no byte of a binary file gets into a message.

use super::header::shown;
use super::number::{self, unsigned};

/// Text at the beginning of a file that is looked at.
const LOOKED_AT: usize = 1 << 20;
/// What reads files of other programs.
const REMEDY: &str = "`reduce` and `reduce import` read such a file as stiffness or mass (docs/import.md); here Matrix Market is expected";

/// What a file is that begins so, and what helps; `None` for text and for unknown formats.
pub(super) fn binary_format(start: &[u8]) -> Option<String> {
    let packed = |program: &str, unpack: &str| {
        format!("compressed with {program}; expected plain text or gzip ({unpack} it first)")
    };
    let kind = match start {
        [b'B', b'Z', b'h', ..] => return Some(packed("bzip2", "bunzip2")),
        [0xfd, b'7', b'z', b'X', b'Z', 0, ..] => return Some(packed("xz", "unxz")),
        [0x28, 0xb5, 0x2f, 0xfd, ..] => return Some(packed("zstd", "unzstd")),
        [0xff, 0xfe, ..] | [0xfe, 0xff, ..] => {
            return Some("UTF-16 text; save it as UTF-8 or ASCII".into());
        }
        [b'P', b'K', 3 | 5, 4 | 6, ..] if is_npz(start) => "a NumPy archive (.npz)",
        [b'P', b'K', 3 | 5, 4 | 6, ..] => {
            return Some("a zip archive; unpack it and name the matrix in it".into());
        }
        [0x93, b'N', b'U', b'M', b'P', b'Y', ..] => "a NumPy array (.npy)",
        _ if start.starts_with(b"MATLAB 7.3") => "a MATLAB file of version 7.3",
        _ if is_matlab(start) => "a MATLAB file (.mat)",
        [0x89, b'H', b'D', b'F', ..] => "an HDF5 file",
        _ if is_petsc(start) => "a PETSc binary file",
        _ if is_op4(start) => "a Nastran OUTPUT4 file (OP4, binary)",
        _ => return None,
    };
    Some(format!("{kind}; {REMEDY}"))
}

/// Likely format of text without a banner, given its first line that isn't blank.
pub(super) fn text_format(text: &[u8], first: &[u8]) -> String {
    if first.is_empty() {
        return "empty file; expected a Matrix Market banner".into();
    }
    let head = &text[..text.len().min(LOOKED_AT)];
    if let Some(kind) = text_kind(head, first) {
        return format!("no banner: this looks like {kind}; {REMEDY}");
    }
    if head.iter().take(1024).any(|byte| is_control(*byte)) {
        return "binary data of a kind that isn't known; expected Matrix Market, which is text"
            .into();
    }
    format!(
        "`{}`; expected the banner `%%MatrixMarket matrix coordinate real symmetric` or the like",
        shown(first)
    )
}

fn text_kind(head: &[u8], first: &[u8]) -> Option<&'static str> {
    if is_op4_text(first_line_untrimmed(head)) {
        return Some("a Nastran OUTPUT4 file (OP4, ASCII)");
    }
    if head.iter().take(1024).any(|byte| is_control(*byte)) {
        return None;
    }
    if is_entry(first) {
        return Some("a matrix of CalculiX or Abaqus (FORMAT=COORDINATE), `row column value`");
    }
    if is_abaqus_input(first) {
        return Some("Abaqus *MATRIX OUTPUT, FORMAT=MATRIX INPUT");
    }
    let starts = |line: &[u8], word: &[u8]| {
        line.get(..word.len())
            .is_some_and(|start| start.eq_ignore_ascii_case(word))
    };
    let lines = || head.split(|&byte| byte == b'\n').map(<[u8]>::trim_ascii);
    let is_dmig = |line: &[u8]| {
        starts(line, b"DMIG") && matches!(line.get(4), Some(b' ' | b'*' | b',' | b'\t'))
    };
    let is_substructure = |line: &[u8]| starts(line, b"*USER ELEMENT") || starts(line, b"*MATRIX,");
    if lines().any(is_dmig) {
        Some("Nastran bulk data with DMIG matrices")
    } else if lines().any(is_substructure) {
        Some("a substructure of Abaqus or CalculiX (*SUBSTRUCTURE MATRIX OUTPUT)")
    } else if is_harwell_boeing(lines().skip(2)) {
        Some("a Harwell-Boeing file (Ansys HBMAT writes such)")
    } else {
        None
    }
}

/// `row column value`.
fn is_entry(line: &[u8]) -> bool {
    let words = line.split(u8::is_ascii_whitespace);
    let words: Vec<&[u8]> = words.filter(|word| !word.is_empty()).collect();
    matches!(words[..], [row, column, value] if is_index(row) && is_index(column) && is_real(value))
}

/// A zip archive whose first member is an array.
fn is_npz(start: &[u8]) -> bool {
    let Some(length) = start.get(26..28) else {
        return false;
    };
    let length = usize::from(u16::from_le_bytes([length[0], length[1]]));
    let name = start.get(30..30 + length);
    name.is_some_and(|name| name.ends_with(b".npy"))
}

/// The 32-bit integer at an offset, in both byte orders.
fn integers_at(start: &[u8], offset: usize) -> Option<[i32; 2]> {
    let bytes = start.get(offset..offset + 4)?.try_into().ok()?;
    Some([i32::from_le_bytes(bytes), i32::from_be_bytes(bytes)])
}

/// Version 4 by its header of five numbers and a name, version 5 by its version and byte order.
fn is_matlab(start: &[u8]) -> bool {
    if start.starts_with(b"MATLAB ") || matches!(start.get(126..128), Some(b"IM" | b"MI")) {
        return start.len() >= 128;
    }
    let numbers = |order: usize| -> Option<[i32; 5]> {
        let at = |index: usize| Some(integers_at(start, 4 * index)?[order]);
        Some([at(0)?, at(1)?, at(2)?, at(3)?, at(4)?])
    };
    [0, 1].into_iter().any(|order| {
        // Type 1000 order + 10 precision + kind; rows; columns; imaginary part; length of the name with its NUL.
        let Some([kind, rows, columns, imaginary, length]) = numbers(order) else {
            return false;
        };
        let is_kind = matches!(kind, 0..=52 | 1000..=1052) && kind % 10 <= 2;
        let name = usize::try_from(length)
            .ok()
            .filter(|length| (2..=64).contains(length))
            .and_then(|length| start.get(20..20 + length));
        let is_name = |name: &[u8]| {
            name.split_last().is_some_and(|(last, letters)| {
                *last == 0
                    && letters
                        .iter()
                        .all(|byte| byte.is_ascii_alphanumeric() || *byte == b'_')
            })
        };
        is_kind
            && rows >= 0
            && columns >= 0
            && matches!(imaginary, 0 | 1)
            && name.is_some_and(is_name)
    })
}

/// A matrix (1211216) or vector (1211214), big-endian, with 32- or 64-bit integers.
fn is_petsc(start: &[u8]) -> bool {
    let is_class = |offset| matches!(integers_at(start, offset), Some([_, 1_211_216 | 1_211_214]));
    is_class(0) || (start.starts_with(&[0; 4]) && is_class(4))
}

/// A Fortran record of 24 or 48 bytes with columns, rows, form, type and a name.
fn is_op4(start: &[u8]) -> bool {
    [(24, 12, [0, 1]), (48, 24, [0, 1])]
        .into_iter()
        .any(|(length, type_at, orders)| {
            orders.into_iter().any(|order| {
                let at = |offset| integers_at(start, offset).map(|both| both[order]);
                // Of 64-bit integers the half that counts comes second in big-endian files.
                let half = if length == 48 && order == 1 { 4 } else { 0 };
                at(0) == Some(length)
                    && at(4 + length as usize) == Some(length)
                    && matches!(at(4 + type_at + half), Some(1..=4))
            })
        })
}

fn is_control(byte: u8) -> bool {
    byte < 0x20 && !matches!(byte, b'\t' | b'\n' | b'\r' | 0x0c) || byte == 0x7f
}

/// The first line as it is: OP4 has fixed columns.
fn first_line_untrimmed(head: &[u8]) -> &[u8] {
    head.split(|&byte| byte == b'\n').next().unwrap_or_default()
}

/// Four integers of eight characters, a name of eight, a format.
fn is_op4_text(line: &[u8]) -> bool {
    let Some(format) = line.get(40..) else {
        return false;
    };
    let is_integer = |field: &[u8]| {
        let field = field.trim_ascii();
        let digits = field.strip_prefix(b"-").unwrap_or(field);
        !digits.is_empty() && digits.iter().all(u8::is_ascii_digit)
    };
    format.trim_ascii_start().starts_with(b"1P,") && line[..32].chunks(8).all(is_integer)
}

/// `node,dof,node,dof,value`; internal nodes are negative.
fn is_abaqus_input(first: &[u8]) -> bool {
    let fields: Vec<&[u8]> = first
        .split(|&byte| byte == b',')
        .map(<[u8]>::trim_ascii)
        .collect();
    let is_label = |field: &[u8]| is_index(field.strip_prefix(b"-").unwrap_or(field));
    matches!(fields[..], [node, dof, other, other_dof, value]
        if is_label(node) && is_index(dof) && is_label(other) && is_index(other_dof) && is_real(value))
}

/// A type such as `RSA` with four numbers, and then formats in parentheses.
fn is_harwell_boeing<'a>(mut from_third: impl Iterator<Item = &'a [u8]>) -> bool {
    let (Some(third), Some(fourth)) = (from_third.next(), from_third.next()) else {
        return false;
    };
    let mut words = third
        .split(u8::is_ascii_whitespace)
        .filter(|word| !word.is_empty());
    let is_type = |word: &[u8]| match word.to_ascii_uppercase()[..] {
        [value, structure, storage] => {
            b"RCPI".contains(&value) && b"SUHZR".contains(&structure) && b"AE".contains(&storage)
        }
        _ => false,
    };
    words.next().is_some_and(is_type) && words.all(is_index) && fourth.starts_with(b"(")
}

fn is_index(word: &[u8]) -> bool {
    matches!(unsigned(word), Ok((_, length)) if length == word.len())
}

fn is_real(word: &[u8]) -> bool {
    matches!(number::real(word), Ok((_, length)) if length == word.len())
}
