//! The functions of FMI called as an importer calls them.
#![allow(clippy::unwrap_used, clippy::panic)]

mod history;
mod importer;
mod refusals;
mod saved_states;
#[path = "../support/mod.rs"]
mod support;
