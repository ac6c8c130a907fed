//! The functions of FMI 3.0 over a [`dcb_cosimulation::CoSimulation`]: the shared library that `simulate fmu` puts into archives.
//!
//! One library serves every scene: what it simulates stands in the folder of resources that the importer names. Functions that the unit doesn't
//! have (model exchange, scheduled execution, clocks, variables that aren't `Float64`) answer `fmi3Error` with a message. No panic leaves the
//! library: it becomes `fmi3Fatal`, after which only `fmi3FreeInstance` does anything.
//!
//! This is the only crate of the runtime with `unsafe`; all of it reads and writes what pointers of the importer lead to. The functions
//! have the names, arguments and demands on pointers of the standard: instances and states come from this library and aren't freed yet, arrays are as long as
//! the numbers beside them say, texts end with a zero byte.

mod instance;
mod life;
mod saved_states;
mod status;
mod step;
mod unsupported;
mod values;

pub use life::*;
pub use saved_states::*;
pub use status::{LogMessage, Status};
pub use step::*;
pub use unsupported::*;
pub use values::*;

/// The mark of the library, as text in its file.
#[used]
static MARK: &str = dcb_cosimulation::MARK;
