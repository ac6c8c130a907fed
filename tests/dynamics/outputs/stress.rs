//! Stress outputs of scenes: against the whole part, statically, over frequency and in ParaView's files, and what is refused.

use std::f64::consts::TAU;
use std::path::Path;

use dcb_formats::Component;
use dcb_formats::dcb::{Contents, WriteOptions, write_superelement};
use dcb_formats::output::Replace;
use dcb_formats::results::Results;
use dcb_formats::scene::Scene;
use dcb_runtime::Model;
use dcb_runtime::run::{Observer, Profiling, Target, run};
use dcb_samples::bracket;
use dcb_tests::dense::{dense, difference, solve};
use dcb_tests::localization::localization;
use dcb_tests::{assert_says, lowest, python};
use faer::linalg::solvers::Solve;
use faer::{Mat, c64};

struct Quiet;

impl Observer for Quiet {
    fn note(&mut self, _: f64, _: &str) {}
    fn progress(&mut self, _: f64, _: f64) {}
    fn is_stopped(&self) -> bool {
        false
    }
}

/// The bracket held at the wall, with a force at its tip.
fn scene(outputs: &str, rest: &str) -> String {
    format!(
        r#"{{"dimension": 3, "units": {{"length": "m", "mass": "kg", "time": "s"}},
          "ground": {{"points": {{"wall": [-0.08, 0.006, 0]}}}},
          "bodies": {{"bracket": {{"superelement": "bracket.dcb.h5"}}}},
          "joints": {{"bolts": {{"fixed": {{"a": "ground/wall", "b": "bracket/wall"}}}}}},
          "loads": {{"pull": {{"force": {{"at": "bracket/tip", "components": [100, 40, -70]}}}}}},
          "outputs": {{{outputs}}}, {rest}}}"#
    )
}

const FILLET: &str = r#""all": {"stress": {"body": "bracket", "field": "fillet"}},
    "equivalent": {"stress": {"body": "bracket", "field": "fillet", "measure": "von_mises"}},
    "largest": {"stress": {"body": "bracket", "field": "fillet", "measure": "largest_von_mises"}},
    "third": {"stress": {"body": "bracket", "field": "fillet", "place": 3, "measure": "von_mises"}}"#;

fn results(folder: &Path, text: &str) -> Result<Results, String> {
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
    run(&scene, model, &target, &mut Quiet).map_err(|error| error.to_string())?;
    Results::open(&target.path).map_err(|error| error.to_string())
}

fn reduced(folder: &Path, component: &Component, modes: usize) {
    let element = lowest(component, modes).superelement;
    dcb_tests::write_bare(&folder.join("bracket.dcb.h5"), &element);
}

/// The last row of a channel.
fn last(results: &Results, channel: &str) -> Vec<f64> {
    let history = results.history(&format!("outputs/{channel}")).unwrap();
    history.row(history.nrows() - 1).iter().copied().collect()
}

/// Displacements of the part with its wall interface held and a force on its tip: `[[A, Lᵀ], [L, 0]]`.
fn held(component: &Component, force: [f64; 3]) -> Mat<f64> {
    let stiffness = dense(&component.stiffness);
    let rows = localization(component);
    let n = stiffness.nrows();
    let all = Mat::from_fn(n + 6, n + 6, |i, j| match (i < n, j < n) {
        (true, true) => stiffness[(i, j)],
        // Units of about equal size.
        (false, true) => 1e9 * rows[(i - n, j)],
        (true, false) => 1e9 * rows[(j - n, i)],
        (false, false) => 0.0,
    });
    let load = Mat::from_fn(n + 6, 1, |i, _| {
        (0..3)
            .filter(|_| i < n)
            .map(|axis| force[axis] * rows[(6 + axis, i)])
            .sum()
    });
    solve(&all, &load).get(..n, ..).to_owned()
}

#[test]
fn a_static_scene_has_the_stress_of_the_whole_part() {
    let component = bracket(1);
    let expected = dense(&component.stresses[0].matrix) * held(&component, [100.0, 40.0, -70.0]);
    let folder = tempfile::tempdir().unwrap();
    for modes in [3, 12] {
        reduced(folder.path(), &component, modes);
        let results = results(folder.path(), &scene(FILLET, r#""analysis": "static""#)).unwrap();
        let found = last(&results, "all");
        let found = Mat::from_fn(found.len(), 1, |i, _| found[i]);
        // The rest turns by 1e-4: differences of large and small rotations.
        let off = difference(&found, &expected);
        assert!(off < 2e-3, "{modes} modes: {off:e}");
        // Equivalents by the tensor's invariants.
        let equivalent = last(&results, "equivalent");
        for (place, value) in equivalent.iter().enumerate() {
            let s: Vec<f64> = (0..6).map(|c| found[(6 * place + c, 0)]).collect();
            let first = s[0] + s[1] + s[2];
            let second =
                s[0] * s[1] + s[1] * s[2] + s[2] * s[0] - s[3] * s[3] - s[4] * s[4] - s[5] * s[5];
            let expected = (first * first - 3.0 * second).sqrt();
            assert!((value / expected - 1.0).abs() < 1e-9, "{value} {expected}");
        }
        let [value, place] = last(&results, "largest")[..] else {
            panic!("two columns")
        };
        assert_eq!(value, equivalent[place as usize]);
        assert!(equivalent.iter().all(|one| *one <= value));
        assert_eq!(last(&results, "third"), [equivalent[3]]);
    }
}

#[test]
fn a_small_load_makes_it_to_more_digits() {
    let component = bracket(1);
    let force = [1e-3, 4e-4, -7e-4];
    let expected = dense(&component.stresses[0].matrix) * held(&component, force);
    let folder = tempfile::tempdir().unwrap();
    reduced(folder.path(), &component, 4);
    let text = scene(FILLET, r#""analysis": "static""#)
        .replace("[100, 40, -70]", "[0.001, 0.0004, -0.0007]");
    let found = last(&results(folder.path(), &text).unwrap(), "all");
    let off = difference(&Mat::from_fn(found.len(), 1, |i, _| found[i]), &expected);
    assert!(off < 1e-6, "{off:e}");
}

/// With static compatibility all attachments follow their forces at once: S Φ η + S G_res L_bᵀ g of the recorded motion.
#[test]
fn forces_that_act_at_once_make_their_stress() {
    let component = bracket(1);
    let folder = tempfile::tempdir().unwrap();
    reduced(folder.path(), &component, 5);
    let text = scene(
        FILLET,
        r#""compatibility": "static", "integrator": {"generalized_alpha": {"step": 1e-5, "end": 3e-4}}"#,
    );
    let results = results(folder.path(), &text).unwrap();
    let at_end = |channel: &str| -> Vec<f64> {
        let history = results.history(channel).unwrap();
        history.row(history.nrows() - 1).iter().copied().collect()
    };
    let (y, g) = (
        at_end("motion/bracket/coordinates"),
        at_end("motion/bracket/forces"),
    );
    let field = &lowest(&component, 5).superelement.stresses[0];
    let amounts = [y, g].concat();
    let expected = &field.shapes * Mat::from_fn(amounts.len(), 1, |k, _| amounts[k]);
    let found = last(&results, "all");
    let off = difference(&Mat::from_fn(found.len(), 1, |i, _| found[i]), &expected);
    assert!(off < 1e-9, "{off:e}");
    assert!(expected.norm_max() > 1e4);
}

/// Components over frequency, against (K (1 + iη) − ω² M) u over all degrees of freedom.
#[test]
fn components_over_frequency_are_those_of_the_whole_part() {
    let component = bracket(1);
    let folder = tempfile::tempdir().unwrap();
    reduced(folder.path(), &component, 30);
    let eta = 0.02;
    let text = scene(
        r#""all": {"stress": {"body": "bracket", "field": "fillet"}}"#,
        r#""analysis": {"frequency_response": {"inputs": ["pull"], "frequencies": [40, 700, 2500], "damping": {"structural": 0.02}}}"#,
    )
    // Loads that aren't inputs would be preload.
    .replace("[100, 40, -70]", "[0, 1, 0]");
    let read = results(folder.path(), &text)
        .unwrap()
        .frequency_responses()
        .unwrap()
        .unwrap();
    let (stiffness, mass) = (dense(&component.stiffness), dense(&component.mass));
    let (rows, stress) = (
        localization(&component),
        dense(&component.stresses[0].matrix),
    );
    let n = stiffness.nrows();
    for (k, f) in read.frequency.iter().enumerate() {
        let omega = TAU * f;
        let all = Mat::from_fn(n + 6, n + 6, |i, j| match (i < n, j < n) {
            (true, true) => {
                let k = stiffness[(i, j)];
                c64::new(k - omega * omega * mass[(i, j)], eta * k)
            }
            (false, true) => c64::new(1e9 * rows[(i - n, j)], 0.0),
            (true, false) => c64::new(1e9 * rows[(j - n, i)], 0.0),
            (false, false) => c64::new(0.0, 0.0),
        });
        let load = Mat::from_fn(n + 6, 1, |i, _| {
            c64::new(if i < n { rows[(7, i)] } else { 0.0 }, 0.0)
        });
        let moved = all.partial_piv_lu().solve(&load);
        let expected: Vec<c64> = (0..stress.nrows())
            .map(|row| (0..n).map(|i| moved[(i, 0)] * stress[(row, i)]).sum())
            .collect();
        let size = expected
            .iter()
            .map(|value| value.norm())
            .fold(0.0, f64::max);
        for (row, expected) in expected.iter().enumerate() {
            let [re, im] = read.of(row, 0)[k];
            let off = (c64::new(re, im) - expected).norm() / size;
            // What thirty modes leave out.
            assert!(off < 3e-4, "{f} Hz, row {row}: {off:e}");
        }
    }
}

#[test]
fn paraview_gets_tensors_and_equivalents_at_nodes() {
    let component = bracket(1);
    let folder = tempfile::tempdir().unwrap();
    let element = lowest(&component, 6);
    let contents = Contents {
        superelement: &element.superelement,
        recovery: Some(&element.recovery),
        mesh: Some(&component.mesh),
    };
    write_superelement(
        &folder.path().join("bracket.dcb.h5"),
        &contents,
        &WriteOptions::default(),
    )
    .unwrap();
    let text = scene(
        FILLET,
        r#""integrator": {"generalized_alpha": {"step": 1e-5, "end": 2e-5}}, "fields": [{"body": "bracket", "directory": "fields", "every": 1e-5}]"#,
    );
    results(folder.path(), &text).unwrap();
    let file = std::fs::read_to_string(folder.path().join("fields/bracket_000000.vtu")).unwrap();
    assert_says(
        &file,
        &[
            r#"Name="fillet" format="binary" NumberOfComponents="6""#,
            r#"Name="fillet von Mises" format="binary""#,
        ],
    );
    // meshio reads what ParaView would; von Mises' stress is that of the tensors, and the last file has the largest of all.
    let found = python::answer(EQUIVALENTS, &folder.path().join("fields"));
    assert_eq!(found["files"], 3);
    assert!(found["size"].as_f64().unwrap() > 0.0);
    for off in ["equivalent", "largest"] {
        let off = found[off].as_f64().unwrap();
        assert!(off < 1e-12, "{found}");
    }
}

/// How far the equivalents in the files are from those of their tensors, and the largest so far from the largest.
const EQUIVALENTS: &str = r#"
import json, pathlib, sys
import meshio, numpy as np
largest, worst, over = None, 0.0, 0.0
files = sorted(pathlib.Path(sys.argv[1]).glob("*.vtu"))
for file in files:
    data = meshio.read(file).point_data
    xx, yy, zz, xy, yz, xz = data["fillet"].T
    own = np.sqrt(0.5 * ((xx - yy)**2 + (yy - zz)**2 + (zz - xx)**2) + 3 * (xy**2 + yz**2 + xz**2))
    has = np.isfinite(own)
    size = max(own[has].max(), 1e-300)
    worst = max(worst, abs(data["fillet von Mises"] - own)[has].max() / size)
    largest = own if largest is None else np.maximum(largest, own)
    over = max(over, abs(data["fillet von Mises, largest so far"] - largest)[has].max() / size)
print(json.dumps({"files": len(files), "size": size, "equivalent": worst, "largest": over}))
"#;

#[test]
fn mistakes_are_named() {
    let component = bracket(1);
    let folder = tempfile::tempdir().unwrap();
    reduced(folder.path(), &component, 4);
    for (output, analysis, told) in [
        (
            r#"{"body": "bracket", "field": "filet"}"#,
            "static",
            r#"did you mean `fillet`"#,
        ),
        (
            r#"{"body": "bracket", "field": "fillet", "place": 1000}"#,
            "static",
            "places, counted from 0",
        ),
        (
            r#"{"body": "brackt", "field": "fillet"}"#,
            "static",
            "bracket",
        ),
        (
            r#"{"body": "bracket", "field": "fillet", "measure": "mises"}"#,
            "static",
            "von_mises",
        ),
        (
            r#"{"body": "bracket", "field": "fillet"}"#,
            "kinematic",
            "takes flexible bodies as rigid",
        ),
    ] {
        let text = scene(
            &format!(r#""it": {{"stress": {output}}}"#),
            &format!(
                r#""analysis": "{analysis}", "integrator": {{"generalized_alpha": {{"step": 0.01, "end": 0.02}}}}"#
            ),
        );
        let error = results(folder.path(), &text).unwrap_err();
        assert!(error.contains(told), "{error}");
    }
    let text = scene(
        r#""it": {"stress": {"body": "bracket", "field": "fillet", "measure": "von_mises"}}"#,
        r#""analysis": {"frequency_response": {"inputs": ["pull/1"], "outputs": ["it"], "frequencies": [40]}}"#,
    );
    let error = results(folder.path(), &text).unwrap_err();
    assert!(error.contains("isn't linear in the components"), "{error}");
    // A part without any.
    let bare = component.changed(|draft| draft.stresses.clear()).unwrap();
    reduced(folder.path(), &bare, 4);
    let error = results(folder.path(), &scene(FILLET, r#""analysis": "static""#)).unwrap_err();
    assert!(
        error.contains("has no stress field") && error.contains("PART.stress.fillet.mtx"),
        "{error}"
    );
}
