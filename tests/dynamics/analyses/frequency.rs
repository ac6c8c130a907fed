//! Frequency responses against closed forms and direct solutions over all degrees of freedom.

use std::f64::consts::TAU;
use std::path::Path;

use dcb_formats::Component;
use dcb_formats::output::Replace;
use dcb_formats::results::{FrequencyResponses, Results};
use dcb_formats::scene::Scene;
use dcb_runtime::Model;
use dcb_runtime::frequency::{FrequencyReport, Solution};
use dcb_runtime::run::{Observer, Profiling, Report, Target, run};
use dcb_samples::{SpatialBeam, spatial_beam};
use dcb_tests::dense::dense;
use faer::linalg::solvers::Solve;
use faer::{Mat, c64};

#[derive(Default)]
struct Notes(Vec<String>);

impl Observer for Notes {
    fn note(&mut self, _: f64, message: &str) {
        self.0.push(message.to_owned());
    }
    fn progress(&mut self, _: f64, _: f64) {}
    fn is_stopped(&self) -> bool {
        false
    }
}

/// The report of a scene in a folder, where its results are `scene.h5`, and the notes.
pub(super) fn report_of(folder: &Path, text: &str) -> Result<(Report, Vec<String>), String> {
    let path = folder.join("scene.json");
    let scene = Scene::parse(text, &path).map_err(|error| error.to_string())?;
    let model = Model::load(&scene).map_err(|error| error.to_string())?;
    let target = Target {
        path: folder.join("scene.h5"),
        replace: Replace::Overwrite,
        fields_in: None,
        kept: Vec::new(),
        options: serde_json::Value::Null,
        profiling: Profiling::Off,
    };
    let mut notes = Notes::default();
    let report = run(&scene, model, &target, &mut notes).map_err(|error| error.to_string())?;
    Ok((report, notes.0))
}

/// That of a frequency response, what its file has, and the notes.
pub(super) fn responses(
    folder: &Path,
    text: &str,
) -> Result<(FrequencyReport, FrequencyResponses, Vec<String>), String> {
    let (report, notes) = report_of(folder, text)?;
    let Report::Frequency(report) = report else {
        panic!("another analysis")
    };
    let read = Results::open(folder.join("scene.h5"))
        .unwrap()
        .frequency_responses()
        .unwrap()
        .unwrap();
    Ok((report, read, notes))
}

/// A mass on a spring and a damper, on a base that a drive moves.
pub(super) fn oscillator(analysis: &str) -> String {
    format!(
        r#"{{"dimension": 2, "units": {{"length": "m", "mass": "kg", "time": "s"}},
          "bodies": {{"base": {{"rigid": {{"mass": 1, "inertia": 1, "points": {{"p": [0, 0]}}}}}},
                     "mass": {{"rigid": {{"mass": 2, "inertia": 1, "points": {{"p": [0, 0]}}}}, "position": [1, 0]}}}},
          "joints": {{"rail": {{"prismatic": {{"a": "ground", "b": "base/p", "axis": [1, 0]}}}},
                     "slide": {{"prismatic": {{"a": "base/p", "b": "mass/p", "axis": [1, 0]}}}}}},
          "drives": {{"shake": {{"position": {{"joint": "rail", "constant": 0}}}}}},
          "springs": {{"spring": {{"spring": {{"a": "base/p", "b": "mass/p", "stiffness": 800, "damping": 4}}}}}},
          "loads": {{"push": {{"force": {{"at": "mass/p", "components": [1, 0]}}}}}},
          "outputs": {{"place": {{"position": {{"at": "mass/p"}}}}}},
          "analysis": {{"frequency_response": {analysis}}}}}"#
    )
}

pub(super) fn near(found: [f64; 2], expected: c64, limit: f64) {
    let difference = (c64::new(found[0], found[1]) - expected).norm();
    assert!(
        difference < limit * expected.norm(),
        "{found:?} and {expected:?}"
    );
}

#[test]
fn an_oscillator_answers_as_its_closed_form() {
    let folder = tempfile::tempdir().unwrap();
    let (m, k, c) = (2.0, 800.0, 4.0);
    let (report, read, notes) = responses(
        folder.path(),
        &oscillator(r#"{"inputs": ["push/0", "shake"], "frequencies": {"from": 0.5, "to": 20, "count": 40}}"#),
    )
    .unwrap();
    assert!(notes.is_empty(), "{notes:?}");
    assert_eq!(report.solution, Solution::Modes);
    assert_eq!(report.responses, read);
    assert!(read.frequency.len() > 55 && read.frequency.is_sorted());
    let x = read
        .outputs
        .iter()
        .position(|output| output.name == "place.x")
        .unwrap();
    for (f, (by_force, by_base)) in read
        .frequency
        .iter()
        .zip(read.of(x, 0).into_iter().zip(read.of(x, 1)))
    {
        let omega = TAU * f;
        let spring = c64::new(k, omega * c);
        let resists = spring - c64::new(m * omega * omega, 0.0);
        near(by_force, c64::new(1.0, 0.0) / resists, 1e-9);
        near(by_base, spring / resists, 1e-9);
    }
    // The peak is at √(1 − 2ζ²) of the natural frequency, and is met to the width of the grid there.
    let (natural, ratio) = ((k / m).sqrt() / TAU, 0.5 * c / (k * m).sqrt());
    let peak = report
        .peaks
        .iter()
        .find(|peak| peak.input == "push" && peak.output == "place.x")
        .unwrap();
    assert!((peak.frequency / (natural * (1.0 - 2.0 * ratio * ratio).sqrt()) - 1.0).abs() < 5e-3);
    assert!((peak.damping.unwrap() / ratio - 1.0).abs() < 1e-9);
}

#[test]
fn forms_of_outputs_and_drives() {
    let folder = tempfile::tempdir().unwrap();
    let of = |options: &str| {
        let text = oscillator(&format!(
            r#"{{"inputs": ["push/0", "shake"], "frequencies": [3, 7], {options}}}"#
        ));
        responses(folder.path(), &text).unwrap().1
    };
    let plain = of(r#""output_as": "itself""#);
    let x = plain
        .outputs
        .iter()
        .position(|output| output.name == "place.x")
        .unwrap();
    let (rate, second) = (
        of(r#""output_as": "rate""#),
        of(r#""output_as": "second_rate", "drive_as": "acceleration""#),
    );
    for (k, f) in [3.0, 7.0].into_iter().enumerate() {
        let iw = c64::new(0.0, TAU * f);
        let value = |of: &FrequencyResponses, input: usize| of.of(x, input)[k];
        let base = |input: usize| c64::new(value(&plain, input)[0], value(&plain, input)[1]);
        near(value(&rate, 0), base(0) * iw, 1e-12);
        near(value(&second, 0), base(0) * iw * iw, 1e-12);
        // Acceleration by acceleration is displacement by displacement.
        near(value(&second, 1), base(1), 1e-12);
    }
    assert_eq!(
        (
            rate.outputs[x].unit.as_str(),
            second.inputs[1].unit.as_str()
        ),
        ("m/s", "m/s^2")
    );
    assert_eq!(plain.inputs[1].unit, "m");
}

/// White noise of one-sided density W on a damped oscillator: σ² = W/(4 c k), and crossings with its natural frequency.
#[test]
fn white_noise_on_an_oscillator() {
    let folder = tempfile::tempdir().unwrap();
    let text = oscillator(
        r#"{"inputs": ["push/0"], "frequencies": {"from": 0.001, "to": 400, "count": 4000, "spacing": "resonances"}, "random": {"push/0": [[0, 9], [400, 9]]}}"#,
    );
    let (report, read, notes) = responses(folder.path(), &text).unwrap();
    let x = report
        .random
        .iter()
        .find(|output| output.name == "place.x")
        .unwrap();
    let (k, c, w) = (800.0_f64, 4.0, 9.0);
    assert!(
        (x.rms / (w / (4.0 * c * k)).sqrt() - 1.0).abs() < 5e-3,
        "{}",
        x.rms
    );
    // Velocities of the fast part are cut off at 400 Hz: 2c/(π m 2π f) less.
    assert!(
        (x.zero_crossings / ((k / 2.0_f64).sqrt() / TAU) - 1.0).abs() < 2e-2,
        "{}",
        x.zero_crossings
    );
    assert!(notes.is_empty(), "{notes:?}");
    assert!(read.density_of(0).is_some());
    // Too few frequencies are told.
    let coarse = oscillator(
        r#"{"inputs": ["push/0"], "frequencies": {"from": 0.1, "to": 40, "count": 30, "spacing": "linear"}, "random": {"push/0": [[0, 9], [400, 9]]}}"#,
    );
    let notes = responses(folder.path(), &coarse).unwrap().2;
    assert!(
        notes
            .iter()
            .any(|note| note.contains("every other frequency")),
        "{notes:?}"
    );
}

/// A clamped beam with a dashpot, against (K (1 + iη) + iω C − ω² M) u = f over all its degrees of freedom.
#[test]
fn a_beam_answers_as_its_matrices_do() {
    let component = spatial_beam(&SpatialBeam {
        elements: 6,
        ..SpatialBeam::default()
    });
    let folder = tempfile::tempdir().unwrap();
    let reduced = dcb_tests::lowest(&component, 1000);
    dcb_tests::write_bare(&folder.path().join("beam.dcb.h5"), &reduced.superelement);
    let dashpot = 30.0;
    for (damping, eta, c) in [
        (r#""damping": {"structural": 0.03},"#, 0.03, 0.0),
        ("", 0.0, dashpot),
        (r#""damping": {"structural": 0.01},"#, 0.01, dashpot),
    ] {
        let text = format!(
            r#"{{"dimension": 3, "units": {{"length": "m", "mass": "kg", "time": "s"}},
              "ground": {{"points": {{"above": [1, 0, 1]}}}},
              "bodies": {{"beam": {{"superelement": "beam.dcb.h5"}}}},
              "joints": {{"clamp": {{"fixed": {{"a": "ground", "b": "beam/a"}}}}}},
              "springs": {{"dashpot": {{"spring": {{"a": "ground/above", "b": "beam/b", "stiffness": 0, "damping": {c}}}}}}},
              "loads": {{"push": {{"force": {{"at": "beam/b", "components": [0, 1, 1]}}}}}},
              "outputs": {{"tip": {{"displacement": {{"at": "beam/b"}}}}}},
              "analysis": {{"frequency_response": {{{damping} "inputs": ["push/1", "push/2"], "frequencies": [3.7, 21.3, 88, 240.5, 1000]}}}}}}"#
        );
        let read = responses(folder.path(), &text).unwrap().1;
        for (k, f) in read.frequency.iter().enumerate() {
            for (input, direction) in [(0, 1), (1, 2)] {
                let tip = whole(&component, *f, eta, c, direction);
                let size = tip.iter().map(|x| x.norm()).fold(0.0, f64::max);
                for (axis, expected) in tip.iter().enumerate() {
                    let [re, im] = read.of(axis, input)[k];
                    let difference = (c64::new(re, im) - expected).norm();
                    assert!(
                        difference < 1e-7 * size,
                        "{f} Hz, axis {axis}: {re:e} {im:e} and {expected:?}"
                    );
                }
            }
        }
    }
}

/// Displacement of the last node, with all dofs of the first one held.
fn whole(
    component: &Component,
    frequency: f64,
    eta: f64,
    dashpot: f64,
    direction: usize,
) -> [c64; 3] {
    let (stiffness, mass) = (dense(&component.stiffness), dense(&component.mass));
    let n = stiffness.nrows();
    let omega = TAU * frequency;
    let dynamic = Mat::from_fn(n, n, |i, j| {
        let k = stiffness[(i, j)];
        let c = if i == j && i == n - 4 { dashpot } else { 0.0 };
        c64::new(k - omega * omega * mass[(i, j)], eta * k + omega * c)
    });
    let free = dynamic.as_ref().submatrix(6, 6, n - 6, n - 6).to_owned();
    let force = Mat::from_fn(n - 6, 1, |i, _| {
        c64::new(f64::from(u8::from(i + 6 == n - 6 + direction)), 0.0)
    });
    let moved = free.partial_piv_lu().solve(&force);
    std::array::from_fn(|axis| moved[(n - 12 + axis, 0)])
}

#[test]
fn damping_of_assembled_modes_is_what_was_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let text = oscillator(
        r#"{"inputs": ["push/0"], "damping": {"assembled_modal": 0.02}, "frequencies": [2.5]}"#,
    );
    let read = responses(folder.path(), &text).unwrap().1;
    let x = read
        .outputs
        .iter()
        .position(|output| output.name == "place.x")
        .unwrap();
    let (m, k, omega) = (2.0, 800.0_f64, TAU * 2.5);
    let resists = c64::new(k - m * omega * omega, omega * 2.0 * 0.02 * (k * m).sqrt());
    near(read.of(x, 0)[0], c64::new(1.0, 0.0) / resists, 1e-9);
}

#[test]
fn mistakes_are_named() {
    let folder = tempfile::tempdir().unwrap();
    for (analysis, told) in [
        (r#"{"frequencies": []}"#, "frequencies: is empty"),
        (r#"{"frequencies": [0, 1]}"#, "frequencies[0]"),
        (
            r#"{"frequencies": [2, 1]}"#,
            "is 1, after 2; expected ascending",
        ),
        (
            r#"{"frequencies": {"from": 5, "to": 1, "count": 10}}"#,
            "not above `from`",
        ),
        (
            r#"{"frequencies": {"from": 1, "to": 5, "count": 1}}"#,
            "count: is 1",
        ),
        (r#"{"frequencies": [1], "inputs": ["pull"]}"#, "pull"),
        (r#"{"frequencies": [1], "outputs": ["speed"]}"#, "speed"),
        (
            r#"{"frequencies": [1], "damping": {"structural": -0.1}}"#,
            "structural: is -0.1",
        ),
        (
            r#"{"frequencies": [1], "random": {"push/0": [[0, 1], [10, -1]]}}"#,
            "random.push/0[1][1]",
        ),
        (
            r#"{"frequencies": [1], "random": {"pull": [[0, 1], [10, 1]]}}"#,
            "is no input of the analysis",
        ),
        (r#"{"frequency": [1]}"#, "unknown field"),
    ] {
        let message = responses(folder.path(), &oscillator(analysis)).unwrap_err();
        assert!(message.contains(told), "{analysis}: {message}");
    }
    // An undamped resonance, exactly.
    let undamped = oscillator(&format!(
        r#"{{"inputs": ["push/0"], "frequencies": [{}]}}"#,
        (400.0_f64).sqrt() / TAU
    ))
    .replace("\"damping\": 4", "\"damping\": 0");
    match responses(folder.path(), &undamped) {
        Err(message) => assert!(message.contains("undamped resonance"), "{message}"),
        Ok((report, ..)) => assert!(report.responses.real.iter().any(|x| x.abs() > 1e6)),
    }
}

#[test]
fn frequencies_beyond_the_file_are_told_or_refused() {
    let component = spatial_beam(&SpatialBeam {
        elements: 10,
        ..SpatialBeam::default()
    });
    let folder = tempfile::tempdir().unwrap();
    let reduced = dcb_tests::lowest(&component, 4);
    dcb_tests::write_bare(&folder.path().join("beam.dcb.h5"), &reduced.superelement);
    let text = |options: &str| {
        format!(
            r#"{{"dimension": 3, "units": {{"length": "m", "mass": "kg", "time": "s"}},
              "bodies": {{"beam": {{"superelement": "beam.dcb.h5"}}}},
              "loads": {{"push": {{"force": {{"at": "beam/b", "components": [0, 0, 1]}}}}}},
              "outputs": {{"tip": {{"displacement": {{"at": "beam/b"}}}}}},
              "analysis": {{"frequency_response": {{"damping": {{"structural": 0.02}}, "frequencies": [10, 100, 4000]{options}}}}}}}"#
        )
    };
    let (_, _, notes) = responses(folder.path(), &text("")).unwrap();
    assert!(
        notes
            .iter()
            .any(|note| note.contains("body \"beam\": its superelement is made for motions up to")),
        "{notes:?}"
    );
    let message = responses(folder.path(), &text(r#", "beyond_band": "refuse""#)).unwrap_err();
    assert!(message.contains("made for motions up to"), "{message}");
}
