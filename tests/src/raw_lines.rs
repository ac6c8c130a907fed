//! Raw lines of measurements, as they stand under `docs/data`.

use serde_json::Value;

/// One JSON value a line.
///
/// # Panics
/// A line isn't JSON.
pub fn raw_lines(raw: &str) -> Vec<Value> {
    raw.lines()
        .map(|line| serde_json::from_str(line).expect("a line of JSON"))
        .collect()
}
