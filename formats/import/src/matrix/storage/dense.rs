//! Matrices that are stored in full, row after row or column after column: their zeros are no entries.

use dcb_formats::Error;

use crate::matrix::storage::collected::Collected;
use crate::matrix::storage::compressed::Along;
use crate::matrix::storage::number::Number;
use crate::matrix::storage::stream::{Stream, each_reals};
use crate::stored::Content;

/// A square matrix from all its numbers.
///
/// # Errors
/// Those of the stream; values that aren't finite, by their place.
pub(crate) fn dense(
    stream: &mut (impl Stream + ?Sized),
    number: Number,
    along: Along,
    size: u32,
) -> Result<Content, Error> {
    let mut collected = Collected::default();
    let (mut line, mut across) = (0, 0);
    each_reals(
        stream,
        number,
        u64::from(size) * u64::from(size),
        |_, batch| {
            for &value in batch {
                if value != 0.0 {
                    let (row, column) = along.place(line, across);
                    collected.add(row, column, value)?;
                }
                across += 1;
                if across == size {
                    (line, across) = (line + 1, 0);
                }
            }
            Ok(())
        },
    )?;
    Ok(collected.content())
}
