//! Is a reduction what independent algebra says, and its estimates and selections too?
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod closed_forms;
mod completeness;
mod dense_eigen;
mod dense_oracle;
mod diagnosis;
mod enrichment;
mod error_estimate;
mod identities;
mod interfaces;
mod internal_rows;
mod invariance;
mod large_parts;
mod measured;
mod reference_values;
mod regularization;
mod samples;
mod scene_driven;
mod selection;
mod singular_mass;
mod spectra;
mod stress;
mod study;
