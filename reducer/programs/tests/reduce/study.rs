//! `study`: what it leaves in its folder, how it goes on, and what it refuses.

use std::collections::BTreeMap;
use std::fs;
use std::time::Duration;

use serde_json::Value;

use crate::support::{Folder, list, number, says, stopped};

const SMALL: &str = "study rotor.mtx --modes 3,6 --points 30";

/// The rows of the ledger by their keys.
fn rows(folder: &Folder, study: &str) -> BTreeMap<String, Value> {
    let text = folder.read(&format!("{study}/rows.jsonl"));
    let lines = text.lines().skip(1);
    lines
        .map(|line| {
            let value: Value = serde_json::from_str(line).unwrap();
            (value["key"].as_str().unwrap().to_owned(), value)
        })
        .collect()
}

#[test]
fn a_study_leaves_tables_pictures_and_a_page() {
    let folder = Folder::rotor();
    let shown = folder.done(SMALL);
    says!(
        shown,
        "rotor: 345 dofs; forces act on 12 rows (12 independent) of bearing-left, bearing-right",
        "loss factor 0.02",
        "Pareto front: ",
        "fewest unknowns with an error up to 1e-03",
        "all of them:",
        "wrote rotor.study/report.html"
    );
    let made = folder.names_with("rotor.study/");
    let expected = [
        "pareto.svg",
        "report.html",
        "rows.jsonl",
        "study.csv",
        "study.json",
    ];
    assert_eq!(made, expected.map(|name| format!("rotor.study/{name}")));

    let whole = folder.json("rotor.study/study.json");
    assert_eq!(whole["reference"]["dofs"], 345);
    assert_eq!(whole["reference"]["interfaces"][1], "bearing-right");
    let rows = list(&whole["rows"]);
    let variants: Vec<&str> = rows
        .iter()
        .map(|row| row["variant"].as_str().unwrap())
        .collect();
    let once = ["strong", "static", "weak", "strong", "free"];
    assert_eq!(variants, [once, once].concat());
    for row in rows {
        assert!(number(&row["reduction_seconds"]) > 0.0);
        // Nodal shapes of all columns are in the file.
        let columns = row["modes"].as_u64().unwrap() + 12;
        assert!(row["file_bytes"].as_u64().unwrap() > 8 * 345 * columns);
        let enriched = row["enrichment"] == serde_json::json!(["krylov"]);
        assert!(enriched || list(&row["enrichment"]).is_empty());
        let unknowns = match row["variant"].as_str().unwrap() {
            // The second block of twelve rows.
            "strong" if enriched => columns + 12,
            "strong" => row["modes"].as_u64().unwrap() + row["attachments"].as_u64().unwrap(),
            "weak" => columns,
            _ => row["modes"].as_u64().unwrap(),
        };
        assert_eq!(row["unknowns"], unknowns, "{row}");
    }
    let table = folder.read("rotor.study/study.csv");
    assert_eq!(table.lines().count(), 11);
    assert!(
        table.starts_with("variant,modes,interface_modes,enrichment,"),
        "{table}"
    );
    says!(table, "\nstrong,3,,krylov,12,27,");

    let page = folder.read("rotor.study/report.html");
    says!(page, "<svg", "mode 1, 104.637", "</html>", "Pareto front");
    let sections = [
        "<h2>Which variant to take",
        "<h2>What an error costs</h2>",
        "<h2>Responses</h2>",
        "<h2>Where the error is</h2>",
        "<table>",
        "<h2>How it was measured</h2>",
    ];
    let places: Vec<usize> = sections
        .iter()
        .map(|text| page.find(text).unwrap())
        .collect();
    assert!(places.is_sorted(), "{places:?}");

    // The fronts are the rows that no other dominates, by the definition; every row has a mark in both pictures.
    let error = |row: &Value| {
        let of = |what: &str| row["errors"][what]["largest"].as_f64().unwrap_or(0.0);
        of("collocated").max(of("transfer")).max(1e-14)
    };
    for cost in ["reduction_seconds", "unknowns"] {
        let front = list(&whole["front"][cost]);
        for (index, row) in rows.iter().enumerate() {
            let is_dominated = rows.iter().any(|other| {
                let cheaper = number(&other[cost]) - number(&row[cost]);
                let nearer = error(other) - error(row);
                cheaper <= 0.0 && nearer <= 0.0 && (cheaper < 0.0 || nearer < 0.0)
            });
            assert_eq!(
                front.contains(&index.into()),
                !is_dominated,
                "{cost}: {row}"
            );
        }
    }
    for (form, modes) in [("strong", 3), ("free", 6), ("strong+krylov", 6)] {
        let title = format!("<title>{form}, {modes} modes: ");
        assert_eq!(page.matches(&title).count(), 2, "{title}");
    }
    // The unreduced part and rows of the front.
    let shown = list(&whole["front"]["unknowns"]).len().min(6);
    let (_, responses) = page.split_once(sections[2]).unwrap();
    let (responses, _) = responses.split_once(sections[3]).unwrap();
    for picture in responses.split("<figure>").skip(1) {
        let names: std::collections::BTreeSet<&str> = (picture.split("<title>").skip(1))
            .filter_map(|title| Some(title.split_once("</title>")?.0))
            .collect();
        assert_eq!(names.len(), shown + 1, "{names:?}");
        says!(picture, format!("{} of 10 rows left out", 10 - shown));
    }
    // Nothing is fetched from anywhere.
    let links = page.replace("http://www.w3.org/2000/svg", "");
    assert!(!links.contains("http") && !links.contains("src=") && !links.contains("<script"));
    assert!(folder.read("rotor.study/pareto.svg").starts_with("<svg"));
}

#[test]
fn interface_modes_are_rows_of_their_own() {
    let folder = Folder::rotor();
    folder.done(
        "study rotor.mtx --modes 5 --points 20 --interface-modes 4 --variants strong,free --enrich none -o s",
    );
    let keys: Vec<String> = rows(&folder, "s").into_keys().collect();
    assert_eq!(keys, ["free/5", "reference", "strong/5", "strong/5/4"]);
    let whole = folder.json("s/study.json");
    let of = |row: usize, name: &str| {
        let interfaces = whole["rows"][row]["errors"]["static_response"]
            .as_array()
            .unwrap();
        let named = interfaces
            .iter()
            .find(|one| one["interface"] == name)
            .unwrap();
        number(&named["error"])
    };
    assert_eq!(whole["rows"][1]["asked_interface_modes"], 4);
    assert!(of(0, "bearing-left") < 1e-9 && of(1, "bearing-left") > 1e-4);
}

#[test]
fn further_columns_are_rows_of_their_own() {
    let folder = Folder::rotor();
    let shown = folder.done(
        "study rotor.mtx --modes 5 --points 20 --enrich krylov,krylov+spin --variants strong,static",
    );
    let keys: Vec<String> = rows(&folder, "rotor.study").into_keys().collect();
    let expected = [
        "reference",
        "static/5",
        "strong/5",
        "strong/5+krylov",
        "strong/5+spin+krylov",
    ];
    assert_eq!(keys, expected);
    says!(shown, "\nstrong+spin+krylov ");
    let whole = folder.json("rotor.study/study.json");
    let rows = list(&whole["rows"]);
    let spin = |row: usize| number(&rows[row]["spin_error"]);
    // strong, static, with spin and krylov, with krylov.
    assert_eq!(spin(0), number(&whole["reference"]["spin"][5]));
    assert_eq!(spin(0), spin(1));
    assert!(spin(2) < 1e-6 && spin(2) < spin(3) && spin(3) < spin(0));
    assert_eq!(rows[2]["enrichment"], serde_json::json!(["spin", "krylov"]));
}

/// Rows of studies from before there were further columns in them.
#[test]
fn an_older_study_goes_on() {
    let folder = Folder::rotor();
    folder.done(&format!("{SMALL} --enrich none"));
    let table = folder.read("rotor.study/study.csv");
    let ledger = folder.read("rotor.study/rows.jsonl");
    let older: Vec<String> = (ledger.lines())
        .map(|line| {
            let mut line: Value = serde_json::from_str(line).unwrap();
            if let Some(row) = line.pointer_mut("/row/row").and_then(Value::as_object_mut) {
                assert!(row.remove("enrichment").is_some() && row.remove("spin_error").is_some());
            }
            line.to_string()
        })
        .collect();
    let older = older.join("\n") + "\n";
    folder.write("rotor.study/rows.jsonl", &older);
    folder.done(&format!("{SMALL} --enrich none"));
    assert_eq!(folder.read("rotor.study/rows.jsonl"), older);
    assert_eq!(folder.read("rotor.study/study.csv"), table);
    // The rows that are there now besides are added, and no other is made again.
    folder.done(SMALL);
    let after = folder.read("rotor.study/rows.jsonl");
    assert!(after.starts_with(&older));
    let keys: Vec<String> = rows(&folder, "rotor.study").into_keys().collect();
    assert_eq!(keys.len(), 11);
    assert!(keys.contains(&"strong/6+krylov".to_owned()), "{keys:?}");
    let now = folder.read("rotor.study/study.csv");
    // What is said last, whether a row is on a front, hangs on the other rows.
    let alone = |row: &str| row.rsplitn(3, ',').last().map(str::to_owned);
    let now: Vec<_> = now.lines().map(alone).collect();
    assert!(
        table.lines().all(|row| now.contains(&alone(row))),
        "{now:?}"
    );
}

#[test]
fn a_study_goes_on_where_it_ended() {
    let folder = Folder::rotor();
    folder.done(SMALL);
    let first = rows(&folder, "rotor.study");
    let page = folder.read("rotor.study/report.html");

    // All is there: nothing is made again, and the same page comes of it.
    let ledger = folder.read("rotor.study/rows.jsonl");
    folder.remove("rotor.study/report.html");
    folder.done(SMALL);
    assert_eq!(folder.read("rotor.study/rows.jsonl"), ledger);
    assert_eq!(folder.read("rotor.study/report.html"), page);

    // Stopped in the middle of a line: that row and those after it are made again, and no other.
    let lines: Vec<&str> = ledger.lines().collect();
    let cut = format!("{}\n{}", lines[..5].join("\n"), &lines[5][..40]);
    folder.write("rotor.study/rows.jsonl", cut);
    folder.done(SMALL);
    let again = rows(&folder, "rotor.study");
    assert_eq!(
        again.keys().collect::<Vec<_>>(),
        first.keys().collect::<Vec<_>>()
    );
    let kept = folder.read("rotor.study/rows.jsonl");
    assert!(kept.starts_with(&format!("{}\n", lines[..5].join("\n"))));
    // What isn't a time is the same to the last bit.
    for (key, row) in first.iter().filter(|(key, _)| *key != "reference") {
        assert_eq!(
            row["row"]["row"]["errors"], again[key]["row"]["row"]["errors"],
            "{key}"
        );
    }
}

#[test]
fn bending_modes_alone_have_no_forces_along_the_rod() {
    let folder = Folder::rod();
    folder.done("study rod.mtx --modes 5 --variants strong,free");
    let study = folder.json("rod.study/study.json");
    // Three rigid motions and five modes for four rows, but none of the modes stretches the rod.
    let row = |variant: &str| {
        let rows = list(&study["rows"]);
        let mut rows = rows.iter().filter(|row| row["variant"] == variant);
        rows.next().unwrap()["errors"]["interface_force"].clone()
    };
    assert!(row("strong").is_object());
    assert!(row("free").is_null());
}

#[test]
fn rows_of_another_study_are_not_mixed_in() {
    let folder = Folder::rotor();
    folder.done(SMALL);
    folder.refused_each(&[
        (
            "study rotor.mtx --modes 3,6 --points 31",
            &["rows.jsonl", "`points` is 30 there and 31 now", "--force"],
        ),
        (
            "study rotor.mtx --modes 3,8 --points 30",
            &["`band` is \"up to half of mode 6\" there and \"up to half of mode 8\" now"],
        ),
    ]);
    folder.set("rotor.json", "component/name", "<b>other");
    folder.refused(SMALL, &["`inputs.mesh`", "--force"]);
    let before = folder.read("rotor.study/rows.jsonl");
    folder.done(&format!("{SMALL} --force"));
    assert!(folder.read("rotor.study/rows.jsonl") != before);
    let page = folder.read("rotor.study/report.html");
    says!(page, "&lt;b&gt;other: a study");
    assert!(!page.contains("<b>"), "names are escaped");
}

#[test]
fn slips_are_refused_before_anything_is_made() {
    let folder = Folder::rotor();
    for (options, says) in [
        ("--modes 0", "numbers above 0 are wanted"),
        ("--modes 5,x", "numbers above 0 are wanted"),
        ("--variants strong,rubin", "possible values"),
        ("--interface-modes 0", "numbers above 0 are wanted"),
        ("--enrich gravity", "spin, loads, krylov"),
        ("--enrich spin+", "spin, loads, krylov"),
        ("--enrich loads", "PART.load.NAME.mtx"),
        (
            "--enrich spin --variants static",
            "the only one that has further columns",
        ),
        ("--band 10", "two frequencies in Hz"),
        ("--band 20:10", "two frequencies in Hz"),
        ("--band 0:10", "two frequencies in Hz"),
        ("--points 1", "2..=100000"),
        ("--loss-factor 0", "above 0 and up to 1"),
        ("--tolerance -1e-3", "a relative error above 0"),
        ("-o rotor.mtx", "is no folder"),
    ] {
        folder.refused(&format!("study rotor.mtx {options}"), &[says]);
    }
    folder.refused("study missing.mtx", &["missing.mtx"]);
    fs::create_dir(folder.path("there")).unwrap();
    folder.write("there/notes.txt", "mine");
    folder.refused(
        "study rotor.mtx -o there",
        &["there", "holds no study", "--force"],
    );
    folder.edit("rotor.json", |description| {
        for interface in description["component"]["interfaces"]
            .as_array_mut()
            .unwrap()
        {
            interface["role"] = "output".into();
        }
    });
    folder.refused("study rotor.mtx", &["interfaces where forces act"]);
}

#[test]
fn an_interrupted_study_keeps_its_rows() {
    let folder = Folder::with(&dcb_samples::connecting_rod(0));
    let arguments = "study part.mtx --modes 4,6,8,10,12,14 --points 20 --variants strong,free";
    let mut child = folder.start(arguments);
    let ledger = folder.path("part.study/rows.jsonl");
    let complete = || fs::read_to_string(&ledger).map_or(0, |text| text.matches('\n').count());
    // The settings, the reference and a row.
    while complete() < 3 && child.try_wait().unwrap().is_none() {
        std::thread::sleep(Duration::from_millis(5));
    }
    let answer = stopped("INT", child);
    assert_eq!(answer.code, Some(130), "{answer:?}");
    says!(answer.stderr, "interrupted: ", "goes on from there");
    assert_eq!(folder.names_with("timing"), [""; 0]);
    assert_eq!(folder.names_with("partial"), [""; 0]);
    let before = fs::read_to_string(&ledger).unwrap();
    folder.done(arguments);
    let after = fs::read_to_string(&ledger).unwrap();
    let whole = before.rfind('\n').unwrap() + 1;
    assert!(after.starts_with(&before[..whole]));
    assert_eq!(after.lines().count(), 2 + 18);
}

/// Array tasks beside each other in one folder leave what one process does.
#[test]
fn shards_share_the_reductions_out() {
    let folder = Folder::rotor();
    let whole = folder.done(&format!("{SMALL} -o whole"));
    says!(whole, "wrote whole/report.html");
    folder
        .run(&format!("{SMALL} --shard 3/2"))
        .is_error(2, &["--shard", "I from 1 to N"]);
    folder
        .run(&format!("{SMALL} --shard 1/2 --force"))
        .is_error(2, &["--shard", "--force"]);
    let first = folder.done(&format!("{SMALL} -o shared --shard 1/3"));
    says!(first, "of 10 rows are there", "without --shard");
    assert!(!folder.path("shared/report.html").exists());
    let running =
        ["2/3", "3/3"].map(|shard| folder.start(&format!("{SMALL} -o shared --shard {shard}")));
    let ends = running.map(crate::support::Answer::at_end);
    assert!(ends.iter().all(|end| end.code == Some(0)), "{ends:?}");
    assert!(
        ends.iter()
            .any(|end| end.stdout.contains("wrote shared/report.html")),
        "{ends:?}"
    );
    let keys = |study: &str| rows(&folder, study).into_keys().collect::<Vec<_>>();
    assert_eq!(keys("shared"), keys("whole"));
    for (key, row) in rows(&folder, "shared") {
        let other = &rows(&folder, "whole")[&key];
        assert_eq!(row["row"]["errors"], other["row"]["errors"], "{key}");
    }
    assert_eq!(folder.names_with("timing"), [""; 0]);
}
