//! Work around reductions and runs: parts reduced for a scene, caches, batches, studies, scenes made small, pages to look at.
//!
//! Everything here asks the reducer and the runtime; neither knows of it, nor of the other.

/// Result of a step; the caller ends with `Ok(None)` where the user stopped it.
macro_rules! unless_stopped {
    ($step:expr) => {
        match $step {
            Some(found) => found,
            None => return Ok(None),
        }
    };
}

pub mod batch;
pub mod cache;
pub mod part_page;
pub mod part_study;
pub mod prepare;
pub mod scene;
pub mod scene_page;
pub mod scene_study;

mod drawn_interfaces;
mod inverse_root;
mod lock_file;
mod page_room;
mod plain_words;
pub mod progress_bar;
pub mod shard;
mod workers;

// No part of the door: for the other crates of this workspace and its tests.
#[doc(hidden)]
pub mod file_form;
#[doc(hidden)]
pub mod siblings;
