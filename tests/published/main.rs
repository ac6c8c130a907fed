//! Do mechanisms move as published results say, and do the pages show what was measured?
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod closed_form_motions;
mod equivalent_models;
mod flyball_governor;
mod ivp_slider_crank;
mod order;
mod pages;
mod rigid_benchmarks;
mod sample_scene;
mod slider_crank;
mod stiffening;
