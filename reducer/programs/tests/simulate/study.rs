//! `simulate study`: what it measures, what it leaves, and how it goes on.

use dcb_formats::dcb::Contents;
use dcb_reducer::{Reduction, reduce};
use dcb_samples::{RodSection, planar_rod};
use serde_json::{Value, json};

use crate::scene_folder::pendulum;
use crate::support::{Answer, Folder, list, number, says};

/// Options that take a second.
const COARSE: &str = "study scene.json --modes 1,all --compatibility strong,static --step 1e-5,1e-4,2e-4 --outputs midpoint_deflection,slider_position";

fn json_of(folder: &Folder) -> Value {
    folder.json("scene.study/study.json")
}

/// The row of these options.
fn row<'a>(study: &'a Value, modes: &str, compatibility: &str, step: f64) -> &'a Value {
    let rows = list(&study["rows"]).iter();
    let mut found = rows.filter(|row| {
        row["modes"] == json!(modes)
            && row["options"]["compatibility"] == json!(compatibility)
            && row["options"]["integrator"]["generalized_alpha"]["step"] == json!(step)
    });
    found.next().unwrap()
}

/// The texts come in this order, each where it comes first.
fn assert_order(page: &str, texts: &[&str]) {
    let places: Vec<usize> = texts.iter().map(|text| page.find(text).unwrap()).collect();
    assert!(places.is_sorted(), "{texts:?} at {places:?}");
}

#[test]
fn a_study_measures_errors_and_times_and_names_the_best_row() {
    let folder = Folder::one_turn();
    let said = folder.done(COARSE).stdout;
    says!(
        said,
        "12 rows, 12 of them stable",
        "Pareto front: ",
        "Fastest with an error up to 1e-3"
    );
    let study = json_of(&folder);
    let rows = list(&study["rows"]);
    assert_eq!(rows.len(), 12);
    for row in rows {
        assert!(number(&row["seconds_per_time"]) > 0.0, "{row}");
        assert!(
            number(&row["error"]) >= number(&study["reference"]["error"]),
            "{row}"
        );
        assert_eq!(list(&row["outputs"]).len(), 2);
    }
    // Strong: 1 or 5 modes and what of the 4 attachments has mass; static: modes alone.
    let elastic =
        |modes, compatibility| row(&study, modes, compatibility, 1e-4)["course"]["elastic"].clone();
    assert_eq!(elastic("1", "strong"), json!(5));
    assert_eq!(elastic("all", "strong"), json!(9));
    assert_eq!(elastic("1", "static"), json!(1));
    assert_eq!(elastic("all", "static"), json!(5));

    // Of second order in the step, where the step is what errs.
    let error = |modes, compatibility, step| {
        number(&row(&study, modes, compatibility, step)["error_measured"])
    };
    let ratio = error("all", "strong", 2e-4) / error("all", "strong", 1e-4);
    assert!((3.5..4.5).contains(&ratio), "{ratio}");
    // At the shortest step, what is left out errs more than the step.
    assert!(error("1", "static", 1e-5) > 1.3 * error("all", "strong", 1e-5));

    // The best row is the fastest of those within the tolerance, and the front has it.
    let within = |row: &&Value| row["error"].as_f64().is_some_and(|error| error <= 1e-3);
    let cost = |row: &&Value| number(&row["seconds_per_time"]);
    let fastest = rows
        .iter()
        .filter(within)
        .min_by(|a, b| cost(a).total_cmp(&cost(b)));
    let best = &study["best"];
    assert_eq!(best["row"], fastest.unwrap()["row"]);
    assert_eq!(best["options"], fastest.unwrap()["options"]);
    assert!(list(&study["front"]).contains(&best["row"]));
    // The front is every row that no other dominates, by the definition.
    let error = |row: &Value| number(&row["error"]);
    let seconds = |row: &Value| number(&row["seconds_per_time"]);
    for row in rows {
        let is_dominated = rows.iter().any(|other| {
            let (faster, nearer) = (seconds(other) - seconds(row), error(other) - error(row));
            faster <= 0.0 && nearer <= 0.0 && (faster < 0.0 || nearer < 0.0)
        });
        assert_eq!(row["pareto_front"], json!(!is_dominated), "{row}");
        assert_eq!(list(&study["front"]).contains(&row["row"]), !is_dominated);
    }
    says!(said, format!("row {}", best["row"]));

    let table = folder.read("scene.study/study.csv");
    assert_eq!(table.lines().count(), 13);
    assert!(
        table.starts_with("row,modes,compatibility,step [s],"),
        "{table}"
    );
    let page = folder.read("scene.study/report.html");
    says!(
        page,
        "<svg",
        "midpoint_deflection",
        "slider_position",
        "Pareto front",
        "Errors come from separate, untimed runs"
    );
    assert_order(
        &page,
        &[
            "<h2>Which variant to take</h2>",
            "<h2>Error against time</h2>",
            "<h2>Histories</h2>",
            "<h2>Errors over time</h2>",
            "<table>",
            "<h2>How it was measured</h2>",
        ],
    );
    // Every row has a mark that says what it is, and a picture has the reference and at most six rows.
    for index in 1..=12 {
        let title = format!("<title>row {index}: ");
        assert_eq!(page.matches(&title).count(), 1, "{title}");
    }
    let (_, histories) = page.split_once("<h2>Histories</h2>").unwrap();
    let (histories, _) = histories.split_once("<h2>Errors over time</h2>").unwrap();
    let shown = list(&study["front"]).len().min(6);
    for picture in histories.split("<figure>").skip(1) {
        let curves = picture.matches("<polyline class=\"chart-line\"").count();
        assert_eq!(curves, shown + 1);
        says!(picture, format!("{} rows left out", 12 - shown));
    }
    assert!(
        !page.contains("http://") || page.contains("www.w3.org"),
        "the page needs a network"
    );
    says!(folder.read("scene.study/pareto.svg"), "<svg");
}

/// Entry of the study for a row, from a run of its own and the reference's file.
#[test]
fn an_error_is_that_of_the_scene_run_with_these_options() {
    let folder = Folder::slider_crank();
    folder.done("study scene.json --step 2e-5,4e-5 --outputs midpoint_deflection");
    let study = json_of(&folder);
    let reference = folder.results_of("scene.study/histories/reference.h5");
    let expected = reference.history("midpoint_deflection").unwrap();
    folder.set_scene("record", json!({"every": 1}));
    folder.set_integrator("step", 2e-5);
    folder.done("scene.json");
    let found = folder.results().history("midpoint_deflection").unwrap();
    // The times of comparison are those of the longest step.
    assert_eq!(study["times"]["spacing"], json!(4e-5));
    let (mut most, mut squares) = (0.0_f64, 0.0);
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for index in 0..expected.nrows() {
        let error = found[(2 * index, 0)] - expected[(index, 0)];
        most = most.max(error.abs());
        squares += error * error;
        (low, high) = (
            low.min(expected[(index, 0)]),
            high.max(expected[(index, 0)]),
        );
    }
    let told = &row(&study, "all", "strong", 2e-5)["outputs"][0];
    let close = |value: &Value, expected: f64| {
        let found = number(value);
        assert!(
            (found / expected - 1.0).abs() < 1e-6,
            "{found} for {expected}"
        );
    };
    close(&told["distance"]["maximum"], most);
    close(
        &told["distance"]["rms"],
        (squares / expected.nrows() as f64).sqrt(),
    );
    close(&told["relative"]["maximum"], most / (high - low));
    // It is converged better than what it judges.
    assert!(number(&study["reference"]["error"]) < 0.05 * most / (high - low));
}

#[test]
fn a_study_goes_on_where_it_ended() {
    let folder = Folder::slider_crank();
    folder.done(COARSE);
    let (lines, table) = (
        folder.read("scene.study/rows.jsonl"),
        folder.read("scene.study/study.csv"),
    );
    // All is there: nothing is run again, and another tolerance is only another choice.
    folder.done(&format!("{COARSE} --tolerance 1e-2"));
    assert_eq!(folder.read("scene.study/rows.jsonl"), lines);
    assert_eq!(folder.read("scene.study/study.csv"), table);
    assert_eq!(json_of(&folder)["best"]["tolerance"], json!(1e-2));
    // The last line is lost, half of it remains.
    let cut = lines.trim_end().rfind('\n').unwrap() + 20;
    folder.write("scene.study/rows.jsonl", &lines[..cut]);
    folder.done(COARSE);
    let again = folder.read("scene.study/rows.jsonl");
    assert_eq!(again.lines().count(), lines.lines().count());
    assert!(again.starts_with(&lines[..cut - 19]));
    // A history is lost: its run is made again, with the same values.
    let history = "scene.study/histories/1_static_1e-4_0.8_second-order.h5";
    let before = folder.results_of(history);
    let before = before.history("midpoint_deflection").unwrap();
    std::fs::remove_file(folder.path(history)).unwrap();
    folder.done(COARSE);
    let after = folder.results_of(history);
    assert_eq!(after.history("midpoint_deflection").unwrap(), before);
}

#[test]
fn changed_inputs_are_noticed() {
    let folder = Folder::slider_crank();
    folder.edit("scene.json", |scene| {
        let outputs = scene["outputs"].as_object_mut().unwrap();
        outputs.remove("midpoint_deflection");
    });
    let words = "study scene.json --step 4e-5,8e-5";
    folder.done(words);
    folder.set_integrator("end", 0.003);
    folder.refused(words, &["rows.jsonl", "end", "0.004", "0.003", "--force"]);
    folder.done(&format!("{words} --force"));
    std::fs::remove_file(folder.path("rod.dcb.h5")).unwrap();
    folder.store("rod.dcb.h5", &planar_rod(4, &RodSection::default()));
    folder.refused(
        words,
        &["rows.jsonl", "superelements", "rod.dcb.h5", "--force"],
    );
}

#[test]
fn an_interrupted_study_keeps_its_rows() {
    let folder = Folder::slider_crank();
    folder.set_integrator("end", 1.0);
    // The first row is short, the others would take minutes.
    let words = "study scene.json --step 1e-4,1e-7 --threads 2";
    let first = "scene.study/histories/all_strong_1e-4_0.8_second-order.h5";
    let stdout = folder.interrupted(words, first);
    says!(stdout, "scene.study: stopped");
    let lines = folder.read("scene.study/rows.jsonl");
    assert_eq!(lines.lines().count(), 2, "{lines}");
    says!(lines, "course all/strong/1e-4");
}

/// The paper's form is refused at steps that it isn't stable at; let loose, it doesn't come to its end.
#[test]
fn rows_that_are_not_stable_are_told_and_fail_nothing() {
    let folder = Folder::slider_crank();
    let words = "study scene.json --compatibility strong,weak --step 2e-5,4e-5";
    let said = folder.done(words).stdout;
    says!(said, "4 rows, 2 of them stable");
    let study = json_of(&folder);
    for step in [2e-5, 4e-5] {
        let weak = row(&study, "all", "weak", step);
        assert_eq!(weak["stable"], json!(false));
        assert!(
            weak["error"].is_null() && weak["timing"].is_null(),
            "{weak}"
        );
        let reason = weak["course"]["stopped"].as_str().unwrap();
        says!(reason, "weak compatibility");
        assert_eq!(row(&study, "all", "strong", step)["stable"], json!(true));
    }
    says!(folder.read("scene.study/report.html"), "come to its end");
    folder.set_scene("allow_unstable_weak", true);
    folder.done(&format!("{words} --force"));
    let study = json_of(&folder);
    let weak = row(&study, "all", "weak", 2e-5);
    assert_eq!(weak["stable"], json!(false), "{weak}");
    let reason = weak["course"]["stopped"].as_str().unwrap();
    assert!(reason.starts_with("t = "), "{weak}");
    assert!(number(&weak["course"]["steps"]) > 0.0, "{weak}");
}

/// Steps that are too long are told in the rows that have them, in the words of a run with the same step.
#[test]
fn rows_tell_of_steps_that_are_too_long() {
    let folder = Folder::one_turn();
    folder.done("study scene.json --step 1e-4,5e-4 --outputs midpoint_deflection");
    let study = json_of(&folder);
    let told = |step: f64| -> Vec<String> {
        let row = row(&study, "all", "strong", step);
        let warnings = list(&row["course"]["warnings"]).iter();
        let warnings = warnings.map(|warning| warning.as_str().unwrap().to_owned());
        warnings
            .filter(|said| said.contains("in a period"))
            .collect()
    };
    let of_run = |step: f64| -> Vec<String> {
        folder.set_integrator("step", step);
        folder.done("scene.json --force");
        let told = folder.told().into_iter();
        told.filter(|said| said.contains("in a period")).collect()
    };
    assert_eq!(told(1e-4), of_run(1e-4));
    assert!(told(1e-4).is_empty());
    assert_eq!(told(5e-4), of_run(5e-4));
    says!(told(5e-4)[0], "take steps below");
    let page = folder.read("scene.study/report.html");
    says!(page, "take steps below");
}

#[test]
fn one_list_at_a_time_varies_around_the_scene() {
    let folder = Folder::slider_crank();
    folder.done(
        "study scene.json --modes 1,5 --step 4e-5 --inertia none,full --rho-infinity 0.5 --combine one-at-a-time",
    );
    let study = json_of(&folder);
    let options: Vec<&Value> = (list(&study["rows"]).iter())
        .map(|row| &row["options"])
        .collect();
    // The scene's own, two of the modes, one of the inertia that isn't its own, one radius, one step.
    assert_eq!(options.len(), 6, "{options:?}");
    let own = &options[0]["integrator"]["generalized_alpha"];
    assert_eq!(
        own,
        &json!({"step": 1.1635528346628864e-5, "rho_infinity": 0.8})
    );
    assert_eq!(options[1]["bodies"]["rod"]["modes"], json!(1));
    assert_eq!(
        options[3]["bodies"]["rod"]["inertia_change"],
        json!("constant")
    );
    assert_eq!(
        options[4]["integrator"]["generalized_alpha"]["rho_infinity"],
        json!(0.5)
    );
    assert_eq!(
        options[5]["integrator"]["generalized_alpha"]["step"],
        json!(4e-5)
    );
}

#[test]
fn options_that_cannot_be_used_are_refused() {
    let folder = Folder::slider_crank();
    for (words, texts) in [
        ("--modes some", &["--modes", "some", "`all`"][..]),
        ("--modes 2,9", &["--modes", "9", "more than 5"]),
        ("--compatibility loose", &["loose", "strong", "weak"]),
        (
            "--step 0",
            &[
                "generalized_alpha.step",
                "as changed by the command line",
                "is 0",
            ],
        ),
        ("--step 1", &["--step", "names 1", "0.004"]),
        ("--rho-infinity 2", &["rho_infinity", "from 0 to 1"]),
        ("--inertia all", &["all", "second-order"]),
        ("--outputs crank_angel", &["crank_angel", "crank_angle"]),
        ("--tolerance 0", &["--tolerance", "is 0"]),
        ("--tolerance NaN", &["--tolerance", "NaN"]),
    ] {
        folder.refused(&format!("study scene.json {words}"), texts);
    }
    folder.refused("study", &["SCENE.json", "Usage"]);
    folder.write("report", "mine");
    folder.refused("study scene.json -o report", &["report", "no folder"]);
    std::fs::create_dir(folder.path("mine")).unwrap();
    folder.write("mine/notes.txt", "mine");
    folder.refused(
        "study scene.json -o mine --force",
        &["mine", "holds no study"],
    );
}

#[test]
fn scenes_that_cannot_be_studied_are_refused() {
    let without = |rest: Value| Folder::with(&pendulum(rest));
    without(json!({})).refused(
        "study scene.json --modes 1",
        &["--modes", "no superelements"],
    );
    without(json!({"outputs": {}})).refused("study scene.json", &["outputs", "--outputs"]);
    without(json!({"analysis": "static"})).refused("study scene.json", &["analysis", "transient"]);
    without(json!({"integrator": {"hht": {"step": 1e-3, "end": 0.1}}})).refused(
        "study scene.json --rho-infinity 0.5",
        &["--rho-infinity", "hht"],
    );
    let adaptive = json!({"generalized_alpha": {"step": 1e-3, "end": 0.1,
        "adaptive": {"tolerance": 1e-4, "minimum_step": 1e-6, "maximum_step": 1e-2}}});
    without(json!({"integrator": adaptive}))
        .refused("study scene.json", &["adaptive", "equal steps"]);
    let folder = Folder::slider_crank();
    folder.set_scene("outputs", json!({"y": {"modal": {"body": "rod"}}}));
    folder.refused_each(&[
        ("study scene.json", &["outputs", "--outputs"]),
        ("study scene.json --outputs y", &["modal coordinates"]),
    ]);
}

/// A scene without superelements varies steps; HHT has no spectral radius to vary.
#[test]
fn rigid_scenes_and_other_methods_are_studied_too() {
    let folder = Folder::with(&pendulum(json!({
        "integrator": {"hht": {"step": 1e-3, "end": 0.1}}
    })));
    folder.done("study scene.json --outputs angle,reactions/hinge");
    let study = json_of(&folder);
    // A half, one and two: fifty steps are left. A quarter comes last.
    let steps = list(&study["rows"]).iter();
    let steps = steps.map(|row| number(&row["options"]["integrator"]["hht"]["step"]));
    assert_eq!(steps.collect::<Vec<_>>(), [5e-4, 1e-3, 2e-3, 2.5e-4]);
    let reference = list(&study["reference"]["steps"]);
    // Finer than every row. The reaction's rounding grows as 1/h²: a third run is worse, and isn't the reference.
    assert_eq!(*reference, [json!(1.25e-4), json!(6.25e-5)]);
    let names: Vec<&str> = (list(&study["outputs"]).iter())
        .map(|output| output["name"].as_str().unwrap())
        .collect();
    assert_eq!(
        names.len(),
        3,
        "force and moment of the hinge apart: {names:?}"
    );
    // Smooth and of second order: two runs are apart by three errors e of the finer, the finest row is off by 15 e.
    folder.done("study scene.json --outputs angle -o angle.study");
    let study = folder.json("angle.study/study.json");
    let finest = number(&study["rows"][3]["error_measured"]);
    let ratio = number(&study["reference"]["error"]) / finest;
    assert!((ratio - 3.0 / 15.0).abs() < 0.01, "{ratio}");
}

/// `"modes": 2` is the superelement that was reduced with two modes.
#[test]
fn a_scene_can_use_fewer_modes_than_the_file_has() {
    let folder = Folder::slider_crank();
    let component = planar_rod(4, &RodSection::default());
    for (name, modes) in [("many.dcb.h5", 7), ("few.dcb.h5", 2)] {
        let reduced = reduce(&component, &Reduction::lowest(modes), &mut ()).unwrap();
        let contents = Contents {
            superelement: &reduced.superelement,
            recovery: Some(&reduced.recovery),
            mesh: Some(&component.mesh),
        };
        folder.store_contents(name, &contents);
    }
    let mut histories = Vec::new();
    for body in [
        json!({"superelement": "few.dcb.h5"}),
        json!({"superelement": "many.dcb.h5", "modes": 2}),
        json!({"superelement": "many.dcb.h5"}),
    ] {
        folder.edit("scene.json", |scene| {
            let rod = scene["bodies"]["rod"].as_object_mut().unwrap();
            rod.remove("modes");
            rod.extend(body.as_object().unwrap().clone());
        });
        folder.done("scene.json --force");
        histories.push(folder.results().history("midpoint_deflection").unwrap());
    }
    let apart = |a: usize, b: usize| {
        let rows = 0..histories[a].nrows();
        let most = |of: &dyn Fn(usize) -> f64| rows.clone().map(of).fold(0.0, f64::max);
        most(&|row| (histories[a][(row, 0)] - histories[b][(row, 0)]).abs())
            / most(&|row| histories[b][(row, 0)].abs())
    };
    assert!(apart(1, 0) < 1e-7, "{:e}", apart(1, 0));
    assert!(
        apart(2, 0) > 1e-5,
        "two modes say less than seven: {:e}",
        apart(2, 0)
    );

    folder.set_scene("bodies/rod/modes", 8);
    folder.refused(
        "scene.json --force",
        &["bodies.rod.modes", "is 8", "7 modes"],
    );
    folder.set_scene("bodies/crank/modes", 1);
    folder.refused("scene.json --force", &["a rigid body has no `modes`"]);
}

/// Array tasks beside each other in one folder leave what one process does.
#[test]
fn shards_share_the_rows_out() {
    let folder = Folder::one_turn();
    folder.done(&format!("{COARSE} -o whole"));
    folder.refused_each(&[
        (
            &format!("{COARSE} --shard 0/2"),
            &["--shard", "I from 1 to N"],
        ),
        (
            &format!("{COARSE} --shard 1/2 --force"),
            &["--shard", "--force"],
        ),
    ]);
    let late = folder
        .done(&format!("{COARSE} -o shared --shard 2/3"))
        .stdout;
    says!(late, "4 of 12 rows are there", "without --shard");
    let running =
        ["1/3", "3/3"].map(|shard| folder.start(&format!("{COARSE} -o shared --shard {shard}")));
    let ends = running.map(Answer::at_end);
    assert!(ends.iter().all(|end| end.code == Some(0)), "{ends:?}");
    assert!(
        ends.iter()
            .any(|end| end.stdout.contains("12 rows, 12 of them stable")),
        "{ends:?}"
    );
    let errors = |study: &str| -> Vec<Value> {
        let study = folder.json(&format!("{study}/study.json"));
        let rows = list(&study["rows"]).iter();
        rows.map(|row| row["error_measured"].clone()).collect()
    };
    assert_eq!(errors("shared"), errors("whole"));
}
