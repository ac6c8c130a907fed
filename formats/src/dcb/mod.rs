//! `.dcb.h5`: the file of a superelement, as `docs/format.md` publishes it.
//!
//! [`write_superelement`] writes one, whole or not at all; [`SuperelementFile`] opens one and believes nothing it
//! hasn't checked. HDF5 itself is the work of two libraries: libhdf5 writes; `hdf5-pure`, which is memory-safe,
//! reads whatever HDF5 layout another team's tool chose, within the limits that `container.rs`, `inventory.rs` and
//! `storage.rs` set. The table of every path, shape, symbol and unit is in `datasets.rs`; reading, writing, and the checks of
//! shapes all go by it. What a number means mechanically, beyond range, symmetry and agreement of sizes, is left
//! to the reducer and the runtime.

mod assemble;
pub(crate) mod attributes;
mod check;
mod check_fields;
pub(crate) mod container;
pub(crate) mod contract;
pub(crate) mod create;
mod data;
mod datasets;
pub(crate) mod digest;
pub(crate) mod inventory;
mod names;
pub(crate) mod output;
mod read;
mod rules;
mod second_order;
pub(crate) mod shapes;
mod sink;
mod storage;
mod unfinished;
mod units;
mod write;
mod write_fields;

pub use output::{Counted, Stream, check_output, copy_whole, is_same_file, write_stream};
pub use read::{SuperelementFile, read_superelement};
pub use unfinished::{UnfinishedFolder, remove_leftover, remove_leftovers, remove_unfinished};
pub use write::write_superelement;

use crate::mesh::Mesh;
use crate::superelement::{RecoveryBasis, Superelement};

#[cfg(target_endian = "big")]
compile_error!("`.dcb.h5` data are little-endian and are read and written without swapping bytes");

/// What the attribute `format` of every file says.
pub const FORMAT: &str = "dcb-superelement";

/// The version this program writes; it reads every minor version of the same major version.
pub const FORMAT_VERSION: FormatVersion = FormatVersion { major: 1, minor: 3 };

/// Version of the format: the major one changes what old readers rely on, the minor one only adds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct FormatVersion {
    /// Changes what old readers rely on.
    pub major: u32,
    /// Adds what old readers may ignore.
    pub minor: u32,
}

impl std::fmt::Display for FormatVersion {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}.{}", self.major, self.minor)
    }
}

/// How the field arrays (and only they) are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Compression {
    /// Contiguous.
    #[default]
    None,
    /// In chunks, shuffled and deflated.
    Deflate,
}

/// What to do where the output exists already.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Replace {
    /// Leave it and say so.
    #[default]
    Refuse,
    /// Put the new file in its place, once that is complete.
    Overwrite,
}

/// How a superelement is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct WriteOptions {
    /// What to do where the output exists already.
    pub replace_existing: Replace,
    /// How the field arrays are stored.
    pub compression: Compression,
}

/// What a file is to hold. Without `recovery` and `mesh` it says nothing about the inside of the component:
/// what a supplier hands over to protect a design.
#[derive(Clone, Copy, Debug)]
pub struct Contents<'a> {
    /// What the dynamics needs.
    pub superelement: &'a Superelement,
    /// Nodal shapes.
    pub recovery: Option<&'a RecoveryBasis>,
    /// Geometry.
    pub mesh: Option<&'a Mesh>,
}
