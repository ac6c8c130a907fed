//! `batch`: what it makes, what it leaves alone, and several processes at one folder.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::process::Child;
use std::time::{Duration, SystemTime};

use serde_json::{Value, json};

use crate::support::{Answer, Folder, number, says, start, stopped, stored};

/// A folder with the rotor and a manifest.
fn with_manifest(manifest: &Value) -> Folder {
    let folder = Folder::rotor();
    folder.write("m.json", manifest.to_string());
    folder
}

fn variants() -> Value {
    json!({
        "defaults": {"modes": 6},
        "parts": [
            {"part": "rotor.mtx"},
            {"part": "rotor.mtx", "name": "low", "max_frequency": 250},
            {"part": "rotor.mtx", "name": "spinning", "modes": 4, "enrich": ["spin"], "without_fields": true},
        ],
    })
}

/// The lines of results.jsonl.
fn rows(folder: &Folder) -> Vec<Value> {
    let text = folder.read("m.batch/results.jsonl");
    text.lines()
        .map(|line| serde_json::from_str(line).unwrap())
        .collect()
}

/// The first row of a name.
fn row(folder: &Folder, name: &str) -> Value {
    let mut rows = rows(folder).into_iter();
    rows.find(|row| row["name"] == name).unwrap()
}

/// How many rows there are of each name.
fn row_counts(folder: &Folder) -> BTreeMap<String, usize> {
    let mut counts = BTreeMap::new();
    for row in rows(folder) {
        *counts
            .entry(row["name"].as_str().unwrap().to_owned())
            .or_default() += 1;
    }
    counts
}

/// The word beside each part in the table.
fn words(table: &str) -> Vec<(String, String)> {
    let lines = table
        .lines()
        .skip(1)
        .take_while(|line| !line.starts_with("wrote "));
    lines
        .map(|line| {
            let mut words = line.split_whitespace().map(str::to_owned);
            (words.next().unwrap(), words.next().unwrap())
        })
        .collect()
}

fn all(word: &str, names: &[&str]) -> Vec<(String, String)> {
    names
        .iter()
        .map(|name| ((*name).to_owned(), word.to_owned()))
        .collect()
}

const NAMES: [&str; 3] = ["rotor", "low", "spinning"];

#[test]
fn a_batch_makes_what_single_reductions_make() {
    let folder = with_manifest(&variants());
    let table = folder.done("batch m.json --no-cache");
    assert_eq!(words(&table), all("done", &NAMES));
    assert!(table.ends_with("wrote m.batch/results.jsonl\n"), "{table}");
    for (name, options) in [
        ("rotor", "--modes 6"),
        ("low", "--max-frequency 250"),
        ("spinning", "--modes 4 --enrich spin --without-fields"),
    ] {
        folder.done(&format!("rotor.mtx {options} -o single.dcb.h5 --force"));
        let made = format!("m.batch/{name}.dcb.h5");
        let digest = folder.digest(&made);
        assert_eq!(digest, folder.digest("single.dcb.h5"), "{name}");
        let row = row(&folder, name);
        assert_eq!(row["status"], "done");
        assert_eq!(row["superelement"]["digest"], digest);
        assert_eq!(row["superelement"]["rows"], 12);
        assert!(
            number(&row["seconds"]) > 0.0 && row["error"].is_null(),
            "{row}"
        );
    }
    assert!(!folder.path("default-cache").exists());
}

#[test]
fn the_cache_is_used_unless_told_otherwise() {
    let folder = with_manifest(&variants());
    folder.done("batch m.json");
    assert!(folder.path("default-cache/CACHEDIR.TAG").exists());
    let table = folder.done("batch m.json -o other");
    assert_eq!(words(&table), all("cached", &NAMES));
    for name in NAMES {
        let [a, b] =
            ["m.batch", "other"].map(|made| folder.digest(&format!("{made}/{name}.dcb.h5")));
        assert_eq!(a, b);
    }
    // A forecast isn't made for what is only copied.
    let table = folder.done("batch m.json -o third --jobs 2 --memory 100K");
    assert_eq!(words(&table), all("cached", &NAMES));
}

#[test]
fn one_part_that_fails_does_not_stop_the_others() {
    let mut manifest = variants();
    let parts = manifest["parts"].as_array_mut().unwrap();
    parts.insert(0, json!({"part": "nowhere.mtx"}));
    parts.insert(2, json!({"part": "rotor.mtx", "name": "too-many", "interface_modes": 4000, "mesh": "broken.json"}));
    let folder = with_manifest(&manifest);
    folder.write("broken.json", "{");
    for _ in 0..2 {
        let answer = folder.run("batch m.json --no-cache");
        let says = [
            "2 of 5 parts failed",
            "nowhere: ",
            "nowhere.mtx: the stiffness matrix is not there",
            "too-many: ",
            "broken.json",
        ];
        answer.is_error(1, &says);
        let failed = words(&answer.stdout)
            .into_iter()
            .filter(|(_, word)| word == "failed");
        assert_eq!(
            failed.map(|(name, _)| name).collect::<Vec<_>>(),
            ["nowhere", "too-many"]
        );
    }
    // Failed parts are tried again, the others aren't.
    let counts = row_counts(&folder);
    assert_eq!(counts["nowhere"], 2);
    assert!(NAMES.iter().all(|name| counts[*name] == 1), "{counts:?}");
    let row = row(&folder, "too-many");
    assert_eq!(
        (&row["status"], &row["exit_status"]),
        (&json!("failed"), &json!(2))
    );
    says!(row["error"].as_str().unwrap(), "broken.json");
}

#[test]
fn only_what_has_changed_is_made_again() {
    let folder = with_manifest(&variants());
    let batch = "batch m.json --no-cache";
    folder.done(batch);
    let written = || {
        let time = |name: &str| {
            let made = fs::metadata(folder.path(&format!("m.batch/{name}.dcb.h5")));
            made.unwrap().modified().unwrap()
        };
        NAMES.map(time)
    };
    let changed = |before: [SystemTime; 3]| -> Vec<&str> {
        let now = written();
        (0..3)
            .filter(|i| now[*i] != before[*i])
            .map(|i| NAMES[i])
            .collect()
    };
    let before = written();
    assert_eq!(words(&folder.done(batch)), all("unchanged", &NAMES));
    assert_eq!(changed(before), [""; 0]);
    // Another option, a superelement that is gone, one that was replaced, one that is damaged.
    let mut manifest = variants();
    manifest["parts"][1]["max_frequency"] = json!(300);
    folder.write("m.json", manifest.to_string());
    folder.done(batch);
    assert_eq!(changed(before), ["low"]);
    folder.remove("m.batch/rotor.dcb.h5");
    folder.done(batch);
    assert_eq!(changed(before), ["rotor", "low"]);
    let before = written();
    fs::copy(
        folder.path("m.batch/low.dcb.h5"),
        folder.path("m.batch/rotor.dcb.h5"),
    )
    .unwrap();
    folder.write("m.batch/spinning.dcb.h5", "damaged");
    folder.done(batch);
    assert_eq!(changed(before), ["rotor", "spinning"]);
    // Another mass matrix, and everything.
    let before = written();
    folder.set("rotor.json", "component/damping", json!({"modal": 0.01}));
    assert_eq!(words(&folder.done(batch)), all("done", &NAMES));
    assert_eq!(changed(before), NAMES);
    let before = written();
    folder.done(&format!("{batch} --force"));
    assert_eq!(changed(before), NAMES);
}

#[test]
fn unusable_manifests_are_refused_with_the_place() {
    let folder = Folder::rotor();
    let refused = |manifest: Value, says: &str| {
        folder.write("m.json", manifest.to_string());
        folder.refused("batch m.json --no-cache", &["m.json", says]);
    };
    for (keys, says) in [
        (json!({"mode": 6}), "mode: unknown field `mode`"),
        (
            json!({"enrich": ["spinn"]}),
            "enrich: unknown variant `spinn`",
        ),
        (json!({"name": "../rotor"}), "name: "),
        (json!({"part": ".."}), "part: names no file"),
        (
            json!({"modes": 3, "max_frequency": 5}),
            "max_frequency: stands beside modes",
        ),
        (json!({"max_frequency": 0}), "max_frequency: is 0"),
    ] {
        let mut part = json!({"part": "rotor.mtx"});
        part.as_object_mut()
            .unwrap()
            .extend(keys.as_object().unwrap().clone());
        refused(json!({ "parts": [part] }), &format!("parts[0].{says}"));
    }
    let rotor = json!({"part": "rotor.mtx"});
    for (manifest, says) in [
        (
            json!({"parts": [rotor, {"part": "b.mtx", "modes": -1}]}),
            "parts[1].modes: invalid value",
        ),
        (
            json!({"parts": [rotor, {"part": "a/rotor.mtx"}]}),
            "parts[1]: is named \"rotor\"",
        ),
        (
            json!({"parts": [{"modes": 3}]}),
            "parts[0]: missing field `part`",
        ),
        (
            json!({"parts": [rotor], "default": {}}),
            "unknown field `default`",
        ),
        (
            json!({"parts": [rotor], "defaults": {"moods": 1}}),
            "defaults.moods: unknown field",
        ),
        (
            json!({"parts": [rotor], "defaults": {"name": "x"}}),
            "defaults.name: belongs to one",
        ),
        (json!({"parts": []}), "parts: is empty"),
        (json!({}), "missing field `parts`"),
    ] {
        refused(manifest, says);
    }
    folder.write("m.json", "{\n  \"parts\": [,]\n}");
    folder.refused_each(&[
        ("batch m.json --no-cache", &["m.json:2: "]),
        ("batch none.json --no-cache", &["none.json: cannot read"]),
    ]);
    folder.write("m.json", variants().to_string());
    folder.write("file", "");
    folder.refused("batch m.json --no-cache -o file", &["file: cannot make"]);
    fs::create_dir(folder.path("out")).unwrap();
    folder.write("out/results.jsonl", "{\"name\": 3}\n");
    let before = folder.names();
    folder
        .run("batch m.json --no-cache -o out")
        .is_error(2, &["out/results.jsonl:1: is no row of a batch"]);
    assert_eq!(
        folder.names().len(),
        before.len() + 1,
        "only the folder of locks"
    );
}

#[test]
fn a_part_may_override_what_is_common() {
    let folder = Folder::rod();
    fs::create_dir(folder.path("sub")).unwrap();
    fs::copy(folder.path("rod.json"), folder.path("sub/other.json")).unwrap();
    let manifest = json!({
        "defaults": {"max_frequency": 1e9, "compress": true, "mesh": "sub/other.json"},
        "parts": [{"part": "rod.mtx", "modes": 2, "compress": false}],
    });
    folder.write(
        "sub/m.json",
        manifest
            .to_string()
            .replace("rod.mtx", "../rod.mtx")
            .replace("sub/", ""),
    );
    folder.done("batch sub/m.json --no-cache");
    let options = folder.inspected("sub/m.batch/rod.dcb.h5")["options"].clone();
    assert_eq!(options["modes"]["lowest"], 2, "{options}");
    assert_eq!(options["compress"], false);
}

/// Six reductions of a part that takes some time.
fn slow() -> Folder {
    let folder = Folder::with(&dcb_samples::connecting_rod(0));
    let parts: Vec<_> = (1..=6)
        .map(|i| json!({"part": "part.mtx", "name": format!("p{i}"), "modes": 4 + i}))
        .collect();
    folder.write("m.json", json!({ "parts": parts }).to_string());
    folder
}

/// Each of its parts was made once, and verifies; nothing unfinished is left.
fn is_made_once(folder: &Folder) {
    let counts = row_counts(folder);
    assert!(
        counts.len() == 6 && counts.values().all(|count| *count == 1),
        "{counts:?}"
    );
    for i in 1..=6 {
        folder.done(&format!("verify m.batch/p{i}.dcb.h5"));
    }
    assert_eq!(folder.names_with("partial"), [""; 0]);
    assert_eq!(folder.names_with("timings"), [""; 0]);
}

#[test]
fn processes_that_share_a_folder_make_each_part_once() {
    let folder = slow();
    let cache = ["--no-cache", "--cache=c", "--no-cache", "--cache=c"];
    let running: Vec<Child> = cache
        .iter()
        .map(|cache| folder.start(&format!("batch m.json {cache}")))
        .collect();
    let answers: Vec<Answer> = running.into_iter().map(Answer::at_end).collect();
    assert!(answers.iter().all(|answer| answer.code == Some(0)));
    let made = |answer: &Answer| answer.stdout.matches(" done ").count();
    assert_eq!(answers.iter().map(made).sum::<usize>(), 6, "{answers:?}");
    let busy = answers.iter().filter(|answer| made(answer) > 0);
    assert!(busy.count() > 1, "one did it all: {answers:?}");
    is_made_once(&folder);
}

#[test]
fn a_part_that_another_process_is_at_is_left_to_it() {
    let folder = with_manifest(&variants());
    fs::create_dir_all(folder.path("m.batch/.locks")).unwrap();
    let lock = File::create(folder.path("m.batch/.locks/low")).unwrap();
    lock.lock().unwrap();
    let table = folder.done("batch m.json --no-cache");
    says!(table, "1 of them by other processes");
    assert_eq!(words(&table)[1].1, "elsewhere");
    assert!(!folder.path("m.batch/low.dcb.h5").exists());
    drop(lock);
    let table = folder.done("batch m.json --no-cache");
    assert_eq!(words(&table)[1].1, "done");
}

#[test]
fn shards_share_the_parts_out() {
    let folder = slow();
    for shard in 1..=4 {
        folder.done(&format!("batch m.json --no-cache --shard {shard}/4"));
        let names: Vec<_> = row_counts(&folder).into_keys().collect();
        let expected: &[&str] = match shard {
            1 => &["p1", "p5"],
            2 => &["p1", "p2", "p5", "p6"],
            3 => &["p1", "p2", "p3", "p5", "p6"],
            _ => &["p1", "p2", "p3", "p4", "p5", "p6"],
        };
        assert_eq!(names, expected, "{shard}");
    }
}

#[test]
fn jobs_share_the_memory() {
    let folder = slow();
    let table = folder.done("batch m.json --no-cache --jobs 3 --memory 400M");
    assert!(
        words(&table).iter().all(|(_, word)| word == "done"),
        "{table}"
    );
    assert_eq!(words(&table).len(), 6, "{table}");
    let answer = folder.run("batch m.json --no-cache --jobs 2 --memory 2M --force");
    answer.is_error(
        1,
        &[
            "6 of 6 parts failed",
            "not enough memory",
            "p1: ",
            "and 1 more",
        ],
    );
    let answer = folder.run("batch m.json --no-cache --memory 2M --force");
    answer.is_error(1, &["6 of 6 parts failed", "not enough memory"]);
}

/// Interrupted, and killed, at several moments; at the end everything is there, and nothing was made twice without need.
#[test]
fn an_interrupted_batch_goes_on_where_it_ended() {
    let folder = slow();
    let mut interrupted = 0;
    for (signal, milliseconds) in [("INT", 300), ("INT", 900), ("KILL", 500), ("INT", 100)] {
        let child = folder.start("batch m.json --no-cache --jobs 2");
        std::thread::sleep(Duration::from_millis(milliseconds));
        let Answer { code, stderr, .. } = stopped(signal, child);
        if code == Some(130) {
            interrupted += 1;
            assert!(stderr.starts_with("interrupted: "), "{stderr}");
            says!(stderr, "of 6 parts are complete; the same command goes on");
            assert_eq!(folder.names_with("partial"), [""; 0]);
        }
    }
    assert!(interrupted > 0, "all of it is done within 300 ms");
    // The processes of the killed batch keep their parts until they are done.
    let mut rounds = 0;
    while folder.done("batch m.json --no-cache").contains("elsewhere") {
        rounds += 1;
        assert!(rounds < 200);
        std::thread::sleep(Duration::from_millis(100));
    }
    assert!(rows(&folder).iter().all(|row| row["status"] == "done"));
    is_made_once(&folder);
}

#[test]
fn half_a_line_of_results_costs_one_part() {
    let folder = with_manifest(&variants());
    folder.done("batch m.json --no-cache");
    let whole = folder.read("m.batch/results.jsonl");
    folder.write("m.batch/results.jsonl", &whole[..whole.len() - 40]);
    let table = folder.done("batch m.json --no-cache");
    let remade: Vec<_> = words(&table)
        .into_iter()
        .filter(|(_, word)| word == "done")
        .collect();
    assert_eq!(remade, all("done", &["spinning"]));
    assert_eq!(rows(&folder).len(), 3);
}

/// The lines under a heading of docs/batch.md.
fn documented(heading: &str, language: &str) -> String {
    let page = fs::read_to_string(stored("docs/batch.md")).unwrap();
    let section = page.split(&format!("\n## {heading}\n")).nth(1).unwrap();
    let block = section.split(&format!("```{language}\n")).nth(1).unwrap();
    block.split("```").next().unwrap().to_owned()
}

/// As Slurm starts them: one process for each array task, all at once.
#[test]
fn the_documented_array_job_makes_every_part() {
    let folder = slow();
    fs::rename(folder.path("m.json"), folder.path("parts.json")).unwrap();
    folder.write("batch.sh", documented("Slurm", "sh"));
    let task = |id: usize| {
        let mut command = folder.shell("PATH=${0%/*}:$PATH; exec sh batch.sh");
        let command = command
            .env("DCB_CACHE", folder.path("default-cache"))
            .env("SLURM_ARRAY_TASK_ID", id.to_string())
            .env("SLURM_ARRAY_TASK_COUNT", "4")
            .env("SLURM_CPUS_PER_TASK", "1")
            .env("SLURM_MEM_PER_NODE", "2048");
        start(command)
    };
    let running: Vec<Child> = (1..=4).map(task).collect();
    for answer in running.into_iter().map(Answer::at_end) {
        assert_eq!(answer.code, Some(0), "{answer:?}");
    }
    let text = folder.read("superelements/results.jsonl");
    assert_eq!(text.lines().count(), 6, "{text}");
    for i in 1..=6 {
        folder.done(&format!("verify superelements/p{i}.dcb.h5"));
    }
}
