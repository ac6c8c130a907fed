//! Residual of the modes: attachments, their residual flexibility and mass, further columns.

pub(crate) mod columns;
pub(crate) mod dependency;
pub(crate) mod enrichment;
pub(crate) mod enrichment_source;
pub mod interface_reduction;
pub(crate) mod omitted_stress;
pub(crate) mod residual;
pub(crate) mod residual_filter;
