//! Exports against the superelements that they were made from, against files of the same part by other programs, and against finite elements.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod numbers;
mod refusals;
mod support;
