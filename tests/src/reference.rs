//! Reference values that no program of this repository made.

use faer::Mat;
use serde_json::Value;

/// A file of `tests/data/reference`.
pub fn reference(file: &str) -> Value {
    let path = format!("{}/data/reference/{file}", env!("CARGO_MANIFEST_DIR"));
    serde_json::from_str(&std::fs::read_to_string(path).expect("the reference file")).expect("JSON")
}

/// A list of numbers.
pub fn numbers(value: &Value) -> Vec<f64> {
    value
        .as_array()
        .expect("a list")
        .iter()
        .map(|v| v.as_f64().expect("a number"))
        .collect()
}

/// A matrix given as nested or flat list by rows.
pub fn matrix(value: &Value, rows: usize) -> Mat<f64> {
    let list = value.as_array().expect("a list");
    let flat = if list.iter().any(Value::is_array) {
        list.iter().flat_map(numbers).collect()
    } else {
        numbers(value)
    };
    let columns = flat.len() / rows.max(1);
    Mat::from_fn(rows, columns, |i, j| flat[i * columns + j])
}
