//! The programs `reduce` and `simulate`: one file a command. What they begin, say and end with is the same.

pub mod command_page;
mod examples;
mod manual;
mod outcome;
mod own_output;
pub mod program;
pub mod reduce;
pub mod simulate;
mod stop_signal;
