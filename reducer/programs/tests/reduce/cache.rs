//! `--cache`: what is served, what isn't, and what several processes, a crash or a full disk do to it.

use std::fs::{self, File};
use std::path::PathBuf;
use std::time::Duration;

use dcb_workflow::cache::{Cache, ModeRequest, Request};
use serde_json::Value;

use crate::support::{Answer, Folder, answer, list, says, stopped};

const SERVED: &str = "from the cache";

/// The entries of the cache `c`.
fn listed(folder: &Folder) -> Value {
    serde_json::from_str(&folder.done("cache --cache=c --json")).unwrap()
}

fn keys(folder: &Folder) -> Vec<String> {
    let key = |entry: &Value| entry["key"].as_str().unwrap().to_owned();
    list(&listed(folder)["entries"]).iter().map(key).collect()
}

/// The lock of an entry.
fn lock(folder: &Folder, key: &str) -> File {
    let path = folder.path(&format!("c/{key}.lock"));
    File::options().read(true).write(true).open(path).unwrap()
}

/// The superelements in the cache.
fn kept(folder: &Folder) -> Vec<PathBuf> {
    let mut found: Vec<_> = fs::read_dir(folder.path("c"))
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.to_str().unwrap().ends_with(".dcb.h5"))
        .collect();
    found.sort();
    found
}

#[test]
fn the_second_reduction_is_a_copy_of_the_first() {
    let folder = Folder::rotor();
    let first = folder.done("rotor.mtx --modes 6 --cache=c -o one.dcb.h5");
    assert!(!first.contains(SERVED), "{first}");
    let second = folder
        .run("rotor.mtx --modes 6 --cache=c -o two.dcb.h5 --timings t.json -v")
        .stdout;
    for says in [
        SERVED,
        "rotor: 6 modes and 12 attachment rows (rank 12)",
        "104.637010551",
        "bearing-left",
        "wrote two.dcb.h5",
    ] {
        assert!(second.contains(says), "{says}: {second}");
    }
    assert!(folder.bytes("one.dcb.h5") == folder.bytes("two.dcb.h5"));
    folder.done("verify two.dcb.h5 --component rotor.mtx");
    let costs = folder.json("t.json");
    assert!(costs["work"].is_null(), "{costs}");
    let refused = "rotor.mtx --modes 6 --cache=c -o two.dcb.h5";
    folder.refused(refused, &["two.dcb.h5", "--force"]);
    folder.done(&format!("{refused} --force"));
    // Without the option nothing is looked up or kept.
    let plain = folder.done("rotor.mtx --modes 6 -o three.dcb.h5");
    assert!(!plain.contains(SERVED) && !folder.path("default-cache").exists());
    assert_eq!(keys(&folder).len(), 1);
}

#[test]
fn an_entry_serves_every_form_of_the_file() {
    let folder = Folder::rotor();
    let forms = ["", "--without-fields", "--compress"];
    for (i, first) in forms.iter().enumerate() {
        let cache = format!("--cache=c{i}");
        folder.done(&format!(
            "rotor.mtx --modes 5 {cache} {first} -o made.dcb.h5 --force"
        ));
        for form in forms {
            let shown = folder.done(&format!(
                "rotor.mtx --modes 5 {cache} {form} -o served.dcb.h5 --force"
            ));
            assert!(shown.contains(SERVED), "{first} then {form}: {shown}");
            folder.done(&format!(
                "rotor.mtx --modes 5 {form} -o plain.dcb.h5 --force"
            ));
            let [served, plain] =
                ["served.dcb.h5", "plain.dcb.h5"].map(|name| folder.inspected(name));
            assert_eq!(served["digest"], plain["digest"]);
            assert_eq!(served["options"], plain["options"], "{form}");
        }
    }
}

#[test]
fn other_requests_are_not_served() {
    let folder = Folder::rotor();
    folder.done("rotor.mtx --modes 6 --cache=c -o first.dcb.h5");
    let others = [
        "--modes 5",
        "--max-frequency 250",
        "--modes 6 --enrich spin",
        "--modes 6 --interface-modes 4",
        "--modes 6 --allow-grounded",
        "--modes 6 --allow-loose",
        "--modes 6 --factor single",
    ];
    for options in others {
        let shown = folder.done(&format!(
            "rotor.mtx {options} --cache=c -o other.dcb.h5 --force"
        ));
        assert!(!shown.contains(SERVED), "{options}: {shown}");
    }
    assert_eq!(keys(&folder).len(), 1 + others.len());
    // The same file under another name, and a file with the same name that says something else.
    for file in ["mtx", "mass.mtx", "json"] {
        folder.write(
            &format!("copy.{file}"),
            folder.bytes(&format!("rotor.{file}")),
        );
    }
    let shown = folder.done("copy.mtx --modes 6 --cache=c");
    assert!(!shown.contains(SERVED), "{shown}");
    folder.set(
        "rotor.json",
        "component/damping",
        serde_json::json!({"modal": 0.01}),
    );
    let shown = folder
        .run("rotor.mtx --modes 6 --cache=c -o changed.dcb.h5 -v")
        .stdout;
    assert!(
        !shown.contains(SERVED) && shown.contains("0.01000"),
        "{shown}"
    );
    // What doesn't decide the result doesn't matter.
    let shown = folder.done(
        "rotor.mtx --modes 6 --cache=c -o again.dcb.h5 --threads 1 --memory 3G --factor disk",
    );
    assert!(shown.contains(SERVED), "{shown}");
}

#[test]
fn a_damaged_entry_is_told_and_made_anew() {
    let folder = Folder::rotor();
    let command = "rotor.mtx --modes 6 --cache=c -o part.dcb.h5 --force";
    folder.done(command);
    let right = folder.digest("part.dcb.h5");
    let entry = kept(&folder).pop().unwrap();
    let record = folder.path(&format!("c/{}.json", keys(&folder)[0]));
    let whole = fs::read(&entry).unwrap();
    // Somewhere in the nodal fields, which make up most of the file; half of it; nothing; a record that is none.
    let mut flipped = whole.clone();
    flipped[whole.len() / 2] ^= 1;
    for (path, damaged) in [
        (&entry, flipped),
        (&entry, whole[..whole.len() / 2].to_vec()),
        (&entry, Vec::new()),
        (&record, b"{}".to_vec()),
    ] {
        fs::write(path, damaged).unwrap();
        let answer = folder.warned(command, &["damaged superelement", "made anew"]);
        assert!(!answer.stdout.contains(SERVED));
        assert_eq!(folder.digest("part.dcb.h5"), right);
        assert!(folder.done(command).contains(SERVED));
    }
    fs::remove_file(&entry).unwrap();
    folder.warned(command, &["damaged superelement"]);
}

#[test]
fn what_killed_processes_left_is_removed() {
    let folder = Folder::rotor();
    folder.done("rotor.mtx --modes 4 --cache=c -o part.dcb.h5");
    let other = "0123456789abcdef".repeat(4);
    for name in [
        format!("c/.{other}.dcb.h5.77.partial"),
        format!("c/.{other}.json.77.partial"),
        format!("c/{other}.dcb.h5"),
    ] {
        folder.write(&name, "half of it");
    }
    folder.write("c/notes.txt", "mine");
    folder.done("rotor.mtx --modes 5 --cache=c -o part.dcb.h5 --force");
    let left = folder.names_with(&other);
    assert!(left.iter().all(|name| name.ends_with(".lock")), "{left:?}");
    assert_eq!(folder.read("c/notes.txt"), "mine");
    assert_eq!(keys(&folder).len(), 2);
}

#[test]
fn the_superelement_that_was_not_used_for_longest_leaves_first() {
    let folder = Folder::rotor();
    let reduce = |modes: usize, limit: &str| {
        folder.done(&format!(
            "rotor.mtx --modes {modes} --cache=c --cache-limit {limit} -o part.dcb.h5 --force"
        ))
    };
    reduce(4, "1G");
    let size = fs::metadata(&kept(&folder)[0]).unwrap().len();
    let room_for_two = format!("{}K", size * 5 / 2 / 1024);
    reduce(5, &room_for_two);
    assert!(reduce(4, &room_for_two).contains(SERVED));
    reduce(6, &room_for_two);
    let modes: Vec<_> = (list(&listed(&folder)["entries"]).iter())
        .map(|entry| entry["record"]["modes"].clone())
        .collect();
    assert_eq!(modes, [6, 4], "5 was not used again");
    // Nothing is removed while another process reads it.
    let lock = lock(&folder, &keys(&folder)[1]);
    lock.lock_shared().unwrap();
    reduce(3, &format!("{}K", size * 3 / 2 / 1024));
    assert_eq!(keys(&folder).len(), 2, "4 is in use, 6 is gone, 3 is new");
    assert!(reduce(4, "1G").contains(SERVED));
    let cleared = folder.done("cache --cache=c --clear");
    says!(cleared, "is in use and stays", "removed 1 of 2");
    drop(lock);
    // One that is larger than the whole cache isn't kept.
    folder.warned(
        "rotor.mtx --modes 8 --cache=c --cache-limit 1K -o part.dcb.h5 --force",
        &["isn't kept", "--cache-limit"],
    );
    assert_eq!(keys(&folder).len(), 1);
}

#[test]
fn processes_that_want_the_same_make_it_once() {
    let folder = Folder::with(&dcb_samples::connecting_rod(0));
    let made = |number: usize| format!("{number}.dcb.h5");
    let running = [0, 1, 2, 3]
        .map(|number| folder.start(&format!("part.mtx --modes 8 --cache=c -o {}", made(number))));
    let answers = running.map(Answer::at_end);
    assert!(answers.iter().all(|answer| answer.code == Some(0)));
    let served = answers
        .iter()
        .filter(|answer| answer.stdout.contains(SERVED));
    assert_eq!(served.count(), 3, "{answers:?}");
    let first = folder.bytes(&made(0));
    assert!((1..4).all(|number| folder.bytes(&made(number)) == first));
    let is_waiting = |answer: &Answer| answer.stderr.contains("waiting: another process");
    assert!(answers.iter().any(is_waiting), "{answers:?}");
}

#[test]
fn a_process_that_waits_can_be_interrupted_and_one_that_dies_is_succeeded() {
    let folder = Folder::rotor();
    folder.done("rotor.mtx --modes 6 --cache=c -o first.dcb.h5");
    let key = keys(&folder).pop().unwrap();
    folder.done("cache --cache=c --clear");
    let lock = lock(&folder, &key);
    lock.lock().unwrap();
    let before = folder.names();
    let command = "rotor.mtx --modes 6 --cache=c -o second.dcb.h5";
    let child = folder.start(command);
    std::thread::sleep(Duration::from_millis(700));
    let answer = stopped("INT", child);
    assert_eq!(answer.code, Some(130), "{answer:?}");
    says!(
        answer.stderr,
        "waiting: ",
        "interrupted: nothing was written\n"
    );
    assert_eq!(folder.names(), before);
    // The lock goes with the process that had it.
    let child = folder.start(command);
    std::thread::sleep(Duration::from_millis(300));
    drop(lock);
    let answer = Answer::at_end(child);
    assert!(
        answer.code == Some(0) && !answer.stdout.contains(SERVED),
        "{answer:?}"
    );
}

#[test]
fn a_killed_reduction_leaves_nothing_that_is_taken_for_a_result() {
    let folder = Folder::with(&dcb_samples::connecting_rod(1));
    let command = "part.mtx --modes 10 --cache=c -o part.dcb.h5 --force";
    for milliseconds in [100, 600, 1500] {
        let child = folder.start(command);
        std::thread::sleep(Duration::from_millis(milliseconds));
        stopped("KILL", child);
    }
    folder.done(command);
    folder.done("verify part.dcb.h5");
    assert_eq!(folder.names_with("c/."), [""; 0]);
}

#[test]
fn a_cache_that_cannot_be_used_is_no_obstacle() {
    let folder = Folder::rotor();
    folder.write("file", "not a folder");
    folder.warned(
        "rotor.mtx --modes 4 --cache=file -o part.dcb.h5",
        &["the cache isn't used", "file"],
    );
    folder.done("verify part.dcb.h5");
    let mut command = folder.command("rotor.mtx --modes 4 --cache -o env.dcb.h5");
    folder.refused("cache --cache=c --clear 12", &["no key begins with", "12"]);
    answer(command.env("DCB_CACHE_LIMIT", "much")).is_error(2, &["DCB_CACHE_LIMIT", "much", "8G"]);
    let done = answer(command.env("DCB_CACHE_LIMIT", "1G"));
    assert_eq!(done.code, Some(0), "{done:?}");
    let json: Value = serde_json::from_str(&folder.done("cache --json")).unwrap();
    assert_eq!(list(&json["entries"]).len(), 1, "{json}");
    assert_eq!(json["limit_bytes"], 20_u64 << 30);
}

#[test]
fn the_cache_is_listed_and_cleared() {
    let folder = Folder::rotor();
    let empty = folder.done("cache --cache=c");
    assert!(
        empty.starts_with("0 superelements, 0 MB of at most 20.0 GB, in c"),
        "{empty}"
    );
    assert!(!folder.path("c").exists());
    folder.done("rotor.mtx --modes 6 --cache=c -o one.dcb.h5");
    folder.done("rotor.mtx --max-frequency 250 --cache=c -o two.dcb.h5");
    let shown = folder.done("cache --cache=c");
    says!(
        shown,
        "rotor",
        "6 modes",
        "below 250 Hz",
        "s ago",
        "2 superelements"
    );
    let entries = listed(&folder);
    let bytes: u64 = kept(&folder)
        .iter()
        .map(|path| fs::metadata(path).unwrap().len())
        .sum();
    assert_eq!(entries["total_bytes"], bytes);
    assert_eq!(
        entries["entries"][0]["record"]["request"]["modes"]["below_hertz"],
        250.0
    );
    let key = keys(&folder)[0].clone();
    let cleared = folder.done(&format!("cache --cache=c --clear {}", &key[..12]));
    says!(cleared, "removed 1 of 1");
    assert!(!keys(&folder).contains(&key) && keys(&folder).len() == 1);
    folder.done("cache --cache=c --clear");
    let left = folder.names_with("c/");
    assert!(
        left.iter()
            .all(|name| name.ends_with(".lock") || name.ends_with("CACHEDIR.TAG")),
        "{left:?}"
    );
}

/// The rotor has modes at 104.6 (2), 187.8, 212.3, 224.6, 238.7, 284.2 (2) Hz.
#[test]
fn an_entry_with_enough_modes_is_found() {
    let folder = Folder::rotor();
    for (name, modes) in [
        ("a", "--modes 4"),
        ("b", "--modes 6"),
        ("c", "--modes 8 --enrich spin"),
    ] {
        folder.done(&format!("rotor.mtx {modes} --cache=c -o {name}.dcb.h5"));
    }
    let cache = Cache::existing(&folder.path("c"), 0);
    let entries = cache.entries();
    let plain = entries
        .iter()
        .find(|entry| entry.record.modes == 6)
        .unwrap();
    let found = |modes: ModeRequest| {
        let request = Request {
            modes,
            ..plain.record.request.clone()
        };
        cache
            .find_at_least(&request)
            .map(|entry| entry.record.modes)
    };
    let (lowest, below) = (ModeRequest::Lowest, ModeRequest::BelowHertz);
    assert_eq!(
        [3, 4, 5, 7].map(|count| found(lowest(count))),
        [Some(4), Some(4), Some(6), None]
    );
    assert_eq!(
        [222.0, 250.0, 290.0].map(|hertz| found(below(hertz))),
        [Some(4), Some(6), None]
    );
    let other = Request {
        inputs: Default::default(),
        ..plain.record.request.clone()
    };
    assert_eq!(cache.find_at_least(&other), None);
}
