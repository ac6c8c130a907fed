//! Commands that take superelements.

pub(crate) mod compare;
pub(crate) mod error_report;
pub(crate) mod export;
pub(crate) mod inspect;
pub(crate) mod report;
pub(crate) mod stress_lines;
pub(crate) mod verify;
