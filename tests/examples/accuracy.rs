//! Measures reductions against dense algebra, one JSON line per quantity; with `--render`, turns such lines
//! (`docs/data/accuracy.jsonl`) into the table of `docs/accuracy.md`.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::type_complexity)]

use std::collections::BTreeMap;

use dcb_tests::accuracy::cases;
use serde_json::Value;

fn main() {
    if std::env::args().any(|argument| argument == "--render") {
        let path = format!("{}/../docs/data/accuracy.jsonl", env!("CARGO_MANIFEST_DIR"));
        print!(
            "{}",
            render(&std::fs::read_to_string(path).expect("docs/data/accuracy.jsonl"))
        );
        return;
    }
    for case in cases() {
        for line in case.measure() {
            println!("{}", line.line());
        }
    }
}

/// One row per part and quantity: the worst over the numbers of modes.
fn render(lines: &str) -> String {
    let mut rows: Vec<(String, u64, String, String, f64, f64, Vec<u64>)> = Vec::new();
    let mut position: BTreeMap<(String, String), usize> = BTreeMap::new();
    for line in lines.lines() {
        let value: Value = serde_json::from_str(line).expect("a line of JSON");
        let text = |key: &str| value[key].as_str().expect(key).to_owned();
        let number = |key: &str| value[key].as_f64().expect(key);
        let kept = value["n_k"].as_u64().expect("n_k");
        let at = *position
            .entry((text("part"), text("quantity")))
            .or_insert_with(|| {
                let n_e = value["n_e"].as_u64().expect("n_e");
                rows.push((
                    text("part"),
                    n_e,
                    text("quantity"),
                    text("oracle"),
                    0.0,
                    0.0,
                    Vec::new(),
                ));
                rows.len() - 1
            });
        let row = &mut rows[at];
        // The measurement closest to its bound.
        if row.6.is_empty() || number("relative_error") / number("bound") > row.4 / row.5 {
            (row.4, row.5) = (number("relative_error"), number("bound"));
        }
        row.6.push(kept);
    }
    let mut table = String::from(
        "| part | n_e | quantity | modes kept | worst relative error | bound | compared with |\n",
    );
    table += "| --- | --- | --- | --- | --- | --- | --- |\n";
    for (part, n_e, quantity, oracle, error, bound, kept) in rows {
        let kept: Vec<String> = kept.iter().map(u64::to_string).collect();
        table += &format!(
            "| {part} | {n_e} | {quantity} | {} | {error:.1e} | {bound:.0e} | {oracle} |\n",
            kept.join(", ")
        );
    }
    table
}
