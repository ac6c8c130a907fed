//! Many reductions of one part: what each costs, and how far it is off.

use std::path::PathBuf;
use std::sync::atomic::AtomicUsize;

use dcb_report::{Ledger, Start};
use dcb_workflow::part_study::progress::Progress;
use dcb_workflow::part_study::report::Report;
use dcb_workflow::part_study::request::StudyRequest;
use dcb_workflow::part_study::{missing, recorded, run};
use dcb_workflow::progress_bar::Display;
use pyo3::prelude::*;
use serde_json::json;

use crate::error::Failure;
use crate::fence::apart;
use crate::reduction::{Given, Means, Parts};
use crate::threads::with_threads;

/// Rows and text of a study, JSON. Its page and files go to `folder`, which must be there.
#[pyfunction]
pub fn study(
    py: Python<'_>,
    part: Given<'_>,
    request: &str,
    means: &str,
    tolerance: f64,
    folder: PathBuf,
    threads: Option<usize>,
) -> PyResult<String> {
    let parts = Parts::of(py, part)?;
    apart(py, || {
        let component = with_threads(threads, || parts.component())??;
        let request: StudyRequest = serde_json::from_str(request)
            .map_err(|error| Failure::input(format!("options: {error}")))?;
        let study = request.study(&component, Means::of(means)?.memory()?)?;
        let ledger = folder.join("rows.jsonl");
        let scratch = folder.join("timing.dcb.h5");
        let mut ledger = Ledger::open(&ledger, "reduction", &json!({}), Start::Anew)?;
        let planned = missing(&study, &ledger).into_iter().map(|run| run.modes);
        let mut progress = Progress::new(Display::Silent, planned);
        let complete = AtomicUsize::new(0);
        with_threads(threads, || {
            run(
                &study,
                &component,
                &mut ledger,
                &scratch,
                &mut progress,
                &complete,
            )
        })??;
        let lacking = || Failure::input("modes: there is no row to study");
        let (reference, rows) = recorded(&study, &ledger).ok_or_else(lacking)?;
        let report = Report::new(reference, &rows, tolerance);
        report.write(&folder)?;
        Ok(json!({"rows": rows, "text": report.text()}).to_string())
    })
}
