//! Are files written, read and refused as the format says?
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod contradictions;
mod frozen;
