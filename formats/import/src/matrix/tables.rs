//! Tables of integers in binary files: nodes and directions of rows.

use std::path::Path;

use dcb_formats::Error;

use super::labels::DOF_REF;
pub use super::labels::IntegerTable;
use super::{matlab5, matlab73, numpy};
use crate::binary_file::BinaryFile;
use crate::hashed_file::hashed;

/// Bytes by which a format is recognised.
const LOOKED_AT: u64 = 1 << 12;

/// A format that has tables.
struct Format {
    recognises: fn(&[u8]) -> bool,
    table: fn(&Path, &str) -> Result<Option<IntegerTable>, Error>,
}

/// All of them.
const FORMATS: [Format; 3] = [
    Format {
        recognises: matlab5::recognises,
        table: matlab5::table,
    },
    Format {
        recognises: matlab73::recognises,
        table: matlab73::table,
    },
    Format {
        recognises: numpy::recognises,
        table: numpy::table,
    },
];

/// Reads a table of dofs, and tells the SHA-256 of its file: an array of integers with one or two columns, by its name without regard to
/// case; `dof_ref` where none is given.
///
/// # Errors
/// [`Error::File`] for a file without such arrays, or without that one, and for an array that isn't one; [`Error::Io`].
pub fn read_table(path: &Path, name: Option<&str>) -> Result<(IntegerTable, String), Error> {
    let refused = |message: String| Error::File {
        path: path.into(),
        message,
    };
    hashed(path, || {
        let mut file = BinaryFile::open_parts(path)?;
        let mut start = vec![0; file.remaining().min(LOOKED_AT) as usize];
        file.fill(&mut start)?;
        let format = (FORMATS.iter()).find(|format| (format.recognises)(&start));
        let Some(format) = format else {
            return Err(refused(
                "holds no table of dofs; expected .npz, .npy or .mat".into(),
            ));
        };
        let name = name.unwrap_or(DOF_REF);
        (format.table)(path, name)?.ok_or_else(|| {
            refused(format!(
                "has no array {name:?}; name the table of dofs, as in `FILE#NAME`"
            ))
        })
    })
}
