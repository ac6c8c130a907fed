//! The pictures of `docs/accuracy.md` from the lines of `docs/data/motion.jsonl`.

use dcb_report::{Axis, Chart, ReferenceSlope, Scale, Series, Style};
use serde_json::Value;

use crate::pages::{Picture, raw_lines};
use crate::reference::numbers;

const ANGLE: &str = "crank angle [°]";
/// Differences below this aren't drawn: the first steps.
const SMALLEST_DRAWN: f64 = 1e-9;
const DEFLECTION: &str = "deflection / length";

/// Names of the files, and their charts.
pub fn pictures(raw: &str) -> Vec<Picture> {
    let lines = raw_lines(raw);
    let curves = |picture: &str, vertical: &str| chart(ANGLE, vertical, curves(&lines, picture));
    let mut reduced = curves("reduced difference", "largest difference so far");
    reduced.vertical.scale = Scale::Logarithmic;
    for series in &mut reduced.series {
        series.points.retain(|point| point[1] > SMALLEST_DRAWN);
    }
    let mut growth = curves("weak growth", "largest end force [N]");
    growth.horizontal = Axis::linear("steps, a thousandth of a revolution each");
    growth.vertical.scale = Scale::Logarithmic;
    growth
        .series
        .iter_mut()
        .for_each(|series| series.style = Style::LineAndMarks);
    vec![
        (
            "step-convergence.svg".to_owned(),
            vec![step_convergence(&lines)],
        ),
        (
            "unreduced.svg".to_owned(),
            vec![curves("unreduced", DEFLECTION)],
        ),
        (
            "classical.svg".to_owned(),
            vec![
                curves("classical", DEFLECTION),
                curves("classical difference", "largest difference so far"),
            ],
        ),
        (
            "reduced.svg".to_owned(),
            vec![curves("reduced", DEFLECTION), reduced],
        ),
        (
            "weak.svg".to_owned(),
            vec![curves("weak", DEFLECTION), growth],
        ),
        ("order.svg".to_owned(), order(&lines)),
    ]
}

fn chart(horizontal: &str, vertical: &str, series: Vec<Series>) -> Chart {
    Chart {
        title: String::new(),
        horizontal: Axis::linear(horizontal),
        vertical: Axis::linear(vertical),
        series,
        slopes: Vec::new(),
        notes: Vec::new(),
    }
}

fn curves(lines: &[Value], picture: &str) -> Vec<Series> {
    let wanted = |line: &&Value| line["kind"] == "curve" && line["picture"] == picture;
    let series = |line: &Value| {
        let every = line["every"].as_f64().expect("degrees");
        let values = numbers(&line["values"]).into_iter().enumerate();
        Series {
            name: line["name"].as_str().expect("a name").to_owned(),
            points: values.map(|(k, value)| [every * k as f64, value]).collect(),
            style: Style::Line,
        }
    };
    lines.iter().filter(wanted).map(series).collect()
}

fn step_convergence(lines: &[Value]) -> Chart {
    let errors = |modes: u64| -> Vec<[f64; 2]> {
        let wanted = |line: &&Value| line["kind"] == "steps" && line["modes"] == modes;
        let point = |line: &Value| ["steps", "error"].map(|key| line[key].as_f64().expect(key));
        lines.iter().filter(wanted).map(point).collect()
    };
    let series = |name: &str, modes| Series {
        name: name.to_owned(),
        points: errors(modes),
        style: Style::LineAndMarks,
    };
    let mut chart = chart(
        "steps a revolution",
        "error / largest deflection",
        vec![
            series("5 modes + 4 attachments", 5),
            series("all 12 modes", 12),
        ],
    );
    let [steps, error] = chart.series[1].points[3];
    chart.slopes = vec![ReferenceSlope {
        name: "h²".to_owned(),
        exponent: -2.0,
        through: [steps, 0.1 * error],
    }];
    logarithmic(chart)
}

fn logarithmic(mut chart: Chart) -> Chart {
    chart.horizontal = Axis::logarithmic(&chart.horizontal.label);
    chart.vertical = Axis::logarithmic(&chart.vertical.label);
    chart
}

/// One chart for each problem.
fn order(lines: &[Value]) -> Vec<Chart> {
    let lines: Vec<&Value> = lines
        .iter()
        .filter(|line| line["kind"] == "order")
        .collect();
    let charts = lines.chunk_by(|a, b| a["problem"] == b["problem"]);
    charts
        .map(|lines| {
            let series = lines.iter().map(|line| {
                let (steps, errors) = (numbers(&line["steps"]), numbers(&line["errors"]));
                let [quantity, formulation] =
                    ["quantity", "formulation"].map(|key| line[key].as_str().expect(key));
                Series {
                    name: format!("{quantity}, {formulation}"),
                    points: steps.into_iter().zip(errors).map(|(h, e)| [h, e]).collect(),
                    style: Style::LineAndMarks,
                }
            });
            let mut chart = chart("step [s]", "relative error", series.collect());
            chart.title = lines[0]["problem"].as_str().expect("a problem").to_owned();
            let lowest = chart.series.iter().map(|series| series.points[0]);
            let [step, error] = lowest
                .reduce(|a, b| if b[1] < a[1] { b } else { a })
                .expect("a curve");
            chart.slopes = vec![ReferenceSlope {
                name: "h²".to_owned(),
                exponent: 2.0,
                through: [step, 0.5 * error],
            }];
            logarithmic(chart)
        })
        .collect()
}
