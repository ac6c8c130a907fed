//! Files to the disk, whole or not at all.

mod text;
mod together;
mod unfinished;
mod whole_file;

pub use text::{write_json, write_text};
pub use together::{WholeFile, write_together};
pub use unfinished::{UnfinishedFolder, remove_leftover, remove_leftovers, remove_unfinished};
pub(crate) use whole_file::write_whole;
pub use whole_file::{Counted, Stream, check_output, copy_whole, is_same_file, write_stream};

/// Treatment of an output that exists already.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Replace {
    /// Leave it and say so.
    #[default]
    Refuse,
    /// Put the new file in its place, once that is complete.
    Overwrite,
}
