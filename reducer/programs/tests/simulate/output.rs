//! Where results go, and what they never replace.

use std::fs;
use std::os::unix::fs::{PermissionsExt, symlink};
use std::path::Path;

use serde_json::json;

use crate::scene_folder::pendulum;
use crate::support::Folder;

#[test]
fn existing_results_stay_without_force() {
    let folder = Folder::with(&pendulum(json!({})));
    folder.done("scene.json");
    folder.refused("scene.json", &["scene.h5: exists already; use --force"]);
    folder.done("scene.json --force --end 0.05");
    assert_eq!(folder.results().step_count(), 51);
    folder.done("scene.json -o other.h5");
}

#[test]
fn inputs_are_never_written_over_not_even_by_force() {
    let folder = Folder::slider_crank();
    symlink(folder.path("rod.dcb.h5"), folder.path("link.h5")).unwrap();
    folder.refused_each(&[
        (
            "scene.json --force -o scene.json",
            &["scene.json: is the scene"],
        ),
        (
            "scene.json --force -o ./scene.json",
            &["scene.json: is the scene"],
        ),
        (
            "scene.json --force -o rod.dcb.h5",
            &["rod.dcb.h5: is a superelement of the scene"],
        ),
        (
            "scene.json --force -o link.h5",
            &["rod.dcb.h5: is a superelement of the scene"],
        ),
        ("scene.json --csv scene.json", &["scene.json: is the scene"]),
        (
            "scene.json --csv rod.dcb.h5",
            &["rod.dcb.h5: is a superelement of the scene"],
        ),
        ("scene.json --csv scene.h5", &["--csv", "results"]),
    ]);
    folder.done("scene.json");
    for command in [
        "plot scene.h5 -o scene.h5 --force",
        "csv scene.h5 -o scene.h5 --force",
    ] {
        folder.refused(command, &["scene.h5: is the file of the results"]);
    }
    folder.refused("scene.json --force --csv scene.h5", &["--csv", "results"]);
}

#[test]
fn a_scene_whose_superelement_has_the_name_of_the_results_keeps_it() {
    let folder = Folder::slider_crank();
    std::fs::rename(folder.path("rod.dcb.h5"), folder.path("scene.h5")).unwrap();
    folder.set_scene("bodies/rod/superelement", "scene.h5");
    folder.refused_each(&[
        ("scene.json", &["scene.h5: exists already"]),
        (
            "scene.json --force",
            &["scene.h5: is a superelement of the scene"],
        ),
    ]);
    folder.done("scene.json -o results.h5");
}

#[test]
fn places_that_cannot_be_written_are_told_before_the_run() {
    let folder = Folder::with(&pendulum(json!({})));
    std::fs::create_dir(folder.path("folder")).unwrap();
    folder.refused_each(&[
        ("scene.json -o folder", &["folder: is a folder"]),
        (
            "scene.json -o nowhere/x.h5",
            &["the folder nowhere doesn't exist"],
        ),
        (
            "scene.json --csv nowhere/x.csv",
            &["the folder nowhere doesn't exist"],
        ),
        ("scene.json -o /dev/null --force", &["/dev/null", "device"]),
    ]);
    let locked = std::fs::Permissions::from_mode(0o555);
    std::fs::set_permissions(folder.path("folder"), locked).unwrap();
    // The superuser may write everywhere.
    if std::fs::File::create(folder.path("folder/probe")).is_err() {
        folder.refused(
            "scene.json -o folder/x.h5",
            &["cannot write in this folder"],
        );
    }
    folder.refused("scene.json -o /proc/x.h5", &["/proc"]);
}

#[test]
fn a_folder_for_fields_that_cannot_be_made_leaves_earlier_results() {
    let folder = Folder::slider_crank();
    folder.done("scene.json");
    folder.set_scene(
        "fields",
        json!([{"body": "rod", "times": [0], "directory": "rod.dcb.h5/fields"}]),
    );
    folder.refused("scene.json --force", &["rod.dcb.h5/fields", "cannot write"]);
}

/// Fields of the rod at two times, in a folder.
fn with_fields(directory: &str) -> Folder {
    let folder = Folder::slider_crank();
    folder.set_scene(
        "fields",
        json!([{"body": "rod", "times": [0, 0.001], "directory": directory}]),
    );
    folder
}

fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap();
    let names = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap());
    let mut names: Vec<String> = names.collect();
    names.sort();
    names
}

#[test]
fn fields_replace_nothing_without_force() {
    let folder = with_fields("fields");
    folder.done("scene.json");
    let written = ["rod.pvd", "rod_000000.vtu", "rod_000001.vtu"];
    assert_eq!(names(&folder.path("fields")), written);
    let precious = folder.path("precious");
    for name in written {
        for other in written {
            let _ = fs::remove_file(folder.path("fields").join(other));
        }
        fs::write(&precious, "mine").unwrap();
        symlink(&precious, folder.path("fields").join(name)).unwrap();
        let refused = format!("fields/{name}: exists already; use --force");
        folder.refused("scene.json -o other.h5", &[&refused]);
        folder.done("scene.json --force");
        // A link is replaced, not what it leads to.
        assert_eq!(folder.read("precious"), "mine");
        assert_eq!(names(&folder.path("fields")), written);
    }
}

#[test]
fn fields_stay_in_the_folders_of_the_scene_and_of_the_results() {
    let other = tempfile::tempdir().unwrap();
    let outside = other.path().to_str().unwrap();
    let up = format!("../{}", other.path().file_name().unwrap().to_str().unwrap());
    for directory in [outside, &up, "link/fields"] {
        let folder = with_fields(directory);
        symlink(other.path(), folder.path("link")).unwrap();
        folder.refused(
            "scene.json",
            &[
                "fields[0].directory: leads to",
                outside,
                "--fields-in FOLDER",
            ],
        );
        assert!(names(other.path()).is_empty());
    }
    with_fields(outside).done(&format!("scene.json -o {outside}/results.h5"));
    with_fields(outside).done(&format!("scene.json --force --fields-in {outside}"));
    assert_eq!(names(other.path()).len(), 4);
}

#[test]
fn fields_never_replace_what_the_run_reads_or_writes() {
    let folder = with_fields("fields");
    folder.done("scene.json");
    let picture = folder.path("fields/rod_000000.vtu");
    fs::rename(folder.path("rod.dcb.h5"), &picture).unwrap();
    folder.set_scene("bodies/rod/superelement", "fields/rod_000000.vtu");
    let before = fs::read(&picture).unwrap();
    folder.refused("scene.json --force", &["rod_000000.vtu", "this run reads"]);
    fs::rename(&picture, folder.path("rod.dcb.h5")).unwrap();
    fs::hard_link(folder.path("rod.dcb.h5"), &picture).unwrap();
    folder.set_scene("bodies/rod/superelement", "rod.dcb.h5");
    folder.refused("scene.json --force", &["rod_000000.vtu", "this run reads"]);
    assert_eq!(fs::read(&picture).unwrap(), before);
    fs::remove_file(&picture).unwrap();
    folder.refused(
        "scene.json --force -o fields/rod.pvd",
        &["fields/rod.pvd", "this run reads or writes"],
    );
    folder.edit("scene.json", |scene| {
        let fields = &mut scene["fields"];
        let twice = fields[0].clone();
        fields.as_array_mut().unwrap().push(twice);
    });
    folder.refused("scene.json --force", &["fields[1].directory", "fields[0]"]);
}

#[test]
fn a_table_without_room_leaves_the_old_one() {
    let folder = Folder::slider_crank();
    folder.done("scene.json");
    folder.write("scene.csv", "mine");
    let answer = folder.run_within(2, "csv scene.h5 --force");
    answer.is_error(
        2,
        &["scene.csv: larger than a file may be here (ulimit -f): needs "],
    );
    assert_eq!(folder.read("scene.csv"), "mine");
    let answer = folder.run_within(2, "plot scene.h5 -o scene.csv --force");
    answer.is_error(2, &["scene.csv: larger than a file may be here"]);
    assert_eq!(folder.read("scene.csv"), "mine");
    assert_eq!(
        folder.contents().into_keys().collect::<Vec<_>>(),
        ["rod.dcb.h5", "scene.csv", "scene.h5", "scene.json"]
    );
}

#[test]
fn an_input_under_another_name_is_an_input() {
    let folder = Folder::slider_crank();
    folder.done("scene.json");
    for (input, role) in [
        ("scene.h5", "the file of the results"),
        ("scene.json", "the scene"),
        ("rod.dcb.h5", "a superelement of the scene"),
    ] {
        fs::hard_link(folder.path(input), folder.path("hard")).unwrap();
        let words = match input {
            "scene.h5" => "csv scene.h5 -o hard --force",
            _ => "scene.json -o hard --force",
        };
        folder.refused(words, &["hard: is ", role]);
        fs::remove_file(folder.path("hard")).unwrap();
    }
}
