//! What the modes leave out: attachments, their residual flexibility and mass, further columns.

pub mod columns;
pub mod dependency;
pub mod enrichment;
pub mod enrichment_source;
pub mod interface_reduction;
pub mod residual;
pub mod residual_filter;
