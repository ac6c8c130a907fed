//! Pages of `docs/` with parts that are rendered from the raw lines in `docs/data`.

pub mod accuracy;
pub mod hard_cases;
pub mod large_file;
pub mod motion;
pub mod scene_driven;
pub mod scene_reduction;
pub mod speed_against_error;
