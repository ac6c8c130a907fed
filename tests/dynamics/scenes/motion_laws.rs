//! Tables that keep their shape, motion laws, and formulas with branches: against closed forms, differences and quadrature.

use dcb_formats::function::{Function, FunctionValue, Interpolation, Table, TimeFunction};
use dcb_samples::PseudoRandom;
use serde_json::{Value, json};

fn ready(text: &Value) -> TimeFunction {
    TimeFunction::new(&serde_json::from_value(text.clone()).unwrap()).unwrap()
}

fn refusal(text: &Value) -> String {
    match serde_json::from_value::<Function>(text.clone()) {
        Ok(function) => TimeFunction::new(&function).unwrap_err().to_string(),
        Err(error) => error.to_string(),
    }
}

fn formula(text: &str) -> TimeFunction {
    TimeFunction::new(&Function::Formula(text.into())).unwrap()
}

fn at(function: &TimeFunction, time: f64) -> FunctionValue {
    function.evaluate(time, 0.0)
}

fn table(times: &[f64], values: &[f64], interpolation: Interpolation) -> TimeFunction {
    TimeFunction::new(&Function::Table(Table {
        times: times.to_vec(),
        values: values.to_vec(),
        interpolation,
    }))
    .unwrap()
}

#[test]
fn a_dwell_stays_a_dwell() {
    let turn = ready(&json!({"table": {
        "times": [0, 0.2, 0.8, 1, 2], "values": [0, 0, 1.5, 1.5, 1.5]
    }}));
    for time in [0.0, 0.1, 0.15, 0.2] {
        assert_eq!(at(&turn, time), FunctionValue::default(), "{time}");
    }
    for step in 0..=20_000 {
        let value = at(&turn, f64::from(step) * 1e-4).value;
        assert!(
            (0.0..=1.5 + 1e-15).contains(&value),
            "{value} at step {step}"
        );
    }
    // From dwell to dwell it is the polynomial of orders 3, 4 and 5.
    for x in [0.1, 0.37, 0.5, 0.93_f64] {
        let exact = 1.5 * x.powi(3) * (10.0 - 15.0 * x + 6.0 * x * x);
        assert!(
            (at(&turn, 0.2 + 0.6 * x).value - exact).abs() < 1e-14,
            "{x}"
        );
    }
    // What was the default has both faults.
    let spline = table(
        &[0.0, 0.2, 0.8, 1.0, 2.0],
        &[0.0, 0.0, 1.5, 1.5, 1.5],
        Interpolation::Spline,
    );
    assert!(at(&spline, 0.1).value < -0.03 && at(&spline, 0.0).rate < -0.5);
}

/// Tables of all kinds: steps, dwells, extremes, slopes that change by factors of thousands, spans that do.
fn tables() -> Vec<(Vec<f64>, Vec<f64>)> {
    let mut random = PseudoRandom::new(1);
    // From 0 to 1.
    let mut share = || 0.5 * (random.number() + 1.0);
    let mut all = vec![
        (vec![0.0, 1.0], vec![0.0, 3.0]),
        (vec![0.0, 1.0, 2.0, 3.0], vec![0.0, 1.0, 2.0, 3.0]),
        (vec![-1.0, 0.0, 1e-3, 2.0], vec![5.0, 4.0, -4.0, -4.001]),
    ];
    for kind in 0..300 {
        let count = 2 + (share() * 12.0) as usize;
        let (mut time, mut value) = (share() - 0.5, share());
        let (mut times, mut values) = (Vec::new(), Vec::new());
        for _ in 0..count {
            times.push(time);
            values.push(value);
            time += 10.0_f64.powf(3.0 * share() - 2.0);
            let step = 10.0_f64.powf(4.0 * share() - 3.0);
            value += match kind % 3 {
                0 => step,
                1 => -step * (share() * 3.0).floor(),
                _ => step * ((share() * 3.0).floor() - 1.0),
            };
        }
        all.push((times, values));
    }
    all
}

#[test]
fn tables_are_monotone_in_every_span_and_twice_continuously_differentiable() {
    for (times, values) in tables() {
        let smooth = table(&times, &values, Interpolation::Smooth);
        let monotone = table(&times, &values, Interpolation::Pchip);
        let size = values
            .iter()
            .fold(0.0_f64, |size, value| size.max(value.abs()));
        for (t, v) in times.windows(2).zip(values.windows(2)) {
            let (span, rise) = (t[1] - t[0], v[1] - v[0]);
            for function in [&smooth, &monotone] {
                assert!((at(function, t[0]).value - v[0]).abs() <= 1e-14 * size);
                let inside = (0..=400).map(|part| t[0] + span * f64::from(part) / 400.0);
                for time in inside.filter(|time| *time < t[1]) {
                    let now = at(function, time);
                    let slack = 1e-12 * size / span;
                    assert!(
                        now.rate * rise.signum() >= -slack && (rise != 0.0 || now.rate == 0.0),
                        "{times:?} {values:?}: {now:?} at {time}"
                    );
                    let beyond = ((now.value - v[0]) * rise.signum())
                        .min((v[1] - now.value) * rise.signum());
                    assert!(
                        beyond >= -1e-13 * size,
                        "{times:?} {values:?}: {now:?} at {time}"
                    );
                }
            }
        }
        // Both sides of every point.
        for (index, time) in times.iter().enumerate() {
            let beside = |at: usize| times.get(at).map_or(1.0, |other| (other - time).abs());
            let near = beside(index.wrapping_sub(1)).min(beside(index + 1));
            let tiny = 1e-9 * near;
            let (before, after) = (at(&smooth, time - tiny), at(&smooth, *time));
            let largest = (0..=100)
                .map(|part| {
                    at(&smooth, time + near * (f64::from(part) / 50.0 - 1.0))
                        .second_rate
                        .abs()
                })
                .fold(0.0, f64::max);
            assert!(
                (before.rate - after.rate).abs() <= 1e-6 * largest * near,
                "{times:?} {values:?} at {time}: {before:?} {after:?}"
            );
            assert!(
                (before.second_rate - after.second_rate).abs() <= 1e-5 * largest,
                "{times:?} {values:?} at {time}: {before:?} {after:?}"
            );
        }
    }
}

#[test]
fn dense_tables_of_a_smooth_rise_give_its_acceleration() {
    // 1 - cos rises from 0 to π: the further from its ends, the better; the ends of the table are ends of the rise.
    let error = |count: usize| {
        let times: Vec<f64> = (0..=count)
            .map(|i| std::f64::consts::PI * i as f64 / count as f64)
            .collect();
        let values: Vec<f64> = times.iter().map(|t| 1.0 - t.cos()).collect();
        let smooth = table(&times, &values, Interpolation::Smooth);
        (0..=1000)
            .map(|part| 0.5 + 2.0 * f64::from(part) / 1000.0)
            .map(|t| (at(&smooth, t).second_rate - t.cos()).abs())
            .fold(0.0, f64::max)
    };
    let (coarse, fine) = (error(20), error(40));
    assert!(coarse < 1e-2 && fine < coarse / 6.0, "{coarse:e} {fine:e}");
}

/// Laws with what continues at their breaks: 0 nothing, 1 the value, 2 the rate, 3 the second derivative.
fn laws() -> Vec<(Value, usize)> {
    vec![
        (
            json!({"smooth_step": {"to": 1.5, "start": 0.2, "duration": 0.6}}),
            3,
        ),
        (
            json!({"smooth_step": {"from": -1, "to": 1.5, "start": 0.2, "duration": 0.6, "profile": "cycloidal"}}),
            3,
        ),
        // All limits reached; no speed limit reached; neither speed nor acceleration; without jerk, both ways.
        (
            json!({"trapezoid": {"to": 3, "start": 0.1, "max_speed": 4, "max_acceleration": 20, "max_jerk": 300}}),
            3,
        ),
        (
            json!({"trapezoid": {"from": 2, "to": -1, "max_speed": 40, "max_acceleration": 20, "max_jerk": 300}}),
            3,
        ),
        (
            json!({"trapezoid": {"to": 0.1, "start": 0.1, "max_speed": 40, "max_acceleration": 200, "max_jerk": 300}}),
            3,
        ),
        (
            json!({"trapezoid": {"to": 1, "max_speed": 0.9, "max_acceleration": 200, "max_jerk": 10}}),
            3,
        ),
        (
            json!({"trapezoid": {"to": 3, "max_speed": 4, "max_acceleration": 20}}),
            2,
        ),
        (
            json!({"trapezoid": {"from": 1, "to": 0, "start": 0.3, "max_speed": 40, "max_acceleration": 20}}),
            2,
        ),
        (
            json!({"chirp": {"amplitude": 2, "from_hz": 1, "to_hz": 9, "start": -0.1, "duration": 1.2, "phase": 0.3, "offset": 0.5}}),
            2,
        ),
        (
            json!({"chirp": {"amplitude": 2, "from_hz": 0.5, "to_hz": 8, "duration": 1.2, "sweep": "logarithmic", "start": 0.1}}),
            1,
        ),
        (
            json!({"chirp": {"amplitude": 2, "from_hz": 8, "to_hz": 0, "duration": 1.2, "start": -0.1}}),
            2,
        ),
        (
            json!({"pulse": {"amplitude": 3, "start": 0.2, "width": 0.3, "offset": 0.1}}),
            2,
        ),
        (
            json!({"pulse": {"amplitude": 3, "start": 0.2, "width": 0.3, "period": 0.4}}),
            2,
        ),
        (
            json!({"pulse": {"shape": "half-sine", "amplitude": -3, "start": 0.1, "width": 0.4, "period": 0.5}}),
            1,
        ),
        (
            json!({"pulse": {"shape": "rectangle", "amplitude": 2, "start": 0.3, "width": 0.2, "period": 0.7}}),
            0,
        ),
        (
            json!({"table": {"times": [0, 0.3, 1, 1.5], "values": [0, 1, -1, 0.5]}}),
            3,
        ),
        (
            json!({"table": {"times": [0, 0.3, 1, 1.5], "values": [0, 1, -1, 0.5], "interpolation": "pchip"}}),
            1,
        ),
    ]
}

const END: f64 = 1.6;

#[test]
fn derivatives_are_those_of_differences_away_from_breaks() {
    let step = 1e-4;
    for (text, _) in laws() {
        let function = ready(&text);
        let breaks = function.breaks(END);
        let mut looked = 0;
        for part in 1..160 {
            let time = f64::from(part) * 0.01 + 0.0037;
            if breaks.iter().any(|at| (at - time).abs() < 2.0 * step) {
                continue;
            }
            looked += 1;
            let (before, now, after) = (
                at(&function, time - step),
                at(&function, time),
                at(&function, time + step),
            );
            let rate = (after.value - before.value) / (2.0 * step);
            let second = (after.rate - before.rate) / (2.0 * step);
            let scale = 1.0 + now.rate.abs() + now.second_rate.abs();
            assert!(
                (rate - now.rate).abs() < 2e-5 * scale,
                "{text} at {time}: {rate} {now:?}"
            );
            assert!(
                (second - now.second_rate).abs() < 1e-3 * scale,
                "{text} at {time}: {second} {now:?}"
            );
        }
        assert!(looked > 140, "{text}: {breaks:?}");
    }
}

#[test]
fn what_the_page_calls_continuous_is_continuous() {
    for (text, order) in laws() {
        let function = ready(&text);
        let tiny = 1e-10;
        for time in function.breaks(END) {
            let (before, after) = (at(&function, time - tiny), at(&function, time + tiny));
            let jumps = [
                (after.value - before.value).abs(),
                (after.rate - before.rate).abs(),
                (after.second_rate - before.second_rate).abs(),
            ];
            for (derivative, jump) in jumps.into_iter().enumerate().take(order) {
                let allowed = 1e-6 * (1.0 + after.second_rate.abs());
                assert!(
                    jump < allowed,
                    "{text} at {time}: derivative {derivative} jumps by {jump}"
                );
            }
        }
    }
}

#[test]
fn integrals_are_those_of_quadrature_and_begin_at_zero() {
    for (text, _) in laws() {
        let function = ready(&text);
        let integral =
            TimeFunction::integral_of(&serde_json::from_value(text.clone()).unwrap(), END).unwrap();
        assert!(at(&integral, 0.0).value.abs() < 1e-15, "{text}");
        let mut stops = function.breaks(END);
        stops.extend([0.0, END]);
        stops.sort_by(f64::total_cmp);
        let mut sum = 0.0;
        for pair in stops.windows(2) {
            let panels = 400;
            let width = (pair[1] - pair[0]) / f64::from(panels);
            // Gauss's points of third order, inside: no value at a jump.
            for panel in 0..panels {
                let centre = pair[0] + (f64::from(panel) + 0.5) * width;
                let offset = 0.5 * width * 0.6_f64.sqrt();
                let [low, mid, high] = [centre - offset, centre, centre + offset]
                    .map(|time| at(&function, time).value);
                sum += width * (5.0 * low + 8.0 * mid + 5.0 * high) / 18.0;
            }
            let there = at(&integral, pair[1]);
            assert!(
                (there.value - sum).abs() < 1e-11,
                "{text} at {}: {} {sum}",
                pair[1],
                there.value
            );
        }
        for part in 0..100 {
            let time = f64::from(part) * 0.0159;
            let (rate, value) = (at(&integral, time), at(&function, time));
            assert!(
                (rate.rate - value.value).abs() < 1e-13
                    && (rate.second_rate - value.rate).abs() < 1e-12
            );
        }
    }
}

#[test]
fn a_trapezoid_keeps_its_limits_and_reaches_what_the_way_is_long_enough_for() {
    // Way, limits of speed, acceleration and jerk; what is reached of speed and acceleration, and the duration.
    let full = (3.0, 4.0, 20.0, Some(400.0), [4.0, 20.0], 1.0);
    let no_jerk = (3.0, 4.0, 20.0, None, [4.0, 20.0], 0.95);
    // way = v²/a.
    let triangle = (0.45, 4.0, 20.0, None, [3.0, 20.0], 0.3);
    // way = 2 j c³.
    let short = (0.002, 4.0, 20.0, Some(1000.0), [0.1, 10.0], 0.04);
    // way = v (v/a + a/j).
    let no_cruise = (0.22, 4.0, 20.0, Some(2000.0), [2.0, 20.0], 0.22);
    // The speed is reached before the acceleration: v = j c².
    let soft = (1.0, 0.9, 200.0, Some(10.0), [0.9, 3.0], 1.0 / 0.9 + 0.6);
    for (way, speed, acceleration, jerk, reached, duration) in
        [full, no_jerk, triangle, short, no_cruise, soft]
    {
        let mut law = json!({"to": 1.0 + way, "from": 1, "max_speed": speed, "max_acceleration": acceleration});
        if let Some(jerk) = jerk {
            law["max_jerk"] = json!(jerk);
        }
        let function = ready(&json!({"trapezoid": law}));
        let times = (0..=100_000).map(|part| f64::from(part) * duration / 1e5);
        let (mut fastest, mut hardest) = (0.0_f64, 0.0_f64);
        for time in times {
            let now = at(&function, time);
            fastest = fastest.max(now.rate.abs());
            hardest = hardest.max(now.second_rate.abs());
        }
        assert!(
            (fastest - reached[0]).abs() < 1e-4 * reached[0],
            "{law}: {fastest}"
        );
        assert!(
            (hardest - reached[1]).abs() < 1e-3 * reached[1],
            "{law}: {hardest}"
        );
        let (early, end) = (
            at(&function, 0.99 * duration),
            at(&function, duration * (1.0 + 1e-9)),
        );
        assert!(early.value < 1.0 + way, "{law}: there before {duration}");
        assert_eq!(
            (end.value, end.rate, end.second_rate),
            (1.0 + way, 0.0, 0.0),
            "{law}"
        );
    }
    let nowhere =
        ready(&json!({"trapezoid": {"from": 2, "to": 2, "max_speed": 1, "max_acceleration": 1}}));
    assert_eq!(
        at(&nowhere, 0.5),
        FunctionValue {
            value: 2.0,
            ..FunctionValue::default()
        }
    );
}

#[test]
fn the_frequency_of_a_chirp_is_what_it_says() {
    let tau = std::f64::consts::TAU;
    for (sweep, at_middle) in [("linear", 6.0), ("logarithmic", 20.0_f64.sqrt())] {
        let chirp = ready(&json!({"chirp": {
            "amplitude": 1, "from_hz": 2, "to_hz": 10, "start": 0.5, "duration": 3, "sweep": sweep
        }}));
        // Where the sine crosses zero the rate is 2 π f; sin² + (rate/2 π f)² = 1 everywhere.
        for (time, frequency) in [(0.5, 2.0), (2.0, at_middle), (3.5, 10.0), (4.1, 10.0)] {
            let now = at(&chirp, time);
            let of_rate = now.rate / (tau * frequency);
            assert!(
                (now.value.powi(2) + of_rate.powi(2) - 1.0).abs() < 1e-12,
                "{sweep} at {time}: {now:?}"
            );
        }
        assert_eq!(at(&chirp, 0.2), FunctionValue::default());
    }
}

#[test]
fn formulas_branch_and_carry_both_derivatives() {
    for (text, time, value, rate, second) in [
        ("min(t, t^2)", 0.5, 0.25, 1.0, 2.0),
        ("min(t, t^2)", 2.0, 2.0, 1.0, 0.0),
        ("max(t, t^2, 3)", 2.0, 4.0, 4.0, 2.0),
        ("max(t, t^2, 3)", 1.0, 3.0, 0.0, 0.0),
        ("abs(t - 3)", 1.0, 2.0, -1.0, 0.0),
        ("sign(t - 3)*t", 1.0, -1.0, -1.0, 0.0),
        ("sign(t - 3)", 3.0, 0.0, 0.0, 0.0),
        ("step(t - 3)*t^2", 3.0, 9.0, 6.0, 2.0),
        ("step(t - 3)*t^2", 2.9, 0.0, 0.0, 0.0),
        ("if(t < 1, t^2, 2*t - 1)", 0.5, 0.25, 1.0, 2.0),
        // s = t/2 - 1/2 = 1/4: 10/64 - 15/256 + 6/1024; half of 30 s² (1 - s)², a quarter of 60 s (1 - s) (1 - 2 s).
        (
            "smooth_step(t, 1, 3)",
            1.5,
            0.103515625,
            0.52734375,
            1.40625,
        ),
        ("2*smooth_step(t, 1, 3)", 0.9, 0.0, 0.0, 0.0),
        ("2*smooth_step(t, 1, 3)", 3.0, 2.0, 0.0, 0.0),
        (
            "smooth_step(t, 3, 1)",
            1.5,
            0.896484375,
            -0.52734375,
            -1.40625,
        ),
        (
            "smooth_step(t^2, 0, 1)",
            0.5,
            0.103515625,
            1.0546875,
            7.734375,
        ),
        ("if(t < 1, t^2, 2*t - 1)", 1.0, 1.0, 2.0, 0.0),
        ("if(t >= 1, 5, sqrt(1 - t))", 2.0, 5.0, 0.0, 0.0),
        ("if(and(0 < t, t <= 2), t, 7)", 2.0, 2.0, 1.0, 0.0),
        ("if(or(t > 5, not(t > 1)), t, 7)", 2.0, 7.0, 0.0, 0.0),
        ("(t > 1)*t", 2.0, 2.0, 1.0, 0.0),
        ("1 + t < 2*t", 2.0, 1.0, 0.0, 0.0),
        ("-min(-1, 2)", 0.0, 1.0, 0.0, 0.0),
        ("atan2(sin(3*t), cos(3*t))", 0.4, 1.2, 3.0, 0.0),
        // Both arguments vary, in the third quadrant.
        (
            "atan2(-t^2, -1 - t)",
            1.0,
            0.5_f64.atan() - std::f64::consts::PI,
            0.6,
            0.0,
        ),
    ] {
        let now = at(&formula(text), time);
        let found = [now.value, now.rate, now.second_rate];
        let step = 1e-5;
        if text.starts_with("atan2(-") {
            let [before, after] = [-step, step].map(|d| at(&formula(text), time + d));
            assert!(((after.value - before.value) / (2.0 * step) - now.rate).abs() < 1e-9);
            assert!(((after.rate - before.rate) / (2.0 * step) - now.second_rate).abs() < 1e-9);
            assert!(
                (now.value - value).abs() < 1e-14 && (now.rate - rate).abs() < 1e-14,
                "{now:?}"
            );
            continue;
        }
        for (found, exact) in found.into_iter().zip([value, rate, second]) {
            assert!((found - exact).abs() < 1e-13, "{text} at {time}: {now:?}");
        }
    }
    // What isn't chosen may be anything; what decides may not.
    assert!(at(&formula("if(t > 1, t, ln(-1))"), 2.0).value == 2.0);
    assert!(at(&formula("if(ln(-t) > 0, 1, 2)"), 2.0).value.is_nan());
    assert!(at(&formula("min(ln(-t), 1)"), 2.0).value.is_nan());
}

#[test]
fn formulas_with_kinks_and_jumps_are_integrated() {
    type Exact = fn(f64) -> f64;
    let cases: [(&str, Exact); 6] = [
        ("abs(t - 0.3)", |t| {
            if t < 0.3 {
                0.3 * t - 0.5 * t * t
            } else {
                0.045 + 0.5 * (t - 0.3).powi(2)
            }
        }),
        ("step(t - 0.7)", |t| (t - 0.7).max(0.0)),
        ("if(t < 0.37, 5*t, 1)", |t| {
            if t < 0.37 {
                2.5 * t * t
            } else {
                2.5 * 0.37 * 0.37 + t - 0.37
            }
        }),
        ("sign(t - 1/3)", |t| (t - 1.0 / 3.0).abs() - 1.0 / 3.0),
        ("min(t, 0.5)", |t| {
            if t < 0.5 {
                0.5 * t * t
            } else {
                0.125 + 0.5 * (t - 0.5)
            }
        }),
        ("sqrt(t)", |t| t.powf(1.5) / 1.5),
    ];
    for (text, exact) in cases {
        let integral = TimeFunction::integral_of(&Function::Formula(text.into()), 1.0).unwrap();
        for part in 0..=1000 {
            let time = f64::from(part) / 1000.0;
            let error = at(&integral, time).value - exact(time);
            assert!(error.abs() < 1e-12, "{text} at {time}: {error:e}");
        }
    }
    for text in ["1/t", "1/(t - 0.3)^2", "tan(20*t)"] {
        let refused = TimeFunction::integral_of(&Function::Formula(text.into()), 1.0);
        assert!(
            refused.unwrap_err().to_string().contains("formula: "),
            "{text}"
        );
    }
}

#[test]
fn mistakes_are_told_with_what_is_right() {
    for (text, said) in [
        (
            json!({"formula": "maxx(t, 1)"}),
            "position 1: `maxx` is not a known function; did you mean `max`?",
        ),
        (
            json!({"formula": "if(t > 1, t)"}),
            "position 1: `if` is given 2 arguments; write if(condition, value, otherwise)",
        ),
        (
            json!({"formula": "2*min(t)"}),
            "position 3: `min` is given 1 argument; write min(x, y, ...)",
        ),
        (
            json!({"formula": "sin(t, 2)"}),
            "`sin` is given 2 arguments; write sin(x)",
        ),
        (
            json!({"formula": "if(0 < t < 1, 1, 0)"}),
            "position 10: a comparison of a comparison; write and(0 < t, t < 1)",
        ),
        (json!({"formula": "t == 1"}), "position 3"),
        (
            json!({"formula": "step"}),
            "the function `step` needs brackets: `step(x)`",
        ),
        (
            json!({"formula": "3*omega"}),
            "`omega` is not known; the only variable is t",
        ),
        (
            json!({"trapezoid": {"to": 1, "max_speed": 1, "max_acceleration": -2}}),
            "trapezoid.max_acceleration: is -2, expected a positive number",
        ),
        (
            json!({"trapezoid": {"to": 1, "max_speed": 1, "max_acceleration": 2, "max_jerk": 0}}),
            "trapezoid.max_jerk: is 0",
        ),
        (
            json!({"trapezoid": {"to": 1, "speed": 1, "max_acceleration": 2}}),
            "unknown field `speed`",
        ),
        (
            json!({"smooth_step": {"to": 1, "duration": 0}}),
            "smooth_step.duration: is 0, expected a positive number",
        ),
        (
            json!({"smooth_step": {"to": 1, "duration": 1, "profile": "345"}}),
            "unknown variant `345`, expected `3-4-5` or `cycloidal`",
        ),
        (
            json!({"smooth_step": {"duration": 1}}),
            "missing field `to`",
        ),
        (
            json!({"chirp": {"amplitude": 1, "from_hz": 0, "to_hz": 9, "duration": 1, "sweep": "logarithmic"}}),
            "chirp.from_hz: is 0, from which no factor leads on",
        ),
        (
            json!({"chirp": {"amplitude": 1, "from_hz": 1, "to_hz": -9, "duration": 1}}),
            "chirp.to_hz: is -9",
        ),
        (
            json!({"pulse": {"amplitude": 1, "width": 0.5, "period": 0.4}}),
            "pulse.period: is 0.4, expected a number not below the width, 0.5",
        ),
        (
            json!({"table": {"times": [0, 2, 1], "values": [1, 2, 3]}}),
            "table.times[2]: is 1, not after 2; the times must strictly increase",
        ),
        (
            json!({"table": {"times": [0, 1], "values": [1, 2], "interpolation": "cubic"}}),
            "unknown variant `cubic`",
        ),
        (json!({"trapez": {}}), "unknown field `trapez`"),
    ] {
        let message = refusal(&text);
        assert!(message.contains(said), "{text}: {message}");
    }
}

#[test]
fn laws_are_written_as_they_are_read() {
    for (text, _) in laws() {
        let function: Function = serde_json::from_value(text).unwrap();
        let again = serde_json::from_value(serde_json::to_value(&function).unwrap()).unwrap();
        assert_eq!(function, again);
    }
}

const PAGE: &str = include_str!("../../../docs/scene.md");

#[test]
fn what_the_page_shows_of_functions_can_be_read() {
    let fragments = PAGE.split("```json\n").skip(3);
    let mut functions = 0;
    for fragment in fragments.map(|rest| rest.split("```").next().unwrap()) {
        let fragment: Value = serde_json::from_str(&format!("{{{fragment}}}")).unwrap();
        let Some(drives) = fragment["drives"].as_object() else {
            continue;
        };
        for drive in drives.values() {
            let mut motion = drive.as_object().unwrap().values().next().unwrap().clone();
            motion.as_object_mut().unwrap().remove("joint");
            let mut function: Function = serde_json::from_value(motion).unwrap();
            if let Function::Formula(formula) = &mut function {
                let constants = fragment["constants"].as_object().unwrap().iter();
                formula.constants = constants
                    .map(|(name, value)| (name.clone(), value.as_f64().unwrap()))
                    .collect();
            }
            TimeFunction::integral_of(&function, 1.0).unwrap();
            functions += 1;
        }
    }
    assert_eq!(functions, 3);
}

#[test]
fn branches_of_formulas_are_found_where_they_change() {
    let breaks = formula("if(t < 0.37, 5*t, 1) + abs(t - 0.9) + step(sin(31*t))").breaks(1.0);
    let mut expected: Vec<f64> = (0..=9)
        .map(|k| f64::from(k) * std::f64::consts::PI / 31.0)
        .skip(1)
        .collect();
    expected.extend([0.37, 0.9]);
    expected.sort_by(f64::total_cmp);
    assert_eq!(breaks.len(), expected.len(), "{breaks:?}");
    assert!(
        breaks
            .iter()
            .zip(&expected)
            .all(|(a, b)| (a - b).abs() < 1e-14),
        "{breaks:?}"
    );
    assert!(formula("sin(t)").breaks(1.0).is_empty());
}
