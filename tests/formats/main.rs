//! Are files written, read and refused as the format says?
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod changed_files;
mod claimed_chunks;
mod component_checks;
mod component_description;
mod contradictions;
mod damaged;
mod dcb;
mod derivation;
mod frozen;
mod full_disk;
mod h5py;
mod hdf5_file;
mod hostile;
mod house;
mod matrix_market;
mod other_formats;
mod partial_reading;
mod results;
mod results_axes;
