//! Work around reductions and runs: parts reduced for a scene, caches, batches, studies, scenes made small.
//!
//! Everything here asks the reducer and the runtime; neither knows of it, nor of the other.

pub mod batch;
pub mod cache;
pub mod file_form;
pub mod part_study;
pub mod prepare;
pub mod scene;
pub mod scene_study;
pub mod siblings;
