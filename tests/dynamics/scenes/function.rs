//! Functions of time against central differences, closed forms and each other.

use dcb_formats::function::{Function, Harmonic, InputSignal, Interpolation, Table, TimeFunction};

fn from_json(text: &str) -> Function {
    serde_json::from_str(text).unwrap()
}

fn ready(text: &str) -> TimeFunction {
    TimeFunction::new(&from_json(text)).unwrap()
}

fn refusal(text: &str) -> String {
    TimeFunction::new(&from_json(text)).unwrap_err().to_string()
}

fn value(function: &TimeFunction, time: f64) -> f64 {
    function.evaluate(time, 0.0).value
}

const SMOOTH: [&str; 10] = [
    r#"{"polynomial": [1, -2, 0.5, 0.25]}"#,
    r#"{"harmonic": {"amplitude": 2, "frequency_hz": 0.7, "phase": 0.4, "offset": -1}}"#,
    r#"{"harmonic": {"amplitude": 2, "angular_frequency": 3}}"#,
    r#"{"table": {"times": [0, 0.3, 1, 1.5, 3], "values": [0, 1, -1, 0.5, 2]}}"#,
    r#"{"table": {"times": [0, 0.3, 1, 1.5, 3], "values": [0, 1, -1, 0.5, 2], "interpolation": "spline"}}"#,
    r#"{"formula": "0.5*sin(3*t)^2"}"#,
    r#"{"formula": "exp(-t/2)*cos(2*pi*t) - (t + 1)^-1.5 + 2^t + (1+t)^t"}"#,
    r#"{"formula": "atan(t)*tanh(t - 1) + ln(2 + t)/sqrt(t + 1) - log10(t+2) + abs(t - 7)"}"#,
    r#"{"formula": "sinh(t/2) + cosh(t/3) - tan(t/4) + asin(t/5)*acos(t/6)"}"#,
    r#"{"formula": "-e^-(t^2)/3"}"#,
];

#[test]
fn derivatives_are_those_of_central_differences() {
    let step = 1e-4;
    for text in SMOOTH {
        let function = ready(text);
        for time in [0.11, 0.7, 1.234, 2.2] {
            let here = function.evaluate(time, 0.0);
            let (after, before) = (value(&function, time + step), value(&function, time - step));
            let rate = (after - before) / (2.0 * step);
            let second = (after - 2.0 * here.value + before) / (step * step);
            assert!(
                (rate - here.rate).abs() < 2e-6,
                "{text} at {time}: {rate} {here:?}"
            );
            assert!(
                (second - here.second_rate).abs() < 2e-5,
                "{text} at {time}: {second} {here:?}"
            );
        }
    }
}

#[test]
fn a_formula_reads_as_on_paper() {
    for (formula, at_two) in [
        ("-t^2", -4.0),
        ("2^3^t", 512.0),
        ("2^-t", 0.25),
        ("2*-t", -4.0),
        ("1 - t - 3", -4.0),
        ("12/t/3", 2.0),
        ("--t", 2.0),
        ("1e-3*t + 2.5E2 + .5", 250.502),
        ("(t)", 2.0),
        (" t\n+ 1 ", 3.0),
        ("cos(pi) + ln(e)", 0.0),
        ("abs(-t)", 2.0),
    ] {
        let function = TimeFunction::new(&Function::Formula(formula.into())).unwrap();
        assert!(
            (value(&function, 2.0) - at_two).abs() < 1e-13,
            "{formula}: {}",
            value(&function, 2.0)
        );
    }
}

#[test]
fn powers_of_zero_and_of_negative_bases_have_their_derivatives() {
    let square = ready(r#"{"formula": "sin(3*t)^2"}"#).evaluate(0.0, 0.0);
    assert_eq!(
        (square.value, square.rate, square.second_rate),
        (0.0, 0.0, 18.0)
    );
    let line = ready(r#"{"formula": "(t - 1)^1"}"#).evaluate(1.0, 0.0);
    assert_eq!((line.value, line.rate, line.second_rate), (0.0, 1.0, 0.0));
    let cube = ready(r#"{"formula": "(t - 3)^3"}"#).evaluate(1.0, 0.0);
    assert_eq!(
        (cube.value, cube.rate, cube.second_rate),
        (-8.0, 12.0, -12.0)
    );
}

#[test]
fn a_spline_is_natural_smooth_and_passes_through_its_points() {
    let (times, values) = ([0.0, 0.3, 1.0, 1.5, 3.0], [0.0, 1.0, -1.0, 0.5, 2.0]);
    let spline = TimeFunction::new(&Function::Table(Table {
        times: times.to_vec(),
        values: values.to_vec(),
        interpolation: Interpolation::Spline,
    }))
    .unwrap();
    for (time, given) in times.into_iter().zip(values) {
        let tiny = 1e-9;
        let here = spline.evaluate(time, 0.0);
        assert!((here.value - given).abs() < 1e-14);
        if time > 0.0 && time < 3.0 {
            let (before, after) = (
                spline.evaluate(time - tiny, 0.0),
                spline.evaluate(time + tiny, 0.0),
            );
            assert!((after.rate - before.rate).abs() < 1e-6);
            assert!((after.second_rate - before.second_rate).abs() < 1e-6);
        }
    }
    assert!(spline.evaluate(1e-12, 0.0).second_rate.abs() < 1e-9);
    assert!(spline.evaluate(3.0 - 1e-12, 0.0).second_rate.abs() < 1e-9);
    for (outside, end) in [(-4.0, 0.0), (9.0, 2.0)] {
        let there = spline.evaluate(outside, 0.0);
        assert_eq!(
            (there.value, there.rate, there.second_rate),
            (end, 0.0, 0.0)
        );
    }
}

#[test]
fn two_points_make_a_straight_line_either_way() {
    for kind in ["spline", "linear"] {
        let line = ready(&format!(
            r#"{{"table": {{"times": [1, 3], "values": [0, 4], "interpolation": "{kind}"}}}}"#
        ));
        let here = line.evaluate(1.5, 0.0);
        assert_eq!((here.value, here.rate, here.second_rate), (1.0, 2.0, 0.0));
    }
}

#[test]
fn an_integral_vanishes_at_zero_and_has_the_function_as_its_rate() {
    for text in SMOOTH {
        let function = ready(text);
        let integral = TimeFunction::integral_of(&from_json(text), 3.0).unwrap();
        assert!(value(&integral, 0.0).abs() < 1e-15, "{text}");
        let mut simpson = 0.0;
        let panels = 6000;
        let width = 3.0 / panels as f64;
        for panel in 0..panels {
            let start = panel as f64 * width;
            simpson += width / 6.0
                * (value(&function, start)
                    + 4.0 * value(&function, start + 0.5 * width)
                    + value(&function, start + width));
            if panel % 1000 == 999 {
                let (time, here) = (start + width, function.evaluate(start + width, 0.0));
                let there = integral.evaluate(time, 0.0);
                // Simpson's rule loses a little at the kinks of the spline's third derivative.
                assert!(
                    (there.value - simpson).abs() < 1e-10,
                    "{text} at {time}: {there:?} {simpson}"
                );
                assert!((there.rate - here.value).abs() < 1e-13, "{text} at {time}");
                assert!(
                    (there.second_rate - here.rate).abs() < 1e-12,
                    "{text} at {time}"
                );
            }
        }
    }
}

#[test]
fn integrals_of_formulas_reach_rounding() {
    type Exact = fn(f64) -> f64;
    let cases: [(&str, f64, Exact); 5] = [
        ("150*cos(150*t)", 40.0, |t| (150.0 * t).sin()),
        ("1/(1 + 1e4*(t - 0.4)^2)", 1.0, |t| {
            ((100.0 * (t - 0.4)).atan() + 40.0_f64.atan()) / 100.0
        }),
        ("exp(-t)", 30.0, |t| 1.0 - (-t).exp()),
        ("1 - cos(1e-3*t)", 1.0, |t| {
            t * t * t * 1e-6 / 6.0 - t.powi(5) * 1e-12 / 120.0
        }),
        ("0*t", 1.0, |_| 0.0),
    ];
    for (formula, end, exact) in cases {
        let integral = TimeFunction::integral_of(&Function::Formula(formula.into()), end).unwrap();
        for part in 0..=1000 {
            let time = end * f64::from(part) / 1000.0;
            let error = value(&integral, time) - exact(time);
            assert!(error.abs() < 1e-12 * end, "{formula} at {time}: {error:e}");
        }
    }
}

#[test]
fn an_integrated_formula_is_defined_up_to_its_end_and_no_further() {
    let integral = TimeFunction::integral_of(&Function::Formula("cos(t)".into()), 2.0).unwrap();
    let past_end = 2.0 + 1e-9;
    assert!((value(&integral, past_end) - past_end.sin()).abs() < 1e-15);
    assert!(value(&integral, 2.1).is_nan());
    assert!(value(&integral, -0.1).is_nan());
}

#[test]
fn exact_integrals_hold_beyond_any_end() {
    let table =
        from_json(r#"{"table": {"times": [1, 2], "values": [3, 5], "interpolation": "linear"}}"#);
    let integral = TimeFunction::integral_of(&table, 1.0).unwrap();
    for (time, exact) in [
        (-2.0, -6.0),
        (0.0, 0.0),
        (1.0, 3.0),
        (2.0, 7.0),
        (4.0, 17.0),
    ] {
        assert!((value(&integral, time) - exact).abs() < 1e-14);
    }
    let wave = Function::Harmonic(Harmonic {
        amplitude: 2.0,
        angular_frequency: Some(5.0),
        phase: 0.3,
        offset: 0.5,
        ..Harmonic::default()
    });
    let integral = TimeFunction::integral_of(&wave, 1.0).unwrap();
    for time in [-1.0_f64, 0.2, 30.0] {
        let exact = 0.5 * time + 0.4 * (0.3_f64.cos() - (5.0 * time + 0.3).cos());
        assert!((value(&integral, time) - exact).abs() < 1e-14);
    }
}

#[test]
fn an_input_is_held() {
    let input = TimeFunction::new(&Function::Input(InputSignal { initial: 2.0 })).unwrap();
    let held = input.evaluate(5.0, 7.5);
    assert_eq!((held.value, held.rate, held.second_rate), (7.5, 0.0, 0.0));
    let error = TimeFunction::integral_of(&from_json(r#"{"input": {}}"#), 1.0).unwrap_err();
    assert!(error.to_string().contains("future"), "{error}");
}

#[test]
fn what_cannot_be_evaluated_is_refused_with_its_place() {
    for (text, said) in [
        (r#"{"polynomial": []}"#, "polynomial: is an empty list"),
        (
            r#"{"table": {"times": [0, 1, 1], "values": [1, 2, 3]}}"#,
            "table.times[2]: is 1, not after 1",
        ),
        (
            r#"{"table": {"times": [0, 1], "values": [1, 2, 3]}}"#,
            "table.values: has 3 numbers, but times has 2",
        ),
        (
            r#"{"table": {"times": [0], "values": [1]}}"#,
            "table.times: has 1 numbers",
        ),
        (
            r#"{"harmonic": {"amplitude": 1}}"#,
            "harmonic.frequency_hz: one of frequency_hz and angular_frequency is expected, none is",
        ),
        (
            r#"{"harmonic": {"amplitude": 1, "frequency_hz": 1, "angular_frequency": 1}}"#,
            "both are given",
        ),
        (
            r#"{"harmonic": {"amplitude": 1, "frequency_hz": 0}}"#,
            "harmonic.frequency_hz: is 0, expected a positive number",
        ),
    ] {
        let message = refusal(text);
        assert!(message.contains(said), "{message}");
    }
    let infinite = Function::Constant(f64::INFINITY);
    assert!(TimeFunction::new(&infinite).is_err());
    for formula in ["1/t", "1/(t - 0.3)^2", "sqrt(t - 1)"] {
        let error = TimeFunction::integral_of(&Function::Formula(formula.into()), 1.0).unwrap_err();
        assert!(error.to_string().contains("formula: "), "{error}");
    }
}

#[test]
fn bad_formulas_are_refused_with_their_position() {
    let deep = format!("{}t{}", "(".repeat(400), ")".repeat(400));
    let signs = format!("{}t", "-".repeat(998));
    for fine in [&deep, &signs] {
        assert!(TimeFunction::new(&Function::Formula(fine.as_str().into())).is_ok());
    }
    let long = format!("{}t", "1+".repeat(600));
    let stacked = format!("{}t{}", "t+(".repeat(200), ")".repeat(200));
    for (formula, said) in [
        ("", "position 1: expected a number"),
        ("2*", "position 3: expected a number"),
        ("sin(t", "position 6: expected"),
        ("sin t", "position 5: expected the end or one of + - * / ^"),
        (
            "1 + sin",
            "position 5: the function `sin` needs brackets: `sin(x)`",
        ),
        ("3*x + 1", "position 3: `x` is not known"),
        ("2t", "position 2: expected the end or one of + - * / ^"),
        (
            "sqrtt(t)",
            "position 1: `sqrtt` is not a known function; did you mean `sqrt`?",
        ),
        (
            "1 + log(t)",
            "position 5: `log` is not a known function; write ln or log10",
        ),
        ("t ** 2", "position 4: powers are written with ^"),
        ("{t}", "position 1"),
        ("été + t", "position 1"),
        ("t + ü", "position 5"),
        ("1e999*t", "position 1: 1e999 is too large"),
        (&long, "more than 1000"),
        (&stacked, "intermediate results"),
    ] {
        let message = TimeFunction::new(&Function::Formula(formula.into()))
            .unwrap_err()
            .to_string();
        assert!(message.contains(said), "{formula:?}: {message}");
    }
}

#[test]
fn a_function_has_exactly_one_known_kind() {
    for (text, said) in [
        (r#"{"polynomail": [1]}"#, "unknown field `polynomail`"),
        (
            r#"{"constant": 1, "polynomial": [1]}"#,
            "one kind, found `constant` and `polynomial`",
        ),
        ("{}", "invalid length 0"),
        (r#""sin(t)""#, "a number or a function"),
        (r#"{"harmonic": [1, 2]}"#, "an object"),
    ] {
        let message = serde_json::from_str::<Function>(text)
            .unwrap_err()
            .to_string();
        assert!(message.contains(said), "{message}");
    }
    for text in SMOOTH {
        let function = from_json(text);
        let again = serde_json::to_string(&function).unwrap();
        assert_eq!(from_json(&again), function);
    }
}
