mod accuracy;
mod hard_cases;
mod large_file;
mod motion;
mod scene_driven;
mod speed_against_error;
mod stability;
