//! Files that aren't read: what they are, and the line of another tool that makes something readable of them.
//!
//! Their content is closed or not looked at, so here, and only here, the ending of a name counts: for words, not for reading.

use std::path::Path;

use crate::text::line_blocks::{filled_lines, is_utf16};

/// Endings in lower case, what such a file is, and what helps.
const CLOSED: [(&str, &str, &str); 11] = [
    (
        "sim",
        "an Abaqus .sim file, a closed format",
        "write the matrices as text: *MATRIX OUTPUT, STIFFNESS, MASS, FORMAT=MATRIX INPUT",
    ),
    (
        "odb",
        "an Abaqus output database, a closed format",
        "write the matrices as text: *MATRIX OUTPUT, STIFFNESS, MASS, FORMAT=MATRIX INPUT",
    ),
    (
        "op2",
        "a Nastran OUTPUT2 file",
        "in Python: `m = pyNastran.op2.op2.read_op2(\"job.op2\").matrices; scipy.sparse.save_npz(\"K.npz\", scipy.sparse.coo_array(m[\"KGG\"].data))`; or write OUTPUT4",
    ),
    (
        "full",
        "an Ansys .full file",
        "in Python: `dof_ref, k, m = ansys.mapdl.reader.full.FullFile(\"file.full\").load_km()`; docs/fe-codes/ansys.md has the line that saves them",
    ),
    (
        "sub",
        "an Ansys .sub file",
        "write the matrices of the whole part: docs/fe-codes/ansys.md",
    ),
    (
        "emat",
        "an Ansys file of element matrices",
        "take the assembled ones of the .full file: docs/fe-codes/ansys.md",
    ),
    (
        "rst",
        "an Ansys file of results",
        "the matrices are in the .full file: docs/fe-codes/ansys.md",
    ),
    (
        "mnf",
        "an Adams modal neutral file, a closed format",
        "reduce the FE matrices that it was made from",
    ),
    (
        "fbi",
        "a Simpack flexible body, a closed format",
        "reduce the FE matrices that it was made from",
    ),
    (
        "h3d",
        "an Altair .h3d file, a closed format",
        "let OptiStruct punch the matrices: PARAM,EXTOUT,DMIGPCH",
    ),
    (
        "frd",
        "a CalculiX file of results",
        "store the matrices with *FREQUENCY, SOLVER=MATRIXSTORAGE",
    ),
];

/// Beginnings of packed files, and what unpacks them.
const PACKED: [(&[u8], &str); 3] = [
    (b"BZh", "compressed with bzip2; unpack it with bunzip2"),
    (b"\xfd7zXZ\0", "compressed with xz; unpack it with unxz"),
    (
        b"\x28\xb5\x2f\xfd",
        "compressed with zstd; unpack it with unzstd",
    ),
];

/// Lines at the beginning that may show decimal commas.
const LINES_LOOKED_AT: usize = 4;
/// Digits behind a decimal comma; behind one between fields of labels and directions there are fewer.
const DECIMALS: usize = 4;

/// Whether a line of text has a number such as `1,31817E+06`.
fn has_decimal_comma(line: &[u8]) -> bool {
    let commas = line.iter().enumerate().filter(|(_, byte)| **byte == b',');
    line.is_ascii()
        && commas
            .map(|(at, _)| line.split_at(at))
            .any(|(before, behind)| {
                let digits = behind[1..].iter().take_while(|byte| byte.is_ascii_digit());
                before.last().is_some_and(u8::is_ascii_digit) && digits.count() >= DECIMALS
            })
}

/// What a file of unknown content is, and what helps; `None` where neither its beginning nor its name tells.
pub(crate) fn explanation(path: &Path, start: &[u8]) -> Option<String> {
    if let Some((_, packed)) = PACKED.iter().find(|(magic, _)| start.starts_with(magic)) {
        return Some(format!("is {packed}"));
    }
    if is_utf16(start) {
        return Some("is UTF-16 text; save it as UTF-8 or ASCII".into());
    }
    if filled_lines(start)
        .take(LINES_LOOKED_AT)
        .any(has_decimal_comma)
    {
        return Some("has decimal commas; write the numbers with points".into());
    }
    let ending = path.extension()?.to_str()?.to_ascii_lowercase();
    let (_, what, remedy) = CLOSED.iter().find(|(closed, ..)| *closed == ending)?;
    Some(format!("is {what}, by its name, and isn't read; {remedy}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_formats_are_named_with_what_helps() {
        for (name, told) in [
            ("job.sim", "FORMAT=MATRIX INPUT"),
            ("JOB.OP2", "read_op2"),
            ("file.full", "load_km"),
            ("rod.mnf", "reduce the FE matrices"),
            ("rod.fbi", "reduce the FE matrices"),
        ] {
            let said = explanation(Path::new(name), b"\x01\x02\x03").unwrap_or_default();
            assert!(said.contains(told), "{name}: {said}");
        }
        assert_eq!(explanation(Path::new("part.bin"), b"\x01\x02"), None);
        let comma = explanation(Path::new("part.mtx"), b"1,1, 1,1, 1,318175564e+06\n");
        assert!(comma.is_some_and(|said| said.contains("decimal commas")));
        let labels = b"1,1, 12,3, word\n10,20,300\n";
        assert_eq!(explanation(Path::new("part.mtx"), labels), None);
        let packed = explanation(Path::new("part.mtx"), b"\xfd7zXZ\0\0").unwrap_or_default();
        assert!(packed.contains("unxz"), "{packed}");
    }
}
