//! The Python package's native half, `tisserand._native`: arrays in, calls of the crates, arrays out. Everything else is Python in `tisserand/`.

mod arrays;
mod error;
mod fence;
mod linear;
mod mechanism;
mod programs;
mod reduction;
mod results;
mod scene;
mod sparse;
mod study;
mod superelement;
mod threads;

use dcb_reducer::resources::huge_pages::HugePages;
use pyo3::prelude::*;

/// As in the program `reduce`: large blocks in huge pages. Python's own memory isn't touched.
#[global_allocator]
static ALLOCATOR: HugePages = HugePages;

#[pymodule]
fn _native(module: &Bound<'_, PyModule>) -> PyResult<()> {
    threads::remember_process();
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    error::add(module)?;
    module.add_class::<superelement::Superelement>()?;
    module.add_class::<scene::Scene>()?;
    module.add_class::<mechanism::Mechanism>()?;
    module.add_class::<mechanism::Snapshot>()?;
    module.add_class::<linear::LinearSystem>()?;
    module.add_class::<results::Results>()?;
    module.add_function(wrap_pyfunction!(reduction::reduce, module)?)?;
    module.add_function(wrap_pyfunction!(reduction::plan, module)?)?;
    module.add_function(wrap_pyfunction!(study::study, module)?)?;
    module.add_function(wrap_pyfunction!(superelement::inspected, module)?)?;
    module.add_function(wrap_pyfunction!(superelement::compared, module)?)?;
    module.add_function(wrap_pyfunction!(scene::simulate, module)?)?;
    module.add_function(wrap_pyfunction!(linear::linearize, module)?)?;
    module.add_function(wrap_pyfunction!(programs::run_reduce, module)?)?;
    module.add_function(wrap_pyfunction!(programs::run_simulate, module)?)?;
    Ok(())
}
