//! Tables of integers in binary files: nodes and directions of rows.

use std::path::Path;

use dcb_formats::Error;

use crate::binary::file::BinaryFile;
use crate::binary::hashed::hashed;
use crate::matrix::labels::DOF_REF;
pub use crate::matrix::labels::IntegerTable;
use crate::matrix::matlab::{version5, version73};
use crate::matrix::numpy;

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
        recognises: version5::recognises,
        table: version5::table,
    },
    Format {
        recognises: version73::recognises,
        table: version73::table,
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
