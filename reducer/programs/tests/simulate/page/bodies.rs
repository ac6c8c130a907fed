//! What bodies and solids look like.

use std::fs;

use serde_json::{Value, json};

use super::reader::Page;
use crate::support::Folder;

/// Bodies of a scene get more keys.
pub fn with(folder: &Folder, change: impl FnOnce(&mut Value)) {
    let mut scene = folder.json("scene.json");
    change(&mut scene);
    folder.write("scene.json", scene.to_string());
}

/// A second rod that stands by itself, fixed to the ground.
fn with_post(scene: &mut Value, keys: Value) {
    let mut post = json!({"superelement": "rod.dcb.h5", "position": [1, 1]});
    let keys = keys.as_object().unwrap().clone();
    post.as_object_mut().unwrap().extend(keys);
    scene["bodies"]["post"] = post;
    scene["ground"] = json!({"points": {"post": [1, 1]}});
    scene["joints"]["post"] =
        json!({"fixed": {"a": "ground/post", "b": "post/a", "orientation": "body"}});
}

#[test]
fn bodies_of_one_file_may_carry_different_coordinates() {
    let folder = Folder::slider_crank();
    with(&folder, |scene| with_post(scene, json!({"modes": 2})));
    folder.done("scene.json --end 0.001 --model everything");
    folder.done("animate scene.h5");
    let page = Page::read(&folder, "scene.html");
    let shape = |name: &str| page.body(name)["shape"].as_u64().unwrap();
    assert_ne!(shape("rod"), shape("post"));
}

#[test]
fn a_body_of_which_nothing_is_carried_is_drawn_at_rest() {
    let folder = Folder::slider_crank();
    // It floats where it is: nothing loads it.
    with(&folder, |scene| {
        scene["bodies"]["post"] = json!({"superelement": "rod.dcb.h5", "position": [1, 1]});
    });
    folder.done("scene.json --end 0.001");
    let left_out = folder
        .results()
        .channels()
        .iter()
        .all(|channel| channel.path != "motion/post/coordinates");
    assert!(
        left_out,
        "nothing moves the post: its coordinates aren't carried"
    );
    folder.done("animate scene.h5");
    let page = Page::read(&folder, "scene.html");
    let post = page.body("post");
    let shape = &page.description["shapes"][post["shape"].as_u64().unwrap() as usize];
    assert_eq!(shape["columns"], json!([]));
    assert!(!page.numbers(&shape["positions"]).is_empty());
}

#[test]
fn solids_of_the_scene_are_drawn_and_move_nothing() {
    let folder = Folder::slider_crank();
    with(&folder, |scene| {
        scene["bodies"]["crank"]["rigid"]["center_of_mass"] = json!([0.05, 0.0])
    });
    folder.done("scene.json --end 0.001 -o plain.h5");
    folder.write(
        "wedge.obj",
        "v 0 0 0\nv 20 0 0\nv 0 30 0\nv 0 0 40\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n",
    );
    with(&folder, |scene| {
        scene["bodies"]["crank"]["geometry"] = json!([
            {"cylinder": {"radius": 0.02, "from": [0, 0], "to": [0.15, 0]}, "color": "#aa3311"},
            {"box": [0.01, 0.02, 0.005], "position": [0.15, 0], "orientation": 0.5},
            {"sphere": {"radius": 0.004}}
        ]);
        scene["bodies"]["slider"]["geometry"] = json!([{"file": "wedge.obj", "scale": 0.001}]);
        scene["ground"] = json!({"geometry": [{"box": [1, 0.01, 0.1], "position": [0.5, -0.1]}]});
    });
    folder.done("scene.json --end 0.001");
    let [plain, drawn] = ["plain.h5", "scene.h5"].map(|name| {
        let results = dcb_formats::results::Results::open(folder.path(name)).unwrap();
        results.history("motion/rod/frame").unwrap()
    });
    assert_eq!(plain, drawn);
    folder.done("animate scene.h5");
    let page = Page::read(&folder, "scene.html");
    let crank = page.body("crank");
    let pin = crank["points"]
        .as_array()
        .unwrap()
        .iter()
        .find(|point| point["name"] == "pin")
        .unwrap();
    let [rod, block, ball] = [0, 1, 2].map(|index| &crank["solids"][index]);
    assert_eq!(
        (&rod["kind"], &rod["color"]),
        (&json!("cylinder"), &json!("#aa3311"))
    );
    assert!((rod["length"].as_f64().unwrap() - 0.15).abs() < 1e-12);
    // Component coordinates in the scene, from the centre of mass in the page.
    assert_eq!(block["position"], pin["position"]);
    assert_eq!(ball["position"], json!([-0.05, 0.0, 0.0]));
    let turn = block["turn"].as_array().unwrap();
    assert!((turn[3].as_f64().unwrap() - 0.25_f64.sin()).abs() < 1e-12);
    let wedge = &page.body("slider")["solids"][0];
    assert_eq!(page.numbers(&wedge["cells"]).len(), 12);
    let highest = page
        .numbers(&wedge["positions"])
        .into_iter()
        .fold(0.0, f64::max);
    assert!((highest - 0.04).abs() < 1e-8);
    assert_eq!(page.body("ground")["solids"][0]["kind"], "box");
    fs::remove_file(folder.path("wedge.obj")).unwrap();
    folder.refused(
        "animate scene.h5 --force",
        &["wedge.obj", "is not there", "geometry"],
    );
}

#[test]
fn solids_that_make_no_sense_are_refused() {
    for (solid, told) in [
        (
            json!({"box": [1, 1, 1], "sphere": {"radius": 1}}),
            "exactly one of",
        ),
        (json!({"box": [1, 0, 1]}), "expected a positive number"),
        (json!({"box": [1, 1, 1], "scale": 2}), "`scale`"),
        (
            json!({"file": "../../etc/passwd.stl"}),
            "in the folder of the scene",
        ),
        (
            json!({"file": "/etc/passwd.stl"}),
            "in the folder of the scene",
        ),
        (json!({"cylinder": {"radius": 1}}), "`from` and `to`"),
        (
            json!({"cylinder": {"radius": 1, "from": [0, 0], "to": [0, 0]}}),
            "another place",
        ),
        (json!({"sphere": {"radius": 1}, "color": "red"}), "#b0b8c4"),
        (
            json!({"sphere": {"radius": 1}, "position": [1, 2, 3]}),
            "position",
        ),
    ] {
        let folder = Folder::slider_crank();
        with(&folder, |scene| {
            scene["bodies"]["crank"]["geometry"] = json!([solid])
        });
        folder.refused("scene.json --end 0.001", &["scene.json", told]);
    }
}
