//! Where results go, and what they never replace.

use std::os::unix::fs::{PermissionsExt, symlink};

use serde_json::json;

use super::support::{Folder, pendulum};

#[test]
fn existing_results_stay_without_force() {
    let folder = Folder::with(&pendulum(json!({})));
    folder.done("scene.json");
    folder.refuses("scene.json", &["scene.h5: exists already; use --force"]);
    folder.done("scene.json --force --end 0.05");
    assert_eq!(folder.results().step_count(), 51);
    folder.done("scene.json -o other.h5");
}

#[test]
fn inputs_are_never_written_over_not_even_by_force() {
    let folder = Folder::slider_crank();
    symlink(folder.path("rod.dcb.h5"), folder.path("link.h5")).unwrap();
    folder.refuses(
        "scene.json --force -o scene.json",
        &["scene.json: is the scene"],
    );
    folder.refuses(
        "scene.json --force -o ./scene.json",
        &["scene.json: is the scene"],
    );
    folder.refuses(
        "scene.json --force -o rod.dcb.h5",
        &["rod.dcb.h5: is a superelement of the scene"],
    );
    folder.refuses(
        "scene.json --force -o link.h5",
        &["rod.dcb.h5: is a superelement of the scene"],
    );
    folder.refuses("scene.json --csv scene.json", &["scene.json: is the scene"]);
    folder.refuses(
        "scene.json --csv rod.dcb.h5",
        &["rod.dcb.h5: is a superelement of the scene"],
    );
    folder.refuses("scene.json --csv scene.h5", &["--csv", "results"]);
    folder.done("scene.json");
    for command in [
        "plot scene.h5 -o scene.h5 --force",
        "csv scene.h5 -o scene.h5 --force",
    ] {
        folder.refuses(command, &["scene.h5: is the file of the results"]);
    }
    folder.refuses("scene.json --force --csv scene.h5", &["--csv", "results"]);
}

#[test]
fn a_scene_whose_superelement_has_the_name_of_the_results_keeps_it() {
    let folder = Folder::slider_crank();
    std::fs::rename(folder.path("rod.dcb.h5"), folder.path("scene.h5")).unwrap();
    folder.edit("scene.json", |scene| {
        scene["bodies"]["rod"]["superelement"] = json!("scene.h5")
    });
    folder.refuses("scene.json", &["scene.h5: exists already"]);
    folder.refuses(
        "scene.json --force",
        &["scene.h5: is a superelement of the scene"],
    );
    folder.done("scene.json -o results.h5");
}

#[test]
fn places_that_cannot_be_written_are_told_before_the_run() {
    let folder = Folder::with(&pendulum(json!({})));
    std::fs::create_dir(folder.path("folder")).unwrap();
    folder.refuses("scene.json -o folder", &["folder: is a folder"]);
    folder.refuses(
        "scene.json -o nowhere/x.h5",
        &["the folder nowhere doesn't exist"],
    );
    folder.refuses(
        "scene.json --csv nowhere/x.csv",
        &["the folder nowhere doesn't exist"],
    );
    folder.refuses("scene.json -o /dev/null --force", &["/dev/null", "device"]);
    let locked = std::fs::Permissions::from_mode(0o555);
    std::fs::set_permissions(folder.path("folder"), locked).unwrap();
    // The superuser may write everywhere.
    if std::fs::File::create(folder.path("folder/probe")).is_err() {
        folder.refuses(
            "scene.json -o folder/x.h5",
            &["cannot write in this folder"],
        );
    }
    folder.refuses("scene.json -o /proc/x.h5", &["/proc"]);
}

#[test]
fn a_folder_for_fields_that_cannot_be_made_leaves_earlier_results() {
    let folder = Folder::slider_crank();
    folder.done("scene.json");
    folder.edit("scene.json", |scene| {
        scene["fields"] = json!([{"body": "rod", "times": [0], "directory": "rod.dcb.h5/fields"}]);
    });
    folder.refuses("scene.json --force", &["rod.dcb.h5/fields", "cannot write"]);
}
