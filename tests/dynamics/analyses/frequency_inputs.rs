//! Load cases and correlated random inputs of frequency responses against closed forms.

use std::f64::consts::TAU;

use dcb_formats::results::FrequencyResponses;
use faer::c64;

use super::frequency::{near, oscillator, responses};

fn output(of: &FrequencyResponses, name: &str) -> usize {
    let mut outputs = of.outputs.iter();
    outputs.position(|output| output.name == name).unwrap()
}

/// Of an output by an input of a name.
fn by(of: &FrequencyResponses, output: usize, input: &str) -> Vec<c64> {
    let place = of.inputs.iter().position(|one| one.name == input).unwrap();
    let values = of.of(output, place).into_iter();
    values.map(|[re, im]| c64::new(re, im)).collect()
}

#[test]
fn a_load_case_is_the_sum_of_its_inputs() {
    let folder = tempfile::tempdir().unwrap();
    let text = oscillator(
        r#"{"inputs": ["push", "shake"], "frequencies": [2, 3, 5, 9],
            "cases": {"engine": {"push": [[1, 2, 0], [5, 6, -4]], "shake": [[0, 0, 0.5], [20, 0, 0.5]]}}}"#,
    );
    let (report, read, _) = responses(folder.path(), &text).unwrap();
    let x = output(&read, "place.x");
    let (force, base, both) = (
        by(&read, x, "push"),
        by(&read, x, "shake"),
        by(&read, x, "engine"),
    );
    for (k, f) in read.frequency.iter().enumerate() {
        // Lines between the points, nothing beyond them.
        let push = match *f <= 5.0 {
            true => c64::new(1.0 + f, 1.0 - f),
            false => c64::new(0.0, 0.0),
        };
        let expected = force[k] * push + base[k] * c64::new(0.0, 0.5);
        near([both[k].re, both[k].im], expected, 1e-12);
    }
    assert_eq!(read.inputs.last().unwrap().unit, "1");
    let unit = |input: &str| {
        let peak = report.peaks.iter().find(|peak| peak.input == input);
        peak.map(|peak| peak.unit.clone())
    };
    assert!(unit("engine").is_none_or(|unit| unit == "m"));
}

/// Two forces on one mass: S_y = |H|² (S₁ + S₂ + 2 Re S₁₂).
#[test]
fn random_inputs_that_belong_together() {
    let folder = tempfile::tempdir().unwrap();
    let density = |correlated: &str| {
        let text = oscillator(&format!(
            r#"{{"inputs": ["push/0", "more/0"], "frequencies": [2, 3, 5, 9],
                 "random": {{"push/0": [[0, 9], [400, 9]], "more/0": [[0, 4], [400, 4]]}}, "correlated": [{correlated}]}}"#
        ))
        .replace(
            r#""loads": {"#,
            r#""loads": {"more": {"force": {"at": "mass/p", "components": [1, 0]}}, "#,
        );
        let read = responses(folder.path(), &text)?.1;
        let x = output(&read, "place.x");
        let squares = by(&read, x, "push").into_iter().map(|h| h.norm_sqr());
        let densities = read.density_of(x).unwrap().into_iter();
        let ratios: Vec<f64> = densities.zip(squares).map(|(s, h)| s / h).collect();
        Ok::<_, String>((read.frequency.clone(), ratios))
    };
    let pair = |rest: &str| format!(r#"{{"inputs": ["push/0", "more/0"], {rest}}}"#);
    for (correlated, expected) in [
        (String::new(), 13.0),
        (pair(r#""coherence": 1"#), 25.0),
        (pair(r#""coherence": 0.25"#), 19.0),
        (pair(r#""density": [[0, -6, 0], [400, -6, 0]]"#), 1.0),
        (pair(r#""density": [[0, 1, 5], [400, 1, 5]]"#), 15.0),
    ] {
        for found in density(&correlated).unwrap().1 {
            assert!((found / expected - 1.0).abs() < 1e-9, "{found} {expected}");
        }
    }
    let (frequencies, found) = density(&pair(r#""coherence": 1, "delay": 0.07"#)).unwrap();
    for (f, found) in frequencies.iter().zip(found) {
        let expected = 13.0 + 12.0 * (TAU * f * 0.07).cos();
        assert!((found - expected).abs() < 1e-9 * 25.0, "{found} {expected}");
    }
    // More coherent than is possible, and other mistakes.
    for (correlated, told) in [
        (
            pair(r#""density": [[0, 7, 0], [400, 7, 0]]"#),
            "isn't possible at the frequency 2",
        ),
        (
            pair(r#""coherence": 1.2"#),
            "correlated[0].coherence: is 1.2",
        ),
        (pair(r#""delay": 1"#), "needs either `coherence`"),
        (
            r#"{"inputs": ["push/0", "push/0"], "coherence": 1}"#.to_owned(),
            "has \"push/0\" twice",
        ),
        (
            r#"{"inputs": ["push/0", "pull/0"], "coherence": 1}"#.to_owned(),
            "is no input of the analysis",
        ),
        (
            [pair(r#""coherence": 1"#), pair(r#""coherence": 1"#)].join(","),
            "stands twice",
        ),
    ] {
        let message = density(&correlated).unwrap_err();
        assert!(message.contains(told), "{correlated}: {message}");
    }
}

/// Which lag a positive delay is shows in the phase between two outputs' forces: here a force and the motion of the base, whose parts of the response are known.
#[test]
fn the_second_input_comes_after_the_first() {
    let folder = tempfile::tempdir().unwrap();
    let (delay, coherence) = (0.013, 0.7);
    let text = oscillator(&format!(
        r#"{{"inputs": ["push/0", "shake"], "frequencies": [2, 3, 5, 9],
             "random": {{"push/0": [[0, 9], [400, 9]], "shake": [[0, 1e-4], [400, 1e-4]]}},
             "correlated": [{{"inputs": ["push/0", "shake"], "coherence": {coherence}, "delay": {delay}}}]}}"#
    ));
    let read = responses(folder.path(), &text).unwrap().1;
    let x = output(&read, "place.x");
    let (force, base) = (by(&read, x, "push"), by(&read, x, "shake"));
    for (k, found) in read.density_of(x).unwrap().iter().enumerate() {
        // shake(t) = a push(t − τ) + noise, so X_shake has a exp(−iωτ) X_push in it.
        let (s_push, s_shake): (f64, f64) = (9.0, 1e-4);
        let a = (coherence * s_shake / s_push).sqrt();
        let lag = c64::from_polar(1.0, -TAU * read.frequency[k] * delay);
        let together = (force[k] + base[k] * lag * a).norm_sqr() * s_push;
        let noise = base[k].norm_sqr() * (1.0 - coherence) * s_shake;
        let expected = together + noise;
        assert!((found / expected - 1.0).abs() < 1e-9, "{found} {expected}");
    }
}

#[test]
fn mistakes_in_cases_are_named() {
    let folder = tempfile::tempdir().unwrap();
    for (cases, told) in [
        (r#"{"engine": {}}"#, "cases.engine: is empty"),
        (
            r#"{"engine": {"pull": [[0, 1, 0], [9, 1, 0]]}}"#,
            "cases.engine.pull: is no input",
        ),
        (
            r#"{"engine": {"push/0": [[0, 1, 0]]}}"#,
            "cases.engine.push/0: has 1 points",
        ),
        (
            r#"{"engine": {"push/0": [[5, 1, 0], [4, 1, 0]]}}"#,
            "is 4, after 5",
        ),
        (
            r#"{"push": {"push/0": [[5, 1, 0], [6, 1, 0]]}}"#,
            "has the name of an input",
        ),
    ] {
        let text = oscillator(&format!(
            r#"{{"inputs": ["push/0"], "frequencies": [1], "cases": {cases}}}"#
        ));
        let message = responses(folder.path(), &text).unwrap_err();
        assert!(message.contains(told), "{cases}: {message}");
    }
}
