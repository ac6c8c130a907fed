//! Tables and pictures of results: what stands in them is what was computed.

use std::fs;
use std::path::{Path, PathBuf};

use dcb_formats::component::Units;
use dcb_formats::output::Replace;
use dcb_formats::results::{Channel, Header, Outcome, Results, ResultsWriter};
use dcb_runtime::export::csv::write_csv;
use dcb_runtime::export::history::Selection;
use dcb_runtime::export::picture::{Axis, Chart, ReferenceSlope, Series, Style, plot, write_svg};

/// A decaying oscillation, its velocity, a force that is infinite for a while, and an energy.
fn results(folder: &Path, steps: usize) -> PathBuf {
    let path = folder.join("run.h5");
    let channels = [
        Channel::scalar("outputs/midpoint_deflection", "1", "deflection over chord"),
        Channel::vector("outputs/tip", &["x", "y"], "m", "position"),
        Channel::vector("interface_forces/rod/a", &["fx", "fy"], "N", "force"),
        Channel::scalar("energy/kinetic", "J", "kinetic energy"),
    ];
    let header = Header {
        units: Units {
            length: "m".to_owned(),
            mass: "kg".to_owned(),
            time: "s".to_owned(),
        },
        generator: "test".to_owned(),
        scene: serde_json::Value::Null,
        inputs: Vec::new(),
        options: serde_json::Value::Null,
        warnings: Vec::new(),
    };
    let mut writer = ResultsWriter::create(&path, &channels, &header, Replace::Overwrite).unwrap();
    for step in 0..steps {
        let time = 0.0838 * step as f64 / (steps - 1) as f64;
        let wave = (-20.0 * time).exp() * (900.0 * time).sin();
        let force = if (0.03..0.04).contains(&time) {
            f64::NAN
        } else {
            1200.0 * wave
        };
        let row = [
            2.3e-3 * wave,
            time.cos(),
            0.1 / 3.0 * time.sin(),
            force,
            -0.4 * force,
            1e-7 * time,
        ];
        writer.append(time, &row).unwrap();
    }
    writer
        .finish(&Outcome::Complete, &serde_json::Value::Null)
        .unwrap();
    path
}

#[test]
fn a_table_gives_every_number_back_bit_by_bit() {
    let folder = tempfile::tempdir().unwrap();
    let results = Results::open(results(folder.path(), 500)).unwrap();
    let table = folder.path().join("table.csv");
    let names = ["tip", "interface_forces/rod/a", "kinetic", "tip"].map(str::to_owned);
    write_csv(&results, Selection::Named(&names), &table, Replace::Refuse).unwrap();
    let mut reader = csv::Reader::from_path(&table).unwrap();
    assert_eq!(
        reader.headers().unwrap(),
        vec![
            "time [s]",
            "tip.x [m]",
            "tip.y [m]",
            "interface_forces/rod/a.fx [N]",
            "interface_forces/rod/a.fy [N]",
            "energy/kinetic [J]"
        ]
    );
    let rows: Vec<Vec<f64>> = reader
        .records()
        .map(|row| {
            row.unwrap()
                .iter()
                .map(|field| field.parse().unwrap())
                .collect()
        })
        .collect();
    assert_eq!(rows.len(), 500);
    let time = results.time().unwrap();
    let columns = ["tip", "a", "kinetic"].map(|name| results.history(name).unwrap());
    for (step, row) in rows.iter().enumerate() {
        let values = columns
            .iter()
            .flat_map(|history| (0..history.ncols()).map(move |column| history[(step, column)]));
        let expected = std::iter::once(time[step]).chain(values).map(f64::to_bits);
        assert!(
            row.iter().map(|value| value.to_bits()).eq(expected),
            "{step}: {row:?}"
        );
    }

    write_csv(&results, Selection::Outputs, &table, Replace::Overwrite).unwrap();
    let text = fs::read_to_string(&table).unwrap();
    assert!(
        text.starts_with("time [s],midpoint_deflection [1],tip.x [m],tip.y [m]\n"),
        "{text:.100}"
    );
}

#[test]
fn a_misspelt_channel_is_refused_and_no_file_is_left() {
    let folder = tempfile::tempdir().unwrap();
    let results = Results::open(results(folder.path(), 5)).unwrap();
    let path = folder.path().join("out");
    let names = ["midpoint_deflektion".to_owned()];
    for message in [
        write_csv(&results, Selection::Named(&names), &path, Replace::Refuse)
            .unwrap_err()
            .to_string(),
        plot(&results, Selection::Named(&names), &path, Replace::Refuse)
            .unwrap_err()
            .to_string(),
    ] {
        assert!(
            message.contains("did you mean `midpoint_deflection`?"),
            "{message}"
        );
    }
    let nothing = plot(&results, Selection::Named(&[]), &path, Replace::Refuse)
        .unwrap_err()
        .to_string();
    assert!(nothing.contains("no values"), "{nothing}");
    assert!(!path.exists());
}

/// The numbers of the polylines of a colour, in dots.
fn polylines(svg: &str, colour: &str) -> Vec<Vec<[f64; 2]>> {
    svg.split("<polyline")
        .skip(1)
        .filter(|element| element[..element.find("/>").unwrap()].contains(colour))
        .map(|element| {
            let points = element
                .split_once("points=\"")
                .unwrap()
                .1
                .split('"')
                .next()
                .unwrap();
            let pair = |text: &str| {
                let (x, y) = text.split_once(',').unwrap();
                [x.parse().unwrap(), y.parse().unwrap()]
            };
            points.split_whitespace().map(pair).collect()
        })
        .collect()
}

const BLUE: &str = "#0072B2";

#[test]
fn histories_of_one_unit_share_a_chart_and_gaps_interrupt_the_line() {
    let folder = tempfile::tempdir().unwrap();
    let results = Results::open(results(folder.path(), 30_000)).unwrap();
    let path = picture(folder.path(), "histories.svg");
    let names = ["midpoint_deflection", "interface_forces/rod/a", "tip"].map(str::to_owned);
    plot(&results, Selection::Named(&names), &path, Replace::Refuse).unwrap();
    let svg = fs::read_to_string(&path).unwrap();
    for text in [
        "midpoint_deflection [1]",
        "[N]",
        "interface_forces/rod/a.fx",
        "interface_forces/rod/a.fy",
        "time [s]",
    ] {
        assert!(svg.contains(text), "{text}");
    }
    assert_eq!(
        svg.matches("time [s]").count(),
        3,
        "three units, three charts"
    );
    // The first curve of each chart, the forces in two pieces; samples of the legends have two points.
    let pieces: Vec<_> = polylines(&svg, BLUE)
        .into_iter()
        .filter(|line| line.len() > 2)
        .collect();
    assert_eq!(pieces.len(), 4);
    assert!(svg.len() < 1_000_000, "{} bytes for 30000 steps", svg.len());
    let (end, start) = (pieces[1].last().unwrap()[0], pieces[2][0][0]);
    let width = pieces[2].last().unwrap()[0] - pieces[1][0][0];
    let gap = (start - end) / width;
    assert!(
        (gap - 0.01 / 0.0838).abs() < 0.004,
        "a gap of {gap} of the width"
    );
}

#[test]
fn a_power_law_is_straight_and_parallel_to_its_reference() {
    let folder = tempfile::tempdir().unwrap();
    let path = picture(folder.path(), "convergence.svg");
    let power = |name: &str, factor: f64, exponent: f64| Series {
        name: name.to_owned(),
        points: (0..8)
            .map(|k| 1e-2 * 0.5f64.powi(k))
            .map(|h| [h, factor * h.powf(exponent)])
            .collect(),
        style: Style::LineAndMarks,
    };
    let chart = Chart {
        title: "Error against step".to_owned(),
        horizontal: Axis::logarithmic("step h [s]"),
        vertical: Axis::logarithmic("largest error of the deflection [1]"),
        series: vec![
            power("ρ∞ = 0.8", 40.0, 2.0),
            power("ρ∞ = 0", 90.0, 2.0),
            power("Euler <implicit>", 3.0, 1.0),
        ],
        slopes: vec![ReferenceSlope {
            name: "h²".to_owned(),
            exponent: 2.0,
            through: [1e-3, 1e-5],
        }],
        notes: Vec::new(),
    };
    write_svg(&[chart], &path, Replace::Overwrite).unwrap();
    let svg = fs::read_to_string(&path).unwrap();
    assert!(svg.contains("h²") && svg.contains("Euler &lt;implicit&gt;") && svg.contains("10⁻³"));
    let line = polylines(&svg, BLUE)
        .into_iter()
        .find(|line| line.len() == 8)
        .unwrap();
    let slope = |from: [f64; 2], to: [f64; 2]| (to[1] - from[1]) / (to[0] - from[0]);
    let whole = slope(line[0], line[7]);
    for pair in line.windows(2) {
        let deviation = (slope(pair[0], pair[1]) / whole - 1.0).abs();
        assert!(deviation < 0.06, "dots are whole numbers, but {deviation}");
    }
    let dashes = polylines(&svg, "#787878");
    let (first, last) = (dashes[0][0], *dashes.last().unwrap().last().unwrap());
    assert!((slope(first, last) / whole - 1.0).abs() < 0.02);
}

#[test]
fn charts_of_odd_data_are_drawn_without_a_fuss() {
    let folder = tempfile::tempdir().unwrap();
    let path = picture(folder.path(), "odd.svg");
    let series = |name: &str, points: Vec<[f64; 2]>| Series {
        name: name.to_owned(),
        points,
        style: Style::Line,
    };
    let chart = |series: Vec<Series>, vertical: Axis| Chart {
        title: String::new(),
        horizontal: Axis::linear("x"),
        vertical,
        series,
        slopes: Vec::new(),
        notes: Vec::new(),
    };
    let many = (0..17)
        .map(|k| {
            series(
                &format!("mode {k}"),
                (0..50)
                    .map(|x| [f64::from(x), f64::from(k) + (f64::from(x) / 8.0).sin()])
                    .collect(),
            )
        })
        .collect();
    let charts = [
        chart(
            vec![series("constant", vec![[0.0, 3.0], [1.0, 3.0]])],
            Axis::linear("constant [m]"),
        ),
        chart(
            vec![series("one", vec![[0.5, 1e-9]])],
            Axis::linear("one point"),
        ),
        chart(
            vec![series("huge", vec![[0.0, f64::MAX], [1.0, f64::MIN]])],
            Axis::linear("huge"),
        ),
        chart(
            vec![series(
                "nothing",
                vec![[0.0, f64::NAN], [f64::INFINITY, 1.0]],
            )],
            Axis::linear("nothing finite"),
        ),
        chart(
            vec![series(
                "sign",
                vec![[0.0, 1.0], [1.0, -1.0], [2.0, 100.0], [3.0, 0.0]],
            )],
            Axis::logarithmic("sign"),
        ),
        chart(many, Axis::linear("many")),
    ];
    write_svg(&charts, &path, Replace::Overwrite).unwrap();
    let svg = fs::read_to_string(&path).unwrap();
    assert!(!svg.contains("NaN") && !svg.contains("inf"));
    assert!(svg.contains("mode 16"));
}

/// Where a picture goes: to the folder of `DCB_PICTURES`, to be looked at, or to a temporary one.
fn picture(folder: &Path, name: &str) -> PathBuf {
    std::env::var_os("DCB_PICTURES")
        .map_or(folder.to_owned(), PathBuf::from)
        .join(name)
}
