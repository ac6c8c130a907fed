//! `.dcb.h5`: the file of a superelement, as `docs/format.md` publishes it.
//!
//! [`write_superelement`] writes one, whole or not at all; [`SuperelementFile`] opens one and believes nothing it
//! hasn't checked. HDF5 itself is the work of two libraries: libhdf5 writes; `hdf5-pure`, which is memory-safe,
//! reads whatever HDF5 layout another team's tool chose, within the limits of `hdf5_files`. The table of every path, shape, symbol and unit is in `datasets.rs`; reading, writing, and the checks of
//! shapes all go by it. What a number means mechanically, beyond range, symmetry and agreement of sizes, is left
//! to the reducer and the runtime.

mod assemble;
mod check;
mod contract;
mod data;
mod datasets;
mod names;
mod read;
mod second_order;
mod shapes;
mod sink;
mod units;
mod write;

pub use crate::hdf5_files::FormatVersion;
pub use read::{SuperelementFile, read_superelement};
pub use write::write_superelement;

use crate::mesh::Mesh;
use crate::output::Replace;
use crate::superelement::{RecoveryBasis, Superelement};

#[cfg(target_endian = "big")]
compile_error!("`.dcb.h5` data are little-endian and are read and written without swapping bytes");

/// Attribute `format` of every file.
pub const FORMAT: &str = "dcb-superelement";

/// The version this program writes; it reads every minor version of the same major version.
pub const FORMAT_VERSION: FormatVersion = FormatVersion { major: 1, minor: 6 };

/// How the field arrays (and only they) are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Compression {
    /// Contiguous.
    #[default]
    None,
    /// In chunks, shuffled and deflated.
    Deflate,
}

/// How a superelement is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct WriteOptions {
    /// Treatment of an output that exists already.
    pub replace_existing: Replace,
    /// How the field arrays are stored.
    pub compression: Compression,
}

/// Contents of a file. Without `recovery` and `mesh` it says nothing about the inside of the component:
/// what a supplier hands over to protect a design.
#[derive(Clone, Copy, Debug)]
pub struct Contents<'a> {
    /// Everything that the dynamics needs.
    pub superelement: &'a Superelement,
    /// Nodal shapes.
    pub recovery: Option<&'a RecoveryBasis>,
    /// Geometry.
    pub mesh: Option<&'a Mesh>,
}
