//! Archives for co-simulation. How they move is checked beside the library (`runtime/fmu`); here it is a file that looks like one.

use std::io::{Cursor, Read as _};

use dcb_cosimulation::MARK;
use serde_json::json;

use crate::support::{Folder, has_all, stored};

/// A file that begins like a shared library for Linux and has the words of ours.
fn library(mark: &str, function: &str) -> Vec<u8> {
    let mut content = vec![0x7f, b'E', b'L', b'F', 2, 1, 1, 0];
    content.extend([0; 8]);
    content.extend([3, 0, 0x3e, 0]);
    content.extend(format!("\0{function}\0{mark}\0").bytes());
    content
}

fn folder() -> Folder {
    let folder = Folder::empty();
    for name in ["scene.json", "rod.dcb.h5"] {
        let sample = stored("samples/slider-crank").join(name);
        folder.write(name, std::fs::read(sample).unwrap());
    }
    folder.write("library.so", library(MARK, "fmi3InstantiateCoSimulation"));
    folder
}

fn archive(folder: &Folder, name: &str) -> zip::ZipArchive<Cursor<Vec<u8>>> {
    zip::ZipArchive::new(Cursor::new(folder.bytes(name))).unwrap()
}

fn text(archive: &mut zip::ZipArchive<Cursor<Vec<u8>>>, name: &str) -> String {
    let mut text = String::new();
    let mut member = archive.by_name(name).unwrap();
    member.read_to_string(&mut text).unwrap();
    text
}

#[test]
fn an_archive_has_all_that_a_unit_needs() {
    let folder = folder();
    let answer = folder.run("fmu scene.json -o crank-1.fmu --library library.so");
    assert_eq!(answer.code, Some(0), "{}", answer.stderr);
    has_all(
        &answer.stdout,
        &[
            "4 parameters, 0 inputs, 5 outputs",
            "rod.dcb.h5 from",
            "crank-1.fmu: FMI 3.0",
        ],
    );
    let mut packed = archive(&folder, "crank-1.fmu");
    let names: Vec<String> = (0..packed.len())
        .map(|index| packed.by_index(index).unwrap().name().unwrap().into_owned())
        .collect();
    for name in [
        "modelDescription.xml",
        "terminalsAndIcons/terminalsAndIcons.xml",
        "documentation/index.html",
        "documentation/licenses/license.txt",
        "binaries/x86_64-linux/crank_1.so",
        "resources/scene.json",
        "resources/rod.dcb.h5",
    ] {
        assert!(
            names.iter().any(|found| found == name),
            "{name} in {names:?}"
        );
    }
    assert_eq!(names.len(), 7);
    let description = text(&mut packed, "modelDescription.xml");
    has_all(
        &description,
        &[
            "fmiVersion=\"3.0\" modelName=\"crank-1\"",
            "modelIdentifier=\"crank_1\"",
            "name=\"slider_position.x\" valueReference=\"1000003\" causality=\"output\"",
            "<Unit name=\"m/s^2\">\n      <BaseUnit m=\"1\" s=\"-2\"/>",
        ],
    );
    // Without `record`, which says nothing here, the scene is the same.
    let scene: serde_json::Value =
        serde_json::from_str(&text(&mut packed, "resources/scene.json")).unwrap();
    assert!(scene.get("record").is_none());
    let step = |scene: &serde_json::Value| scene["integrator"]["generalized_alpha"]["step"].clone();
    assert_eq!(step(&scene), step(&folder.json("scene.json")));
    // Made again it is the same, byte for byte.
    let again = folder.run("fmu scene.json -o other.fmu --library library.so -q");
    assert_eq!((again.code, again.stdout.as_str()), (Some(0), ""));
    let [first, second] = ["crank-1.fmu", "other.fmu"].map(|name| {
        let mut packed = archive(&folder, name);
        text(&mut packed, "resources/scene.json")
    });
    assert_eq!(first, second);
}

#[test]
fn archives_are_whole_or_not_there() {
    let folder = folder();
    folder.write("scene.fmu", "mine");
    let before = folder.contents();
    folder.refused(
        "fmu scene.json --library library.so",
        &["scene.fmu", "exists"],
    );
    folder.refused(
        "fmu scene.json -o rod.dcb.h5 --force --library library.so",
        &["rod.dcb.h5", "a superelement of the scene"],
    );
    folder.refused(
        "fmu scene.json -o library.so --force --library library.so",
        &["library.so", "the shared library"],
    );
    folder.refused(
        "fmu scene.json -o new.fmu --library nothing.so",
        &["nothing.so"],
    );
    assert_eq!(folder.contents(), before);
    assert_eq!(
        folder
            .run("fmu scene.json --force --library library.so")
            .code,
        Some(0)
    );
    assert_eq!(archive(&folder, "scene.fmu").len(), 7);
}

#[test]
fn libraries_of_something_else_are_refused() {
    let folder = folder();
    folder.write("text.so", "not a library");
    folder.write("other.so", library(MARK, "main"));
    folder.write(
        "old.so",
        library("dcb of old", "fmi3InstantiateCoSimulation"),
    );
    for (arguments, says) in [
        (
            "--library text.so",
            "text.so: isn't a shared library for Linux, 64 bits",
        ),
        (
            "--library other.so",
            "other.so: has no function fmi3InstantiateCoSimulation",
        ),
        (
            "--library old.so",
            "old.so: is of another version than this program",
        ),
        (
            "--library library.so --library library.so",
            "one for each platform",
        ),
    ] {
        folder.refused(&format!("fmu scene.json -o new.fmu {arguments}"), &[says]);
    }
    assert!(!folder.path("new.fmu").exists());
}

#[test]
fn names_that_fmi_forbids_are_refused() {
    let folder = folder();
    let pack = "fmu scene.json -o new.fmu --library library.so";
    let angle = json!({"joint_coordinate": {"joint": "axle"}});
    folder.edit("scene.json", |scene| {
        scene["drives"]["motor"] = json!({"angle": {"joint": "axle", "input": {"initial": 0}}});
        scene["outputs"]["motor"] = angle.clone();
    });
    folder.refused(
        pack,
        &[
            "scene.json: outputs.\"motor\"",
            "an input and of an output",
            "rename",
        ],
    );
    folder.edit("scene.json", |scene| {
        scene["outputs"].as_object_mut().unwrap().remove("motor");
        scene["outputs"]["slider_position.x"] = angle.clone();
    });
    folder.refused(pack, &["slider_position.x", "different names"]);
    folder.edit("scene.json", |scene| {
        scene["outputs"]
            .as_object_mut()
            .unwrap()
            .remove("slider_position.x");
        scene["outputs"]["a\tb"] = angle.clone();
    });
    folder.refused(pack, &["a\\tb"]);
    folder.edit("scene.json", |scene| {
        scene["outputs"].as_object_mut().unwrap().remove("a\tb");
        scene["analysis"] = json!("static");
    });
    folder.refused(pack, &["analysis", "moves over time"]);
    assert!(!folder.path("new.fmu").exists());
}
