//! `docs/data/python_cost.jsonl` and `docs/data/python_loop.jsonl` as generated parts of `docs/python.md`.

use serde_json::Value;

use super::{Page, raw_lines, table, text};

/// What Python adds to a reduction and to a step.
pub const COST: Page = Page {
    page: "python.md",
    data: "python_cost",
    markers: [
        "<!-- generated from data/python_cost.jsonl -->\n",
        "<!-- end of what is generated from data/python_cost.jsonl -->\n",
    ],
    render: cost,
    pictures: |_| Vec::new(),
};

/// A control law in Python, beside Exudyn.
pub const LOOP: Page = Page {
    page: "python.md",
    data: "python_loop",
    markers: [
        "<!-- generated from data/python_loop.jsonl -->\n",
        "<!-- end of what is generated from data/python_loop.jsonl -->\n",
    ],
    render: control_loop,
    pictures: |_| Vec::new(),
};

fn number(line: &Value, key: &str) -> f64 {
    let value = line.pointer(key).and_then(Value::as_f64);
    value.unwrap_or_else(|| panic!("{key} in {line}"))
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

fn conditions(line: &Value) -> String {
    format!(
        "`{}`, commit {}, {}, {} cores, Python {}; medians.\n\n",
        text(line, "command"),
        text(line, "commit"),
        text(&line["machine"], "cpu"),
        line["machine"]["cores"],
        text(&line["machine"], "python"),
    )
}

fn cost(raw: &str) -> String {
    let lines = raw_lines(raw);
    let of = |kind: &str, key: &str| {
        let own = lines.iter().filter(|line| line["kind"] == kind);
        median(own.map(|line| number(line, key)).collect())
    };
    let row = |what: &str, [without, with]: [f64; 2], ratio: String, limit: &str| {
        let cells = [
            what.to_owned(),
            format!("{without:.1}"),
            format!("{with:.1}"),
            ratio,
        ];
        [&cells[..], &[limit.to_owned()]].concat()
    };
    let step = ["/nanoseconds_inside", "/nanoseconds_by_calls"].map(|key| of("step", key));
    let seconds = ["/program/seconds", "/package/seconds"].map(|key| of("reduction", key));
    let memory = ["/program/memory", "/package/memory"].map(|key| of("reduction", key));
    let reduction = lines.iter().find(|line| line["kind"] == "reduction");
    let dofs = reduction.map_or(0.0, |line| number(line, "/dofs"));
    let ratio = |[without, with]: [f64; 2]| format!("{:.3} times", with / without);
    let rows = [
        row(
            "step of a rigid pendulum, ns",
            step,
            format!("{:+.0} ns", step[1] - step[0]),
            "1000 ns more",
        ),
        row(
            &format!("reduction of {dofs} degrees of freedom, s"),
            seconds,
            ratio(seconds),
            "1.03 times",
        ),
        row("most memory of it, MB", memory, ratio(memory), "1.1 times"),
    ];
    conditions(&lines[0])
        + &table(
            &["", "without Python", "from Python", "Python adds", "limit"],
            &rows,
        )
}

fn control_loop(raw: &str) -> String {
    let lines = raw_lines(raw);
    let mut tools: Vec<String> = Vec::new();
    for line in &lines {
        let tool = text(line, "tool");
        if !tools.contains(&tool) {
            tools.push(tool);
        }
    }
    let of = |tool: &str, key: &str| {
        let own = lines.iter().filter(|line| line["tool"] == *tool);
        median(own.map(|line| number(line, key)).collect())
    };
    let ours = of("tisserand", "/steps_per_second");
    let rows: Vec<Vec<String>> = (tools.iter())
        .map(|tool| {
            let speed = of(tool, "/steps_per_second");
            let line = lines.iter().find(|line| line["tool"] == *tool);
            vec![
                format!(
                    "{tool} {}",
                    line.map_or(String::new(), |line| text(line, "version"))
                ),
                format!("{speed:.0}"),
                format!("{:.1}", ours / speed),
                format!("{:.1e}", of(tool, "/error")),
                format!("{:.0}", of(tool, "/memory_before_and_after/1/0")),
            ]
        })
        .collect();
    conditions(&lines[0])
        + &table(
            &[
                "tool",
                "steps a second",
                "ours / theirs",
                "largest error of the tip, m",
                "most memory, MB",
            ],
            &rows,
        )
        + &format!(
            "\nReferences of the tools, with steps 16 times shorter, are {:.1e} m apart.\n",
            of("tisserand", "/references_apart")
        )
}
