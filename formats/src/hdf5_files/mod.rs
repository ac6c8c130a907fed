//! HDF5 files from anybody and to the disk, whatever is in them: sizes are compared with the file before memory is taken.

pub(crate) mod attributes;
pub mod container;
pub(crate) mod create;
pub(crate) mod digest;
pub(crate) mod element;
pub(crate) mod inventory;
pub mod storage;
pub(crate) mod version;

pub use create::write_hdf5;
pub use version::FormatVersion;
